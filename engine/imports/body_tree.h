// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/hand/hand.h"
#include "thenar/eigen_layout.h"

/// A mechanism as described by MJCF and URDF: a tree of bodies, the elements fixed in them, and their constraints.
/// Lengths in m, angles in rad. `place` is "file:line".
namespace thenar {

enum class TreeJointKind { kHinge, kSlide, kBall, kFree };

/// A joint of a body, which moves it and its descendants relative to the body's parent; several act in sequence.
struct TreeJoint {
  std::string name, place;
  TreeJointKind kind = TreeJointKind::kHinge;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< Body frame.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< Body frame, unit.
  double reference = 0.0;                              ///< Its value at the file's poses of the bodies.
  std::optional<std::array<double, 2>> range;          ///< Nothing: no limits.
};

/// A shape that can be a pulp: a sphere, an ellipsoid or a capsule.
struct TreeRound {
  double radius_m = 0.0;           ///< Radius of the sphere, or of the largest one about the centre inside the shape.
  std::optional<PulpShape> shape;  ///< Nothing: a sphere. Its axes are in the body frame.
  Eigen::Vector3d centre_m;        ///< Body frame.
};

struct TreeBody {
  std::string name, place;
  int parent = 0;          ///< Index of the parent, before this one; 0 for the world itself.
  Eigen::Isometry3d X_PB;  ///< Pose in its parent.
  std::vector<TreeJoint> joints;
  double mass_kg = 0.0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();  ///< Body frame.
  std::vector<TreeRound> rounds;
};

struct TreeSite {
  std::string name, place;
  int body = 0;
  Eigen::Isometry3d X_BS;
};

/// A surface that a tendon may wrap around: a sphere, or an infinite cylinder about its z axis.
struct TreeWrap {
  std::string name;
  int body = 0;
  Eigen::Isometry3d X_BG;
  double radius_m = 0.0;
  bool is_cylinder = false;
};

/// A step of a tendon from site to site, around at most one surface between two of them.
struct TreeTendonStep {
  int site = -1;
  int wrap = -1;       ///< Surface between the last site and this one; -1: straight.
  int side_site = -1;  ///< Site on its side of the surface; -1: the shorter side.
  double share = 1.0;  ///< Share of the muscle's force, between the last site and this one.
  bool begins = true;  ///< True if the tendon does not connect the last site to this one.
};

struct TreeTendon {
  std::string name, place;
  std::vector<TreeTendonStep> steps;
  std::optional<double> max_force_N;  ///< Nothing: no muscle pulls it.
  std::string muscle;                 ///< The muscle's name.
};

/// A coupling of joints: the first follows the second.
struct TreeCoupling {
  std::string what, place;  ///< "equality 'x'"
  std::vector<std::string> joints;
  int least = 1;  ///< Least number of its joints in the hand for it to matter.
  /// The law of a first joint's angle that is a multiple of the second's plus an offset.
  struct Line {
    double ratio, offset_rad;
  };
  std::optional<Line> line = {};
  std::string fault = {};  ///< Reason why it has no line, where not obvious.
};

/// A constraint that closes a loop between two bodies.
struct TreeLoop {
  std::string what, place;
  std::array<int, 2> bodies;
};

struct BodyTree {
  std::string file;              ///< Its name without its folder.
  std::vector<TreeBody> bodies;  ///< The first is the world; parents before children.
  std::vector<TreeSite> sites;
  std::vector<TreeWrap> wraps;
  std::vector<TreeTendon> tendons;
  std::vector<TreeCoupling> couplings;
  std::vector<TreeLoop> loops;
  std::vector<std::string> notes;  ///< Elements left out in reading it.
};

/// Returns the index of the item of this name, or -1.
template <typename Items>
[[nodiscard]] int index_of_name(const Items& items, std::string_view name) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

[[nodiscard]] inline std::vector<std::string_view> joint_names(const BodyTree& tree) {
  std::vector<std::string_view> names;
  for (const TreeBody& body : tree.bodies) {
    for (const TreeJoint& joint : body.joints) names.push_back(joint.name);
  }
  return names;
}

/// Returns a tree with the world alone.
[[nodiscard]] inline BodyTree empty_tree() {
  BodyTree tree;
  tree.bodies.emplace_back();
  tree.bodies.front().name = "world";
  tree.bodies.front().X_PB.setIdentity();
  return tree;
}

}  // namespace thenar
