// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_tendons.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <string_view>
#include <vector>

#include "engine/formats/text.h"
#include "engine/imports/mjcf_actuator.h"
#include "engine/imports/mjcf_pull.h"

namespace thenar {

namespace {

std::string named(const XmlElement& element) {
  const std::string name = element.text("name");
  return name.empty() ? element.name : fmt::format("{} '{}'", element.name, name);
}

using Names = std::map<std::string, int>;

template <typename Items>
Names places_of_names(const Items& items) {
  Names names;
  for (std::size_t i = 0; i < items.size(); ++i) names.emplace(items[i].name, static_cast<int>(i));
  return names;
}

/// What tendons, actuators and equalities refer to, by name.
struct Named {
  explicit Named(const BodyTree& tree)
      : sites(places_of_names(tree.sites)), wraps(places_of_names(tree.wraps)), bodies(places_of_names(tree.bodies)) {
    for (const TreeBody& body : tree.bodies) {
      for (const TreeJoint& joint : body.joints) joints.emplace(joint.name, &joint);
    }
  }

  Names sites, wraps, bodies, tendons;
  std::map<std::string, const TreeJoint*> joints;
};

/// Returns the item that an attribute names; refuses the element if there is none.
int item_of(const XmlElement& element, const std::string& attribute, const Names& items, const char* kind) {
  const std::string name = element.text(attribute);
  const auto found = items.find(name);
  if (name.empty() || found == items.end()) refuse(element, fmt::format("no {} is named '{}'", kind, name));
  return found->second;
}

TreeTendon read_spatial(const XmlElement& spatial, const Named& parts) {
  TreeTendon tendon{spatial.text("name"), spatial.place, {}, std::nullopt, ""};
  TreeTendonStep next;
  for (const XmlElement& part : spatial.children) {
    if (part.name == "pulley") {
      const double divisor = number(part, "divisor").value_or(1.0);
      if (!(divisor >= 1.0)) refuse(part, "divisor: must be at least 1");
      next = TreeTendonStep{};
      next.share = 1.0 / divisor;
    } else if (part.name == "geom") {
      if (next.begins || next.wrap >= 0) refuse(part, "a tendon goes from a site around one geom to a site");
      next.wrap = item_of(part, "geom", parts.wraps, "sphere or cylinder");
      if (part.find("sidesite") != nullptr) next.side_site = item_of(part, "sidesite", parts.sites, "site");
    } else if (part.name == "site") {
      next.site = item_of(part, "site", parts.sites, "site");
      tendon.steps.push_back(next);
      const double share = next.share;
      next = TreeTendonStep{};
      next.share = share;
      next.begins = false;
    }
  }
  if (next.wrap >= 0) refuse(spatial, "ends on a geom: a site must follow it");
  return tendon;
}

/// Whether a fixed tendon has limits or a spring: else it ties joints only by what refers to it. `fixed` is completed.
bool has_limits_or_spring(const XmlElement& fixed, const MjcfDefaults& defaults) {
  if (defaults.limits(fixed, "limited", "range")) return true;
  const auto stiffness = numbers(fixed, "stiffness", 1, 3);
  return stiffness && !stiffness->isZero(0.0);
}

TreeCoupling read_fixed(const XmlElement& fixed) {
  TreeCoupling coupling{fmt::format("fixed tendon '{}'", fixed.text("name")), fixed.place, {}, 2};
  for (const XmlElement& joint : fixed.children) {
    if (joint.name == "joint") coupling.joints.push_back(joint.text("joint"));
  }
  return coupling;
}

void read_actuator(const XmlElement& actuator, const MjcfDefaults& defaults, const Named& parts, BodyTree& tree,
                   std::map<std::string, int>& left_out) {
  if (actuator.find("tendon") == nullptr) {
    ++left_out[actuator.name];
    return;
  }
  const auto found = parts.tendons.find(actuator.text("tendon"));
  if (found == parts.tendons.end()) {  // of a fixed one, which is a coupling, or of none
    ++left_out[actuator.name];
    return;
  }
  TreeTendon& tendon = tree.tendons[found->second];
  constexpr double kSomeForce_N = 100.0;
  const std::optional<double> pull = pull_N(actuator, defaults);
  if (pull && *pull <= 0.0) {
    tree.notes.push_back(named(actuator) + " is left out: it can only push its tendon");
    return;
  }
  if (tendon.max_force_N) {
    tree.notes.push_back(
        fmt::format("{} pulls the tendon of '{}', which has both forces", named(actuator), tendon.muscle));
  }
  if (!pull) {
    tree.notes.push_back(
        fmt::format("{} does not say its force: it is taken as {:g} N", named(actuator), kSomeForce_N));
  }
  tendon.max_force_N = tendon.max_force_N.value_or(0.0) + pull.value_or(kSomeForce_N);
  if (tendon.muscle.empty()) tendon.muscle = actuator.text("name");
}

/// Returns the body that an attribute names, or that its site is on; the world if it is missing.
int body_of(const XmlElement& element, const std::string& number, const Named& parts, const BodyTree& tree) {
  const std::string body = "body" + number, site = "site" + number;
  if (element.find(site) != nullptr) return tree.sites[item_of(element, site, parts.sites, "site")].body;
  return element.find(body) == nullptr ? 0 : item_of(element, body, parts.bodies, "body");
}

const TreeJoint* joint_named(const Named& parts, const std::string& name) {
  const auto found = parts.joints.find(name);
  return found == parts.joints.end() ? nullptr : found->second;
}

[[noreturn]] void refuse_joint(const XmlElement& equality, const std::string& name, const BodyTree& tree) {
  refuse(equality, fmt::format("no joint is named '{}'{}", name, did_you_mean(nearest_word(name, joint_names(tree)))));
}

/// Reads a coupling: with the references y_0 and x_0 of its joints, y - y_0 = a_0 + a_1 (x - x_0) + a_2 (x - x_0)^2 +
/// ...
TreeCoupling read_joint_equality(const XmlElement& equality, const std::string& what, const Named& parts,
                                 const BodyTree& tree) {
  TreeCoupling coupling{what, equality.place, {equality.text("joint1")}};
  std::vector<double> a{0.0, 1.0, 0.0, 0.0, 0.0};
  const auto given = numbers(equality, "polycoef", 1, 5);
  if (given) std::copy(given->begin(), given->end(), a.begin());
  const TreeJoint* const one = joint_named(parts, coupling.joints[0]);
  if (one == nullptr) refuse_joint(equality, coupling.joints[0], tree);
  const bool holds =
      equality.find("joint2") == nullptr || std::all_of(a.begin() + 1, a.end(), [](double x) { return x == 0.0; });
  if (equality.find("joint2") != nullptr) coupling.joints.push_back(equality.text("joint2"));
  if (holds) {
    coupling.fault = fmt::format("to nothing but the angle {:g} deg, where it stays",
                                 180.0 / std::numbers::pi * (one->reference + a[0]));
    return coupling;
  }
  const TreeJoint* const other = joint_named(parts, coupling.joints[1]);
  if (other == nullptr) refuse_joint(equality, coupling.joints[1], tree);
  if (a[2] != 0.0 || a[3] != 0.0 || a[4] != 0.0) {
    coupling.fault = "by a polynomial, and a joint follows another one by a multiple of its angle";
  } else {
    coupling.line = {a[1], one->reference + a[0] - a[1] * other->reference};
  }
  return coupling;
}

void read_equality(const XmlElement& equality, const Named& parts, BodyTree& tree) {
  if (equality.text("active") == "false") return;
  const std::string what = fmt::format("equality {}", named(equality));
  if (equality.name == "connect" || equality.name == "weld") {
    tree.loops.push_back(
        {what, equality.place, {body_of(equality, "1", parts, tree), body_of(equality, "2", parts, tree)}});
  } else if (equality.name == "joint") {
    tree.couplings.push_back(read_joint_equality(equality, what, parts, tree));
  } else if (equality.name == "tendon") {
    tree.notes.push_back(what + " is left out");
  }
}

}  // namespace

void read_ties(const XmlElement& mujoco, const MjcfDefaults& defaults, BodyTree& tree) {
  // Sections are in any order, and refer to one another.
  const auto each = [&](const char* section, const auto& read) {
    for (const XmlElement& element : mujoco.children) {
      if (element.name != section) continue;
      for (const XmlElement& child : element.children) read(child);
    }
  };
  Named parts(tree);
  std::set<std::string> tied;  // Tendons that actuators or equalities refer to.
  each("actuator", [&](const XmlElement& actuator) { tied.insert(actuator.text("tendon")); });
  each("equality", [&](const XmlElement& equality) {
    if (equality.name != "tendon" || defaults.completed(equality, "", "equality").text("active") == "false") return;
    tied.insert(equality.text("tendon1"));
    tied.insert(equality.text("tendon2"));
  });
  tied.erase("");  // Of actuators that drive something else.
  each("tendon", [&](const XmlElement& tendon) {
    if (tendon.name == "spatial") {
      const bool is_new = parts.tendons.emplace(tendon.text("name"), static_cast<int>(tree.tendons.size())).second;
      if (!is_new && !tendon.text("name").empty()) refuse(tendon, "is there twice");
      tree.tendons.push_back(read_spatial(tendon, parts));
    } else if (tendon.name == "fixed") {
      const XmlElement whole = defaults.completed(tendon, "", "tendon");
      if (tied.contains(tendon.text("name")) || has_limits_or_spring(whole, defaults))
        tree.couplings.push_back(read_fixed(tendon));
    }
  });
  std::map<std::string, int> left_out;
  each("actuator", [&](const XmlElement& element) {
    read_actuator(defaults.completed(as_general(element), "", "general"), defaults, parts, tree, left_out);
  });
  for (const auto& [kind, number] : left_out) {
    tree.notes.push_back(fmt::format("{} of joints left out: joints are driven by torques or muscles",
                                     counted(number, kind + " actuator")));
  }
  each("equality",
       [&](const XmlElement& element) { read_equality(defaults.completed(element, "", "equality"), parts, tree); });
}

}  // namespace thenar
