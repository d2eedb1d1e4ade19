// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/urdf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "engine/formats/text.h"

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kMostLinks = 10'000;

/// Returns the pose of an element's `origin`: roll, pitch and yaw are rotations about the fixed x, y and z.
Isometry3d origin_of(const XmlElement& element) {
  Isometry3d X = Isometry3d::Identity();
  const XmlElement* const origin = element.child("origin");
  if (origin == nullptr) return X;
  X.translation() = vector3(*origin, "xyz").value_or(Vector3d::Zero());
  const Vector3d rpy = vector3(*origin, "rpy").value_or(Vector3d::Zero());
  X.linear() = (AngleAxisd(rpy[2], Vector3d::UnitZ()) * AngleAxisd(rpy[1], Vector3d::UnitY()) *
                AngleAxisd(rpy[0], Vector3d::UnitX()))
                   .toRotationMatrix();
  return X;
}

/// Reads a capsule, an extension of URDF in several simulators: `length` is that of its straight part along z.
TreeRound read_capsule(const XmlElement& capsule, const Isometry3d& X_BC) {
  constexpr double kLeastLength_m = 1e-4;  // Shorter, and it is a sphere.
  TreeRound round{number(capsule, "radius").value_or(0.0), std::nullopt, X_BC.translation()};
  const double length_m = number(capsule, "length").value_or(0.0);
  if (length_m < kLeastLength_m) return round;
  Eigen::Matrix3d axes;
  axes << X_BC.linear().col(2), X_BC.linear().col(0), X_BC.linear().col(1);
  round.shape = PulpShape{PulpShape::Form::kCapsule, axes, {0.5 * length_m, round.radius_m, round.radius_m}};
  return round;
}

/// Whether a link has a shape and no mass: by the format it weighs nothing, which its author may not have meant.
bool lacks_mass(const XmlElement& link) {
  return link.child("inertial") == nullptr && (link.child("collision") != nullptr || link.child("visual") != nullptr);
}

TreeBody read_link(const XmlElement& link) {
  TreeBody body;
  body.name = link.text("name");
  body.place = link.place;
  body.X_PB.setIdentity();
  if (body.name.empty()) refuse(link, "has no name");
  if (const XmlElement* const inertial = link.child("inertial")) {
    const XmlElement* const mass = inertial->child("mass");
    if (mass != nullptr) body.mass_kg = number(*mass, "value").value_or(0.0);
    if (body.mass_kg < 0.0) refuse(*mass, "must not be negative");
    body.com_m = origin_of(*inertial).translation();
  }
  for (const XmlElement& collision : link.children) {
    if (collision.name != "collision") continue;
    const XmlElement* const geometry = collision.child("geometry");
    if (geometry == nullptr) continue;
    const Isometry3d X_BC = origin_of(collision);
    if (const XmlElement* const sphere = geometry->child("sphere")) {
      body.rounds.push_back({number(*sphere, "radius").value_or(0.0), std::nullopt, X_BC.translation()});
    } else if (const XmlElement* const capsule = geometry->child("capsule")) {
      body.rounds.push_back(read_capsule(*capsule, X_BC));
    }
  }
  return body;
}

std::array<double, 2> read_limits(const XmlElement& joint) {
  const XmlElement* const limit = joint.child("limit");
  if (limit == nullptr) refuse(joint, "has no limits: a hand's joint needs <limit lower=... upper=.../>");
  const std::array<double, 2> range{number(*limit, "lower").value_or(0.0), number(*limit, "upper").value_or(0.0)};
  if (!(range[0] < range[1])) {
    refuse(joint,
           fmt::format("has no limits: its lower one, {:g}, is not below its upper one, {:g}", range[0], range[1]));
  }
  return range;
}

/// Returns the joint of the child link; nothing if it is fixed.
std::vector<TreeJoint> read_joint(const XmlElement& element) {
  TreeJoint joint;
  joint.name = element.text("name");
  joint.place = element.place;
  if (joint.name.empty()) refuse(element, "has no name");
  const std::string type = element.text("type");
  if (type == "fixed") return {};
  if (type == "floating") {
    joint.kind = TreeJointKind::kFree;
  } else if (type == "revolute" || type == "continuous" || type == "prismatic") {
    const XmlElement* const axis = element.child("axis");
    joint.axis = axis == nullptr ? Vector3d::UnitX() : direction(*axis, "xyz").value_or(Vector3d::UnitX());
    joint.kind = type == "prismatic" ? TreeJointKind::kSlide : TreeJointKind::kHinge;
    if (type == "revolute") joint.range = read_limits(element);
  } else {
    refuse(element,
           fmt::format("a joint of the type '{}' is none of fixed, revolute, continuous, prismatic, floating", type));
  }
  return {joint};
}

