#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "engine/control/grasp_stiffness.h"
#include "engine/loops/run.h"

namespace thenar {

/// What may act while a grasp is probed.
enum class Acting {
  kMuscles,  ///< Excitations stay as they are: muscles have their forces and their stiffness, and no law acts.
  kControl,  ///< The control law goes on.
};

/// A grasp at a time of its scene, as a run that goes on from there with contacts solved to 1e-9.
struct GraspAt {
  /// Runs the scene until then, in one loop; what its task does then stays as it is. Needs muscles that have stiffness.
  GraspAt(const Model& of, double at_s, Acting acting);

  Model model;
  GraspRun run;
};

/// A copy of a run with a control tick done on its state: the run itself goes on as if nobody had looked.
struct SeenRun {
  explicit SeenRun(const GraspRun& run);

  /// Of what the contacts bear at these places of theirs.
  [[nodiscard]] GraspStiffness grasp(std::span<const ContactPlace> places) const;

  GraspRun at;
  HandPose pose;
};

/// A stiffness about the point where turning and moving the object depend on one another the least.
struct CentredStiffness {
  /// c, for which K_tt^-1 K_tr + [c]x has no antisymmetric part; from the origin. Zero where K_tt is not positive.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  bool has_centre = false;
  Eigen::Vector3d translation_N_per_m, rotation_Nm_per_rad;  ///< Eigenvalues of both blocks there, rising.
  Eigen::Matrix3d translation_axes, rotation_axes;           ///< Their directions, as columns.
};

/// Of a stiffness about the object's origin, in whatever axes it is in. Symmetric parts count.
[[nodiscard]] CentredStiffness centred(const Matrix6d& K);

/// What moves most in a mode, by what viscosity takes.
enum class Moving { kTranslation, kRotation, kFinger };

/// A way in which the whole grasp comes back, or goes away, as exp(-rate t).
struct GraspMode {
  double rate_per_s = 0.0;        ///< Negative: it turns away.
  double swings_rad_per_s = 0.0;  ///< 0: it does not swing.
  Moving moving = Moving::kTranslation;
  int finger = 0;                                    ///< That moves, if it is one.
  double share = 0.0;                                ///< Of what viscosity takes.
  Eigen::Vector3d axis_O = Eigen::Vector3d::Zero();  ///< Unit: along or about it, if it is the object.
  /// Amplitude of the mode in a motion z = (object's origin, rotation, joints; world axes): measure' z.
  Eigen::VectorXcd measure;
  Vector6d pushed_by = Vector6d::Zero();  ///< Real part of what a wrench on the object makes of that in a second.
};

/// What muscles are asked for.
struct MuscleEffort {
  double sum_N = 0.0;
  int largest = 0;     ///< That with the largest share
  double share = 0.0;  ///< of its largest force.
};

/// The stiffness of a grasp, as its contacts and muscles make it. See GraspStiffness.
struct PredictedStiffness {
  Matrix6d K_O;  ///< About the object's origin, its axes [N/m, N/rad; N, N m/rad].
  int contacts = 0, sliding = 0;
  PerFinger<double> joints_Nm_per_rad;  ///< Least eigenvalue of each D_k + M_k, object clamped; symmetric part.
  std::vector<GraspMode> modes;         ///< The slowest, or the one that goes away fastest, first.
  MuscleEffort effort;
  Eigen::Isometry3d X_WO;

  /// The slowest mode, or the one that goes away fastest. Of a grasp with contacts.
  [[nodiscard]] const GraspMode& slowest() const { return modes.front(); }
  [[nodiscard]] bool is_stable() const { return slowest().rate_per_s > 0.0; }
};

/// Of a run's state: the muscles with the forces that they have there,
[[nodiscard]] PredictedStiffness predict_stiffness(const GraspRun& run);
/// or with others [N], one a muscle, which drive the joints as those do.
[[nodiscard]] PredictedStiffness predict_stiffness(const GraspRun& run, const MuscleVector& forces_N);

}  // namespace thenar
