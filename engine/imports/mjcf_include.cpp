// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_include.h"

#include <fmt/format.h>

#include <set>
#include <utility>
#include <vector>

#include "engine/formats/files.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

struct Including {
  const fs::path& first;
  std::set<fs::path> read;
  std::size_t& left;
};

/// `depth`: elements above, and files whose include elements stood in their places.
void include_into(XmlElement& element, const fs::path& current, int depth, Including& all) {
  if (depth > kMostXmlDepth) {
    refuse(element, fmt::format("is more than {} elements and included files deep", kMostXmlDepth));
  }
  std::vector<XmlElement> children;
  for (XmlElement& child : element.children) {
    if (child.name != "include") {
      include_into(child, current, depth + 1, all);
      children.push_back(std::move(child));
      continue;
    }
    const std::string name = child.text("file");
    if (name.empty()) refuse(child, "names no file");
    fs::path file = (all.first.parent_path() / name).lexically_normal();
    if (!is_readable(file)) file = (current.parent_path() / name).lexically_normal();
    if (!is_readable(file)) refuse(child, fmt::format("there is no file '{}'", name));
    // As in MuJoCo; so no file includes itself either.
    if (!all.read.insert(file).second) refuse(child, fmt::format("'{}' is included twice", name));
    XmlElement included = read_xml(file, all.left);
    include_into(included, file, depth + 1, all);
    for (XmlElement& inner : included.children) children.push_back(std::move(inner));
  }
  element.children = std::move(children);
}

}  // namespace

void include_files(XmlElement& root, const fs::path& file, std::size_t& left) {
  Including all{file, {file.lexically_normal()}, left};
  include_into(root, file, 0, all);
}

}  // namespace thenar
