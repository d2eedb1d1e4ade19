#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/control/stiff_control.h"
#include "engine/loops/run.h"

namespace thenar {

/// A grasp at a moment of a run as its controller sees it: the problem that StiffnessControl solves, for the torques
/// that the muscles give then. Contacts and squeeze stay as they are. Needs muscles that have stiffness.
struct StiffGrasp {
  explicit StiffGrasp(const GraspRun& run);

  /// The least stiffness along and about the scene's `centre`, as the problem's K_des.
  [[nodiscard]] Matrix6d wanted(double translation_N_per_m, double rotation_Nm_per_rad) const;

  StiffMuscleData problem;
  Eigen::Isometry3d X_WO;
  Eigen::Vector3d centre_m;  ///< Where stiffnesses belong together; object frame.
  Matrix6d K_scene;          ///< What the scene asks for, or else 100 N/m with as much on an arm of 25 mm.
  bool asks = false;         ///< The scene asks for something.
};

/// Muscle forces, and the stiffness that they give.
struct StiffForces {
  double asked = 0.0;        ///< In the unit of what was asked for.
  Eigen::VectorXd forces_N;  ///< One a muscle.
  /// The object's, about its origin, world axes; nothing: a finger's posture gives way even with the object clamped.
  std::optional<Matrix6d> K_object;

  [[nodiscard]] double sum_N() const { return forces_N.sum(); }
  [[nodiscard]] double effort_N() const { return forces_N.norm(); }  ///< The root of what is least, f'f.
  [[nodiscard]] bool is_stable() const;                              ///< As excitations stay.
};

/// These forces, with what they give.
[[nodiscard]] StiffForces with_stiffness(const StiffGrasp& grasp, Eigen::VectorXd forces_N, double asked = 0.0);

/// The least forces that make the object at least `asked` times as stiff as K. Nothing: there are none.
[[nodiscard]] std::optional<StiffForces> stiff_forces(const StiffGrasp& grasp, const Matrix6d& K, double asked);
/// Without any such need; nothing if not even the torques can be had.
[[nodiscard]] std::optional<StiffForces> least_forces(const StiffGrasp& grasp);

/// The share of the end of a range at which its forces are told: they rise ever more steeply before the end, and there
/// they change with whatever changes a little.
inline constexpr double kNearEnd = 0.99;

/// How far a kind of stiffness can be raised.
struct StiffEnd {
  /// The most there is, to a millionth; nothing: muscles cannot even keep the object from turning away.
  std::optional<StiffForces> most;
  std::optional<StiffForces> near;  ///< The least forces for kNearEnd of that.
  StiffnessReport beyond;           ///< The motion that lacks something beyond it, and the muscles in its way.
};

/// The largest multiple of K, by halving.
[[nodiscard]] StiffEnd stiff_end(const StiffGrasp& grasp, const Matrix6d& K);

/// What muscles can make of a grasp.
struct StiffnessRange {
  double at_s = 0.0;
  std::optional<StiffForces> least;  ///< With the torques alone.
  StiffEnd translation;              ///< The same along all directions [N/m], while no turn is unstable.
  StiffEnd rotation;                 ///< The same about all axes [N m/rad], while no motion is unstable.
  StiffEnd scene;                    ///< Multiples of K_scene.
  bool asks = false;                 ///< The scene asks for something,
  StiffnessReport lack;              ///< and this is what lacks of it, if scene.most is below 1.
  std::vector<StiffForces> front;    ///< Least forces over multiples of K_scene, from 0 to kNearEnd of the most.
};

/// Of a run's state. Nothing: some finger bears no load. Takes some ten milliseconds.
[[nodiscard]] std::optional<StiffnessRange> stiffness_range(const GraspRun& run);

/// Where the scene has settled: runs it for 0.3 s and on until all fingers bear load, or to its end. Nothing: the scene
/// has no muscles that have stiffness, or its object is soft.
[[nodiscard]] std::optional<StiffnessRange> settled_stiffness_range(const Model& model);

}  // namespace thenar
