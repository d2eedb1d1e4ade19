// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/xml_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <pugixml.hpp>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kMostNumber = 1e6;

std::string place_at(const std::filesystem::path& file, std::string_view text, std::ptrdiff_t offset) {
  const auto end = text.begin() + std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text));
  return fmt::format("{}:{}", file.string(), 1 + std::count(text.begin(), end, '\n'));
}

/// Line numbers of places in the order of the text.
class LineCounter {
 public:
  LineCounter(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {}

  std::string place(std::ptrdiff_t offset) {
    const auto end = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text_)));
    if (end >= at_) {
      line_ += std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                          text_.begin() + static_cast<std::ptrdiff_t>(end), '\n');
      at_ = end;
    }
    return fmt::format("{}:{}", file_.string(), line_);
  }

 private:
  const std::filesystem::path& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::ptrdiff_t line_ = 1;
};

/// What stops the parser, in plain words.
std::string in_words(const pugi::xml_parse_result& result) {
  switch (result.status) {
    case pugi::status_no_document_element:
      return "it has no element; MJCF begins with <mujoco>, URDF with <robot>";
    case pugi::status_end_element_mismatch:
      return "this tag closes another element than the last one that is open, or an element is not closed";
    case pugi::status_bad_attribute:
      return "an attribute is written as name=\"value\", and a '\"' is missing here or in a line above";
    case pugi::status_bad_start_element:
    case pugi::status_bad_end_element:
      return "a tag is broken off: '>' is missing";
    case pugi::status_bad_comment:
      return "a comment is not closed: '-->' is missing";
    default:
      return printable(result.description());
  }
}

XmlElement converted(const pugi::xml_node& node, LineCounter& lines, int depth, std::size_t& left) {
  XmlElement element;
  element.name = node.name();
  element.place = lines.place(node.offset_debug());
  if (depth > kMostXmlDepth) refuse(element, fmt::format("is more than {} elements deep", kMostXmlDepth));
  if (left == 0) refuse(element, fmt::format("is beyond {} elements", kMostXmlElements));
  --left;
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    if (element.find(attribute.name()) != nullptr) refuse(element, fmt::format("names {} twice", attribute.name()));
    if (element.attributes.size() == kMostXmlAttributes) {
      refuse(element, fmt::format("has more than {} attributes", kMostXmlAttributes));
    }
    element.attributes.emplace_back(attribute.name(), attribute.value());
    if (first_unprintable(attribute.value()) != std::string_view::npos) {
      refuse(element, fmt::format("{}: '{}' is no line of printable UTF-8", attribute.name(), attribute.value()));
    }
  }
  for (const pugi::xml_node& child : node.children()) {
    if (child.type() == pugi::node_element) element.children.push_back(converted(child, lines, depth + 1, left));
  }
  return element;
}

}  // namespace

const std::string* XmlElement::find(std::string_view attribute) const {
  const auto found = std::ranges::find(attributes, attribute, &std::pair<std::string, std::string>::first);
  return found == attributes.end() ? nullptr : &found->second;
}

std::string XmlElement::text(std::string_view attribute) const {
  const std::string* const value = find(attribute);
  return value == nullptr ? "" : *value;
}

const XmlElement* XmlElement::child(std::string_view child_name) const {
  const auto found = std::ranges::find(children, child_name, &XmlElement::name);
  return found == children.end() ? nullptr : &*found;
}

XmlElement read_xml(const std::filesystem::path& file, std::size_t& left) try {
  const std::string text = read_file(file);
  pugi::xml_document document;
  const pugi::xml_parse_result result =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (result.status == pugi::status_out_of_memory) throw std::bad_alloc();
  if (!result) {
    throw ConfigError(
        {{printable(place_at(file, text, result.offset)), "", fmt::format("is no XML: {}", in_words(result))}});
  }
  LineCounter lines(file, text);
  return converted(document.document_element(), lines, 0, left);
} catch (const std::bad_alloc&) {
  throw ReadError(file, "does not fit into memory");
}

void refuse(const XmlElement& element, std::string_view what) {
  const std::string name = element.text("name");
  const std::string key = name.empty() ? element.name : fmt::format("{} '{}'", element.name, name);
  throw ConfigError({{printable(element.place), printable(key), printable(what)}});
}

std::optional<VectorXd> numbers(const XmlElement& element, std::string_view attribute, int least, int most) {
  const std::string* const value = element.find(attribute);
  if (value == nullptr) return std::nullopt;
  const std::vector<std::string_view> words = words_of(*value);
  if (std::ssize(words) < least || std::ssize(words) > most) {
    const std::string wanted = least == most ? fmt::format("{}", most) : fmt::format("{} to {}", least, most);
    refuse(element, fmt::format("{} must be {} numbers, not '{}'", attribute, wanted, *value));
  }
  VectorXd found(std::ssize(words));
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string_view word = words[i];
    if (word.starts_with('+')) word.remove_prefix(1);
    const std::optional<double> number = number_in<double>(word);
    if (!number || !(std::abs(*number) <= kMostNumber)) {
      refuse(element, fmt::format("{}: '{}' is no number within 1e6", attribute, words[i]));
    }
    found[static_cast<Eigen::Index>(i)] = *number;
  }
  return found;
}

std::optional<double> number(const XmlElement& element, std::string_view attribute) {
  const std::optional<VectorXd> found = numbers(element, attribute, 1, 1);
  return found ? std::optional((*found)[0]) : std::nullopt;
}

std::optional<Vector3d> vector3(const XmlElement& element, std::string_view attribute) {
  const std::optional<VectorXd> found = numbers(element, attribute, 3, 3);
  return found ? std::optional<Vector3d>(*found) : std::nullopt;
}

std::optional<Vector3d> direction(const XmlElement& element, std::string_view attribute) {
  const std::optional<Vector3d> found = vector3(element, attribute);
  if (!found) return std::nullopt;
  // Shorter ones lose digits when they are squared.
  if (!(found->norm() > 1e-10)) refuse(element, fmt::format("{}: a direction must not be zero", attribute));
  return found->normalized();
}

}  // namespace thenar