/// The data of a joint about the links at its ends.
struct LinkJoint {
  const XmlElement* element = nullptr;
  std::string parent;
};

std::string end_of(const XmlElement& joint, const char* end) {
  const XmlElement* const element = joint.child(end);
  const std::string link = element == nullptr ? "" : element->text("link");
  if (link.empty()) refuse(joint, fmt::format("names no {} link", end));
  return link;
}

/// Adds the links below one, each after its parent.
void add_children(const std::map<std::string, std::vector<LinkJoint>>& joints_below,
                  const std::map<std::string, const XmlElement*>& links, BodyTree& tree) {
  for (std::size_t next = 1; next < tree.bodies.size(); ++next) {
    const auto below = joints_below.find(tree.bodies[next].name);
    if (below == joints_below.end()) continue;
    for (const LinkJoint& joint : below->second) {
      TreeBody body = read_link(*links.at(end_of(*joint.element, "child")));
      body.parent = static_cast<int>(next);
      body.X_PB = origin_of(*joint.element);
      body.joints = read_joint(*joint.element);
      tree.bodies.push_back(std::move(body));
    }
  }
}

/// Macros may stand anywhere, also in a link or a joint.
void refuse_macros(const XmlElement& element) {
  if (element.name.starts_with("xacro:")) refuse(element, "is a macro: expand the file with xacro first");
  for (const XmlElement& child : element.children) refuse_macros(child);
}

}  // namespace

BodyTree read_urdf(const XmlElement& robot) {
  std::map<std::string, const XmlElement*> links, joints_above, joint_names;
  std::map<std::string, std::vector<LinkJoint>> joints_below;
  BodyTree tree = empty_tree();
  int massless = 0;
  refuse_macros(robot);
  for (const XmlElement& element : robot.children) {
    if (element.name != "link") continue;
    if (!links.emplace(element.text("name"), &element).second) refuse(element, "is there twice");
    massless += lacks_mass(element) ? 1 : 0;
  }
  if (massless > 0)
    tree.notes.push_back(counted(massless, "link") + " without inertial: no mass, as the format has it");
  if (links.size() > kMostLinks) refuse(robot, fmt::format("has more than {} links", kMostLinks));
  for (const XmlElement& element : robot.children) {
    if (element.name != "joint") continue;
    const std::string child = end_of(element, "child"), parent = end_of(element, "parent");
    for (const std::string& link : {child, parent}) {
      if (!links.contains(link)) refuse(element, fmt::format("no link is named '{}'", link));
    }
    if (!joint_names.emplace(element.text("name"), &element).second) refuse(element, "is there twice");
    const auto [other, is_first] = joints_above.emplace(child, &element);
    if (!is_first) {
      refuse(element,
             fmt::format("closes a loop: joint '{}' also carries the link '{}'", other->second->text("name"), child));
    }
    joints_below[parent].push_back({&element, parent});
    if (const XmlElement* const mimic = element.child("mimic")) {
      const std::string leader = mimic->text("joint");
      const double ratio = number(*mimic, "multiplier").value_or(1.0),
                   offset_rad = number(*mimic, "offset").value_or(0.0);
      TreeCoupling coupling{fmt::format("mimic of '{}'", leader), mimic->place, {element.text("name"), leader}};
      coupling.line = {ratio, offset_rad};
      if (ratio == 0.0) {
        coupling.line.reset();
        coupling.joints.pop_back();
        coupling.fault = fmt::format("to nothing but the angle {:g} rad, where it stays", offset_rad);
      }
      tree.couplings.push_back(coupling);
    }
  }
  for (const auto& [name, link] : links) {
    if (joints_above.contains(name)) continue;
    tree.bodies.push_back(read_link(*link));
  }
  add_children(joints_below, links, tree);
  if (tree.bodies.size() <= links.size()) refuse(robot, "closes a loop: some links hang on none that no joint carries");
  return tree;
}

}  // namespace thenar
