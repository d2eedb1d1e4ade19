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

  /// The element with what its class, else `childclass`, else the file's first class gives it and it does not name
  /// itself. Throws ConfigError for a class that is not there.
  [[nodiscard]] XmlElement completed(const XmlElement& element, const std::string& childclass) const;

  /// A setting of the compiler; empty if the file does not name it.
  [[nodiscard]] std::string compiler(std::string_view setting) const;

 private:
  using Elements = std::map<std::string, XmlElement>;  ///< By what they are defaults of.
  void read(const XmlElement& section, Elements inherited, bool is_first);

  std::map<std::string, Elements> classes_;
  std::string first_ = "main";
  XmlElement compiler_;
};

}  // namespace thenar
