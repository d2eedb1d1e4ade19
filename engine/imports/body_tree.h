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

/// A mechanism as MJCF and URDF both describe it: a tree of bodies, what is fixed in them, and what ties them together.
/// Lengths in m, angles in rad. `place` is "file:line".
namespace thenar {

enum class TreeJointKind { kHinge, kSlide, kBall, kFree };

/// A joint turns its body, and all that hangs on it, against the body's parent; several act one after the other.
struct TreeJoint {
  std::string name, place;
  TreeJointKind kind = TreeJointKind::kHinge;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< Body frame.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< Body frame, unit.
  double reference = 0.0;                              ///< Its value where the bodies are as the file has them.
  std::optional<std::array<double, 2>> range;          ///< Nothing: no limits.
};

/// What a pulp may be: a sphere, an ellipsoid or a capsule.
struct TreeRound {
  double radius_m = 0.0;           ///< Of a sphere, or of the largest one about the centre that is in it.
  std::optional<PulpShape> shape;  ///< Nothing: a sphere. Its axes are in the body frame.
  Eigen::Vector3d centre_m;        ///< Body frame.
};

struct TreeBody {
  std::string name, place;
  int parent = 0;          ///< Before this one; of the world itself 0.
  Eigen::Isometry3d X_PB;  ///< In its parent.
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

/// What a tendon may wrap around: a sphere, or a cylinder about its z axis without an end.
struct TreeWrap {
  std::string name;
  int body = 0;
  Eigen::Isometry3d X_BG;
  double radius_m = 0.0;
  bool is_cylinder = false;
};

/// A tendon goes from site to site, and around at most one surface between two of them.
struct TreeTendonStep {
  int site = -1;
  int wrap = -1;       ///< Between the site before it and this one; -1: it goes straight.
  int side_site = -1;  ///< On which side of the surface; -1: the shorter one.
  double share = 1.0;  ///< Of the muscle's force, between the site before it and this one.
  bool begins = true;  ///< Nothing goes from the site before it to this one.
};

struct TreeTendon {
  std::string name, place;
  std::vector<TreeTendonStep> steps;
  std::optional<double> max_force_N;  ///< Nothing: no muscle pulls it.
  std::string muscle;                 ///< The muscle's name.
};

/// Joints that do not move one without the other: the first follows the second.
struct TreeCoupling {
  std::string what, place;  ///< "equality 'x'"
  std::vector<std::string> joints;
  int least = 1;  ///< It matters if it names so many joints of the hand.
  /// Where the first joint's angle is a multiple of the second's, and an offset.
  struct Line {
    double ratio, offset_rad;
  };
  std::optional<Line> line = {};
  std::string fault = {};  ///< Why it has no line, where that is not plain.
};

/// What closes a loop between two bodies.
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
  std::vector<std::string> notes;  ///< What was left out in reading it.
};

/// The index of the item of this name, or -1.
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

/// A tree with the world alone.
[[nodiscard]] inline BodyTree empty_tree() {
  BodyTree tree;
  tree.bodies.emplace_back();
  tree.bodies.front().name = "world";
  tree.bodies.front().X_PB.setIdentity();
  return tree;
}

}  // namespace thenar
