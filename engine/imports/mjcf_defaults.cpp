#include "engine/imports/mjcf_defaults.h"

#include <fmt/format.h>

#include <utility>

namespace thenar {

namespace {

/// Copies the attributes of `from`, which take precedence.
void overwrite(XmlElement& element, const XmlElement& from) {
  for (const auto& [attribute, value] : from.attributes) {
    bool known = false;
    for (auto& [own, own_value] : element.attributes) {
      if (own != attribute) continue;
      own_value = value;
      known = true;
    }
    if (!known) element.attributes.emplace_back(attribute, value);
  }
}

}  // namespace

MjcfDefaults::MjcfDefaults(const XmlElement& mujoco) {
  bool is_first = true;
  for (const XmlElement& section : mujoco.children) {
    if (section.name == "compiler") overwrite(compiler_, section);
    if (section.name != "default") continue;
    const std::string* const name = section.find("class");
    if (is_first && name != nullptr) first_ = *name;
    if (!is_first && name != nullptr && *name != first_) {
      refuse(section, fmt::format("the class '{}' stands in no other, and '{}' is the first", *name, first_));
    }
    const auto known = classes_.find(first_);
    read(section, known == classes_.end() ? Elements() : known->second, true);
    is_first = false;
  }
  classes_.try_emplace(first_);
}

// A class inherits from the enclosing one, and then has its own.
void MjcfDefaults::read(const XmlElement& section, Elements elements, bool is_first) {
  const std::string name = is_first ? first_ : section.text("class");
  if (name.empty()) refuse(section, "a class within another one needs a name: class=...");
  if (!is_first && classes_.contains(name)) refuse(section, fmt::format("the class '{}' is there twice", name));
  for (const XmlElement& element : section.children) {
    if (element.name == "default") continue;
    overwrite(elements[element.name], element);
  }
  classes_[name] = elements;
  for (const XmlElement& inner : section.children) {
    if (inner.name == "default") read(inner, elements, false);
  }
}

XmlElement MjcfDefaults::completed(const XmlElement& element, const std::string& childclass) const {
  const std::string* const own = element.find("class");
  const std::string& name = own != nullptr ? *own : childclass.empty() ? first_ : childclass;
  const auto found = classes_.find(name);
  if (found == classes_.end()) refuse(element, fmt::format("no class is named '{}'", name));
  XmlElement whole;
  if (const auto defaults = found->second.find(element.name); defaults != found->second.end()) whole = defaults->second;
  whole.name = element.name;
  whole.place = element.place;
  overwrite(whole, element);
  return whole;
}

std::string MjcfDefaults::compiler(std::string_view setting) const { return compiler_.text(setting); }

}  // namespace thenar
