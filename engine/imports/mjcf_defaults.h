#pragma once

#include <map>
#include <string>
#include <string_view>

#include "engine/imports/xml_tree.h"

namespace thenar {

/// The `default` sections of an MJCF file, and its `compiler`.
class MjcfDefaults {
 public:
  /// Reads both from all sections of the file. Throws ConfigError.
  explicit MjcfDefaults(const XmlElement& mujoco);

  /// Returns the element with missing attributes set by its class, else by `childclass`, else by the file's first
  /// class. Throws ConfigError for an unknown class.
  [[nodiscard]] XmlElement completed(const XmlElement& element, const std::string& childclass) const;

  /// Returns a setting of the compiler; empty if the file does not have it.
  [[nodiscard]] std::string compiler(std::string_view setting) const;

 private:
  using Elements = std::map<std::string, XmlElement>;  ///< Defaults by element name.
  void read(const XmlElement& section, Elements inherited, bool is_first);

  std::map<std::string, Elements> classes_;
  std::string first_ = "main";
  XmlElement compiler_;
};

}  // namespace thenar
