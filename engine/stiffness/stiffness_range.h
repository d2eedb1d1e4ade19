// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/control/stiff_control.h"
#include "engine/loops/run.h"

namespace thenar {

/// A grasp at a moment of a run in its controller's view: the problem of StiffnessControl, for the muscles' torques
/// then. Contacts and internal force are constant. Requires muscles with stiffness.
struct StiffGrasp {
  explicit StiffGrasp(const GraspRun& run);

  /// Returns the least stiffness along and about the scene's `centre`, as the problem's K_des.
  [[nodiscard]] Matrix6d wanted(double translation_N_per_m, double rotation_Nm_per_rad) const;

  StiffMuscleData problem;
  Eigen::Isometry3d X_WO;
  Eigen::Vector3d centre_m;  ///< Reference point of stiffnesses; object frame.
  Matrix6d K_scene;          ///< The scene's demand, or else 100 N/m and the same on an arm of 25 mm.
  bool asks = false;         ///< True if the scene has a demand.
};

/// Muscle forces, and their stiffness.
struct StiffForces {
  double asked = 0.0;        ///< Demand, in its unit.
  Eigen::VectorXd forces_N;  ///< One per muscle.
  /// Stiffness of the object about its origin, world axes; nothing: a posture is unstable even with a clamped object.
  std::optional<Matrix6d> K_object;

  [[nodiscard]] double sum_N() const { return forces_N.sum(); }
  [[nodiscard]] double effort_N() const { return forces_N.norm(); }  ///< Root of the minimised f'f.
  [[nodiscard]] bool is_stable() const;                              ///< With constant excitations.
};

/// Returns these forces with their stiffness.
[[nodiscard]] StiffForces with_stiffness(const StiffGrasp& grasp, Eigen::VectorXd forces_N, double asked = 0.0);

/// Finds the least forces that make the object at least `asked` times as stiff as K; nothing if there are none.
[[nodiscard]] std::optional<StiffForces> stiff_forces(const StiffGrasp& grasp, const Matrix6d& K, double asked);
/// Finds the least forces for the torques alone; nothing if there are none.
[[nodiscard]] std::optional<StiffForces> least_forces(const StiffGrasp& grasp);

/// Share of the end of a range at which its forces are reported: towards the end they rise ever more steeply and are
/// sensitive to small changes.
inline constexpr double kNearEnd = 0.99;

/// The upper end of a kind of stiffness.
struct StiffEnd {
  /// Forces of the largest stiffness, to a millionth; nothing: muscles cannot even stabilise the object.
  std::optional<StiffForces> most;
  std::optional<StiffForces> near;  ///< The least forces for kNearEnd of that.
  StiffnessReport beyond;           ///< Limiting motion beyond it, and limiting muscles.
};

/// Finds the largest multiple of K, by bisection.
[[nodiscard]] StiffEnd stiff_end(const StiffGrasp& grasp, const Matrix6d& K);

/// The range of a grasp's stiffness by its muscles.
struct StiffnessRange {
  double at_s = 0.0;
  std::optional<StiffForces> least;  ///< Least forces for the torques alone.
  StiffEnd translation;              ///< The same along all directions [N/m], while no turn is unstable.
  StiffEnd rotation;                 ///< The same about all axes [N m/rad], while no motion is unstable.
  StiffEnd scene;                    ///< Multiples of K_scene.
  bool asks = false;                 ///< True if the scene has a demand.
  StiffnessReport lack;              ///< Its lack, if scene.most is below 1.
  std::vector<StiffForces> front;    ///< Least forces over multiples of K_scene, from 0 to kNearEnd of the most.
};

/// Computes the range at a run's state; nothing if some finger bears no load. Takes some ten milliseconds.
[[nodiscard]] std::optional<StiffnessRange> stiffness_range(const GraspRun& run);

/// Computes the range of the settled scene: runs it for 0.3 s and until all fingers bear load, or to its end. Nothing:
/// the scene has no muscles with stiffness, or its object is soft.
[[nodiscard]] std::optional<StiffnessRange> settled_stiffness_range(const Model& model);

}  // namespace thenar
