// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_defaults.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engine/formats/byte_source.h"
#include "engine/imports/mjcf_actuator.h"

namespace thenar {

namespace {

constexpr std::size_t kMostElements = 10'000;  // Each has up to kMostXmlAttributes.

/// Returns numbers with those of the class that they do not reach to: MuJoCo takes fewer of these attributes.
std::string continued(const std::string& attribute, const std::string& value, const std::string& of_class) {
  if (attribute != "size" && attribute != "gear") return value;
  const std::vector<std::string_view> own = words_of(value), all = words_of(of_class);
  std::string whole = value;
  for (std::size_t i = own.size(); i < all.size(); ++i) whole += " " + std::string(all[i]);
  return whole;
}

/// Copies the attributes of `from`, which take precedence.
void overwrite(XmlElement& element, const XmlElement& from) {
  for (const auto& [attribute, value] : from.attributes) {
    const auto own = std::ranges::find(element.attributes, attribute, &std::pair<std::string, std::string>::first);
    if (own != element.attributes.end()) {
      own->second = continued(attribute, value, own->second);
      continue;
    }
    if (element.attributes.size() == kMostXmlAttributes) {
      refuse(from, fmt::format("has more than {} attributes, with those that its class or other sections give it",
                               kMostXmlAttributes));
    }
    element.attributes.emplace_back(attribute, value);
  }
}

}  // namespace

const XmlElement* MjcfDefaults::Class::find(const std::string& element) const {
  for (const Class* at = this; at != nullptr; at = at->outer) {
    if (const auto found = at->elements.find(element); found != at->elements.end()) return &found->second;
  }
  return nullptr;
}

MjcfDefaults::MjcfDefaults(const XmlElement& mujoco) {
  bool is_first = true;
  int sections = 0;
  for (const XmlElement& section : mujoco.children) {
    if (section.name == "compiler") overwrite(compiler_, section);
    if (section.name != "default") continue;
    const std::string* const name = section.find("class");
    if (is_first && name != nullptr) first_ = *name;
    if (!is_first && name != nullptr && *name != first_) {
      refuse(section, fmt::format("the class '{}' stands in no other, and '{}' is the first", *name, first_));
    }
    if (++sections > kMostXmlDepth) refuse(section, fmt::format("is beyond {} sections of defaults", kMostXmlDepth));
    const auto before = classes_.find(first_);
    read(section, add(first_, before == classes_.end() ? nullptr : before->second));
    is_first = false;
  }
  if (!classes_.contains(first_)) add(first_, nullptr);
}

MjcfDefaults::Class& MjcfDefaults::add(const std::string& name, const Class* outer) {
  Class& made = all_.emplace_back();
  made.outer = outer;
  classes_[name] = &made;
  return made;
}

void MjcfDefaults::read(const XmlElement& section, Class& into) {
  for (const XmlElement& element : section.children) {
    if (element.name == "default") continue;
    if (++elements_ > kMostElements) refuse(element, fmt::format("is beyond {} elements of defaults", kMostElements));
    const std::string kind = is_actuator(element.name) ? "general" : element.name;
    const auto [own, is_new] = into.elements.try_emplace(kind);
    const XmlElement* const outer = is_new && into.outer != nullptr ? into.outer->find(kind) : nullptr;
    if (outer != nullptr) own->second = *outer;
    overwrite(own->second, is_actuator(element.name) ? as_general(element) : element);
  }
  for (const XmlElement& inner : section.children) {
    if (inner.name != "default") continue;
    const std::string name = inner.text("class");
    if (name.empty()) refuse(inner, "a class within another one needs a name: class=...");
    if (classes_.contains(name)) refuse(inner, fmt::format("the class '{}' is there twice", name));
    read(inner, add(name, &into));
  }
}

XmlElement MjcfDefaults::completed(const XmlElement& element, const std::string& childclass,
                                   const std::string& kind) const {
  const std::string* const own = element.find("class");
  const std::string& name = own != nullptr ? *own : childclass.empty() ? first_ : childclass;
  const auto found = classes_.find(name);
  if (found == classes_.end()) refuse(element, fmt::format("no class is named '{}'", name));
  XmlElement whole;
  if (const XmlElement* const defaults = found->second->find(kind.empty() ? element.name : kind)) {
    whole.attributes = defaults->attributes;
  }
  whole.name = element.name;
  whole.place = element.place;
  overwrite(whole, element);
  return whole;
}

bool MjcfDefaults::limits(const XmlElement& element, std::string_view limited, std::string_view range) const {
  const std::string says = element.text(limited);
  return says == "true" || (says != "false" && element.find(range) != nullptr && compiler("autolimits") != "false");
}

std::string MjcfDefaults::compiler(std::string_view setting) const { return compiler_.text(setting); }

}  // namespace thenar
