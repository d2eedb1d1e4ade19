// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// An element of an XML file with its descendants; text between elements is not kept.
struct XmlElement {
  std::string name;
  std::string place;  ///< "file:line"
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<XmlElement> children;

  /// Returns the attribute's value; null if it is missing.
  [[nodiscard]] const std::string* find(std::string_view attribute) const;
  /// Returns the attribute's value, or an empty text.
  [[nodiscard]] std::string text(std::string_view attribute) const;
  /// Returns the first child of this name; null if there is none.
  [[nodiscard]] const XmlElement* child(std::string_view name) const;
};

/// Bounds of what is read of untrusted files. Elements: of a file with all that it includes.
inline constexpr int kMostXmlDepth = 200;
inline constexpr std::size_t kMostXmlElements = 500'000, kMostXmlAttributes = 100;

/// Reads an XML file in UTF-8 and returns its root. The file is untrusted: elements beyond a depth of kMostXmlDepth,
/// `left` elements, from which it takes those that it reads, or kMostXmlAttributes attributes of one are refused.
/// Throws ReadError if there is no such file or memory, and ConfigError with the line if it is no XML.
[[nodiscard]] XmlElement read_xml(const std::filesystem::path& file, std::size_t& left);

/// Throws ConfigError: "file:line: joint 'name': what".
[[noreturn]] void refuse(const XmlElement& element, std::string_view what);

/// Returns the numbers of an attribute, between blanks: finite, and at most 1e6 in size; nothing if it is missing.
/// Throws ConfigError unless there are `least` to `most` of them.
[[nodiscard]] std::optional<Eigen::VectorXd> numbers(const XmlElement& element, std::string_view attribute, int least,
                                                     int most);
[[nodiscard]] std::optional<double> number(const XmlElement& element, std::string_view attribute);
[[nodiscard]] std::optional<Eigen::Vector3d> vector3(const XmlElement& element, std::string_view attribute);
/// Returns a unit vector in the direction of three numbers. Throws ConfigError if they are all zero.
[[nodiscard]] std::optional<Eigen::Vector3d> direction(const XmlElement& element, std::string_view attribute);

}  // namespace thenar
