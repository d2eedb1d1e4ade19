// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "engine/control/grasp_stiffness.h"
#include "engine/loops/run.h"

namespace thenar {

/// The actuation while a grasp is probed.
enum class Acting {
  kMuscles,  ///< Constant excitations: muscles have their forces and their stiffness, and no law acts.
  kControl,  ///< The control law continues.
};

/// A grasp at a time of its scene, as a run that continues from there with contacts solved to 1e-9.
struct GraspAt {
  /// Runs the scene until then, in one loop, and freezes its task. Requires muscles with stiffness.
  GraspAt(const Model& of, double at_s, Acting acting);

  Model model;
  GraspRun run;
};

/// A copy of a run after a control tick on its state; the run itself is not affected.
struct SeenRun {
  explicit SeenRun(const GraspRun& run);

  /// Returns the stiffness by the contacts' loads at these places.
  [[nodiscard]] GraspStiffness grasp(std::span<const ContactPlace> places) const;
  /// See sticking_stiffness().
  [[nodiscard]] GraspStiffness sticking(std::span<const ContactPlace> places, double share,
                                        PerFinger<FingerSlips>& slips) const;

  GraspRun at;
  HandPose pose;
};

/// A stiffness about the point with the least coupling of rotation and translation.
struct CentredStiffness {
  /// c, for which K_tt^-1 K_tr + [c]x has no antisymmetric part; from the origin. Zero if K_tt is not positive.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  bool has_centre = false;
  Eigen::Vector3d translation_N_per_m, rotation_Nm_per_rad;  ///< Eigenvalues of both blocks there, ascending.
  Eigen::Matrix3d translation_axes, rotation_axes;           ///< Their directions, as columns.
};

/// Centres the symmetric part of a stiffness about the object's origin, in any axes.
[[nodiscard]] CentredStiffness centred(const Matrix6d& K);

/// The main motion of a mode, by viscous dissipation.
enum class Moving { kTranslation, kRotation, kFinger };

/// A mode of the whole grasp, which decays or grows as exp(-rate t).
struct GraspMode {
  double rate_per_s = 0.0;        ///< Negative: unstable.
  double swings_rad_per_s = 0.0;  ///< Angular frequency; 0: no oscillation.
  Moving moving = Moving::kTranslation;
  int finger = 0;                                    ///< Moving finger, if it is one.
  double share = 0.0;                                ///< Share of the viscous dissipation.
  Eigen::Vector3d axis_O = Eigen::Vector3d::Zero();  ///< Unit axis of the object's motion, if it is the object.
  /// Amplitude of the mode in a motion z = (object's origin, rotation, joints; world axes): measure' z.
  Eigen::VectorXcd measure;
  Vector6d pushed_by = Vector6d::Zero();  ///< Real part of the amplitude's rate by a wrench on the object.
};

/// The commanded muscle forces.
struct MuscleEffort {
  double sum_N = 0.0;
  int largest = 0;     ///< Muscle with the largest share.
  double share = 0.0;  ///< Share of its largest force.
};

/// The stiffness of a grasp by its contacts and muscles. See GraspStiffness. A contact at its cone's edge may stick
/// under a push and slip under the opposite one; for the modes such contacts count half as sticking.
struct PredictedStiffness {
  Matrix6d K_O;  ///< About the object's origin, its axes [N/m, N/rad; N, N m/rad]: of the mean of opposite pushes.
  int contacts = 0, sliding = 0;
  int near_sliding = 0;                 ///< Contacts that slide, or have less than a hundredth of their friction left.
  double uncertain = 0.0;               ///< compliance_error() if these are at their cones' edge, too; at least 1
                                        ///< where slips have no solution.
  PerFinger<double> joints_Nm_per_rad;  ///< Least eigenvalue of each D_k + M_k, object clamped; symmetric part.
  std::vector<GraspMode> modes;         ///< The slowest, or the one that grows fastest, first.
  MuscleEffort effort;
  Eigen::Isometry3d X_WO;

  /// Returns the slowest mode, or the one that grows fastest. Requires contacts.
  [[nodiscard]] const GraspMode& slowest() const { return modes.front(); }
  [[nodiscard]] bool is_stable() const { return slowest().rate_per_s > 0.0; }
};

/// Returns the relative error of a compliance: the largest entry of the difference, over roots of predicted diagonals.
[[nodiscard]] double compliance_error(const Matrix6d& measured, const Matrix6d& predicted);

/// Predicts the stiffness at a run's state, with the present muscle forces and lengths.
[[nodiscard]] PredictedStiffness predict_stiffness(const GraspRun& run);
/// Predicts the stiffness with other forces [N], one per muscle, that give the same joint torques and are those of the
/// present lengths.
[[nodiscard]] PredictedStiffness predict_stiffness(const GraspRun& run, const MuscleVector& forces_N);

}  // namespace thenar
