#include "engine/imports/mjcf_include.h"

#include <fmt/format.h>

#include <set>
#include <utility>
#include <vector>

#include "engine/formats/files.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

void include_into(XmlElement& element, const fs::path& first, const fs::path& current, std::set<fs::path>& read) {
  std::vector<XmlElement> children;
  for (XmlElement& child : element.children) {
    if (child.name != "include") {
      include_into(child, first, current, read);
      children.push_back(std::move(child));
      continue;
    }
    const std::string name = child.text("file");
    if (name.empty()) refuse(child, "names no file");
    fs::path file = (first.parent_path() / name).lexically_normal();
    if (!is_readable(file)) file = (current.parent_path() / name).lexically_normal();
    if (!is_readable(file)) refuse(child, fmt::format("there is no file '{}'", name));
    // As in MuJoCo; so no file includes itself either.
    if (!read.insert(file).second) refuse(child, fmt::format("'{}' is included twice", name));
    XmlElement included = read_xml(file);
    include_into(included, first, file, read);
    for (XmlElement& inner : included.children) children.push_back(std::move(inner));
  }
  element.children = std::move(children);
}

}  // namespace

void include_files(XmlElement& root, const fs::path& file) {
  std::set<fs::path> read{file.lexically_normal()};
  include_into(root, file, file, read);
}

}  // namespace thenar
