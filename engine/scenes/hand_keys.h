// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "engine/hand/hand.h"
#include "engine/scenes/visitor.h"

/// A hand file as it is written: in SI units without their names, and with names in place of indices. The description
/// shows each key once, to the table of keys, to the reader (engine/scenes/hand_file.h) and to the writer.
namespace thenar {

struct JointKeys {
  std::string name;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitX();
  Eigen::Vector2d limits_rad = Eigen::Vector2d::Zero();
  std::string follows = {};  ///< The joint that it turns with; empty: it turns by itself.
  double ratio = 1.0, offset_rad = 0.0;
};

struct SegmentKeys {
  std::string name;
  std::vector<std::string> moved_by = {};
  double length_m = 0.0, mass_kg = 0.0;
  Eigen::Vector3d com_m = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_WS_0 = Eigen::Isometry3d::Identity();
};

/// Keys of a fingertip: the radius for a sphere, also the length for a capsule, the semi-axes alone for an ellipsoid.
struct FingertipKeys {
  std::string finger, segment;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitX();
  std::optional<double> radius_m = {}, length_m = {};
  std::optional<Eigen::Vector3d> semi_axes_m = {};
  std::optional<Eigen::Matrix3d> axes = {};
  std::optional<double> joint_viscosity = {}, reduced_modulus_Pa = {}, poisson = {}, relaxation_s = {};
};

struct CrossingKeys {
  std::vector<std::string> joints = {};
  double share = 1.0;
  std::string insertion_segment = {};
  Eigen::Vector3d insertion_m = Eigen::Vector3d::Zero();
  std::string pull_segment = {};
  Eigen::Vector3d pull = Eigen::Vector3d::UnitX();
  bool pull_is_point = false;
};

struct MuscleKeys {
  std::string name;
  double max_force_N = 0.0;
  std::optional<double> fibre_m = {}, tendon_N_per_m = {};
  std::vector<CrossingKeys> crossings = {};
};

struct HandKeys {
  std::vector<JointKeys> joints;
  std::vector<SegmentKeys> segments;
  std::vector<FingertipKeys> fingertips;
  std::vector<MuscleKeys> muscles;
};

/// The whole file.
void describe(Visitor& v, HandKeys& hand);

/// Returns a hand as its file has it; numbers are rounded to 1e-12.
[[nodiscard]] HandKeys keys_of(const Hand& hand);

}  // namespace thenar
