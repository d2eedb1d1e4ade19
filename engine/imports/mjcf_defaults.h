// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
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
  /// class. `kind` is its name in classes, where that is another one: tendon, equality, general. Throws ConfigError for
  /// an unknown class.
  [[nodiscard]] XmlElement completed(const XmlElement& element, const std::string& childclass,
                                     const std::string& kind = {}) const;

  /// Tests whether a range of a completed element holds, by its attribute of limits or by the compiler's autolimits.
  [[nodiscard]] bool limits(const XmlElement& element, std::string_view limited, std::string_view range) const;

  /// Returns a setting of the compiler; empty if the file does not have it.
  [[nodiscard]] std::string compiler(std::string_view setting) const;

 private:
  /// A class, with the elements that it names; it has the others from the enclosing class, or, if it goes on in another
  /// section, from itself as it was: classes inherit what there is where they stand.
  struct Class {
    std::map<std::string, XmlElement> elements;  ///< With the attributes of enclosing classes, by element name.
    const Class* outer = nullptr;

    /// Returns the defaults of an element, from the innermost class that names it; null if there are none.
    [[nodiscard]] const XmlElement* find(const std::string& element) const;
  };
  void read(const XmlElement& section, Class& into);

  Class& add(const std::string& name, const Class* outer);

  std::list<Class> all_;
  std::map<std::string, const Class*> classes_;  ///< The newest of each name.
  std::size_t elements_ = 0;                     ///< Of all classes.
  std::string first_ = "main";
  XmlElement compiler_;
};

}  // namespace thenar
