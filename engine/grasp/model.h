// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/implicit_surface.h"
#include "engine/grasp/pulp.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Load of one finger on the object.
struct FingerLoad {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();   ///< Sum of its contact forces, world axes.
  double normal_N = 0.0;                               ///< Sum of their normal parts; 0: the finger is not loaded.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< Pressure centre on the object's surface, world.
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  ///< Into the object, world: mean of the contacts' normals, by load.
};

/// State of a finger's grip at the start of a run.
struct FingerStart {
  FingerLoad load;
  Eigen::Vector3d sheared_m = Eigen::Vector3d::Zero();  ///< Displacement of its pulp along the surface since it
                                                        ///< touched, and stuck: world.
};

class SampledSolid;

/// A scene made ready to run: its data, and the values computed from them once. Made by build_model().
struct Model {
  Scene scene;
  std::vector<std::string> object_notes;  ///< Processing of the object's points into a surface.
  ImplicitSurface object;
  std::optional<ExactShape> exact = {};  ///< Exact shape, if any: touched where the surface is smooth.
  std::vector<Pulp> pulps = {};          ///< One a finger, or none: rigid point contacts.
  /// The object's samples that control points may pass by (fine_parts): usually none. Those at edges are in cells.
  Eigen::Matrix3Xd fine_m = {}, fine_edges_m = {};
  int level = 0;                  ///< Level of detail of the pulps.
  Eigen::Index max_contacts = 0;  ///< Capacity of a frame, all fingers together.
  std::string grasp_notes = {};   ///< Search and quality of the grasp; empty: not searched.
  /// Grip of a scene that settles at the start of a run. Nothing: the fingers carry nothing yet.
  std::optional<PerFinger<FingerStart>> start = {};
  /// Samples of the object that touch the environment, where the object is no exact solid.
  std::shared_ptr<const SampledSolid> sampled = {};

  [[nodiscard]] int fingers() const { return scene.hand.fingers(); }
  [[nodiscard]] bool deformable() const { return !pulps.empty(); }
  /// Returns whether fingertips sense more than their loads: see Touch.
  [[nodiscard]] bool feels() const { return scene.fingertips && scene.fingertips->touch; }
  [[nodiscard]] bool soft_object() const { return scene.object.compliance.has_value() && deformable(); }
  /// Returns whether a control period begins with this step. The periods need not hold a whole number of steps.
  [[nodiscard]] bool control_is_due(std::int64_t tick) const;
  /// Returns the object's target pose: its start pose moved by the task.
  [[nodiscard]] Eigen::Isometry3d target(double time_s) const;
  /// Returns the target's velocity, the derivative of target(): velocity of its origin [m/s], angular velocity
  /// [rad/s]; world axes.
  [[nodiscard]] Vector6d target_velocity(double time_s) const;
  /// Returns gravity in the hand frame at this time: less the acceleration of the task's arm.
  [[nodiscard]] Eigen::Vector3d gravity(double time_s) const;
  /// Returns Coulomb's coefficient at this time.
  [[nodiscard]] double friction(double time_s) const;
  /// Returns the object's weight at its centre of mass, for the pose X_WO and this gravity: a wrench about the object's
  /// origin, world axes [N, N m]. The controller knows this part of W_ext.
  [[nodiscard]] Vector6d weight(const Eigen::Isometry3d& X_WO, const Eigen::Vector3d& gravity) const;
  [[nodiscard]] Vector6d weight(const Eigen::Isometry3d& X_WO) const { return weight(X_WO, scene.gravity); }
  /// Returns W_ext: the weight plus the task's push at `time_s`, likewise a wrench.
  [[nodiscard]] Vector6d external_wrench(double time_s, const Eigen::Isometry3d& X_WO) const;
  /// Returns whether W_ext changes from tick to tick, not only from frame to frame.
  [[nodiscard]] bool loads_vary() const;
};

}  // namespace thenar
