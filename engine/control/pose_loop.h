// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "engine/control/controller.h"
#include "engine/control/pose_gains.h"
#include "engine/control/sampled_loop.h"
#include "engine/grasp/model.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// The slowest mode of the object's pose loop: its pole over a control period, and the object's motion in it.
struct PoseMode {
  double pole = 0.0;  ///< Size; the loop is stable up to 1.
  bool turns = false;
  Eigen::Vector3d axis_O = Eigen::Vector3d::UnitX();  ///< Of the translation or the rotation; unit, object axes.

  [[nodiscard]] bool is_stable() const { return pole < 1.0 + 1e-7; }  // Integrators that nothing acts on have 1.
};

/// The object's pose loop of a grasp, linear about the start of a scene with control, as the loops sample it.
///
/// Object, fingers and pulps are the first-order plant of the contact tick. The object moves by the pulps' forces
/// against its own viscosity, each finger's contact point by J diag(1 / b) J' of the torques' and the pulp's, and
/// between them each pulp is a spring and a damper (Kelvin, Voigt) with Hertz's and Mindlin's stiffness at the finger's
/// share of the grip. So a finger lends the object's translation at its point the viscosity b (J J')^-1, through the
/// pulp, and no motion that leaves the points where they are: there the object's own viscosity acts alone. The
/// controller has its PID, the derivative of the grasp forces by the wrench (by finite differences), and the force
/// control of eq. (22) with its filter. Contacts stick. Not in it: the finite patches' moments, forces that turn with
/// the object, the environment, and what muscles do beyond their torques.
class PoseLoop {
 public:
  explicit PoseLoop(const Model& model) : PoseLoop(model, nullptr) {}
  /// At the grasp of a control tick that found forces while the grip built up, with the hand and the object still as at
  /// the start.
  PoseLoop(const Model& model, const ControlReport& solved) : PoseLoop(model, &solved) {}

  /// Returns the loop's delay in steps, beside the sampling: control.feedback_delay, as whole periods, for the laws
  /// know snapshots of control ticks alone, and time.control_delay.
  [[nodiscard]] int delay_steps() const;
  /// Returns the matrices of the loop.
  [[nodiscard]] SampledLoop sampled(const PoseGains& gains, int delay_steps) const;
  [[nodiscard]] PoseMode slowest(const PoseGains& gains, int delay_steps) const;

  /// Returns the largest factor of the gains, up to 1e4, below which the loop is stable; 0 if it is unstable with any:
  /// then the control of forces is, not that of the pose. Of all gains, or of the position's or rotation's alone.
  enum class Of { kAll, kPosition, kRotation };
  [[nodiscard]] double most_gain(const PoseGains& gains, int delay_steps, Of which = Of::kAll) const;
  /// Returns the largest delay in steps, up to 1 s, with which it is stable, and with all smaller ones tried by
  /// bisection; in multiples of `multiple`. -1: none.
  [[nodiscard]] int most_delay(const PoseGains& gains, int multiple = 1) const;

 private:
  PoseLoop(const Model& model, const ControlReport* solved);

  struct Finger {
    int first = 0;                               ///< Index of its first joint.
    Eigen::Matrix<double, 6, Eigen::Dynamic> J;  ///< Of its tip's translation at the contact, and rotation.
    Eigen::VectorXd mobility;                    ///< 1 / b of its joints.
    Eigen::MatrixXd posture;                     ///< Torques for its joints' way from the start posture, less sign.
    Eigen::Matrix<double, 6, 6> compliance;      ///< The pulp's.
    double retained = 0.0;                       ///< The share of its deformation that a step keeps.
    Eigen::Matrix3d answers;                     ///< (J J')^-1 of eq. (22).
    Eigen::Matrix3d filter;                      ///< The controller's model of the pulp's compliance [m/N].
    double lag_s = 0.0;                          ///< Likewise its time constant.
    Eigen::Matrix3d shifts;                      ///< Motion of its pressure centre for the contact's moment [m/N/m].
  };
  void add_finger(const HandPose& pose, int k, const GraspContact& contact, const Eigen::Vector3d& f);
  void add_plant(SampledLoop& loop) const;
  void add_controller(const PoseGains& gains, SampledLoop& loop) const;

  const Model& model_;
  Eigen::Isometry3d X_WO_;
  std::vector<Finger> fingers_;
  Eigen::MatrixXd T_;          ///< Motion of the object at the contacts for that of its origin, 6 a finger x 6.
  Eigen::MatrixXd by_wrench_;  ///< Derivative of the grasp forces by the wrench, 3 a finger x 6.
  Eigen::MatrixXd by_points_;  ///< And by the contacts' points, 3 a finger x 3 a finger.
  Eigen::Vector3d centroid_m_ = Eigen::Vector3d::Zero();  ///< Of the contacts, from the object's origin.
  double lever_m_ = 0.0;                                  ///< Their root mean square distance from it.
};

/// A detector of growing oscillations of the object about its target.
class Swings {
 public:
  static constexpr double kLeast_m = 0.1e-3;  ///< Least swing.
  static constexpr double kLeast_rad = 2e-3;
  static constexpr double kWider = 1.05;  ///< Least ratio to the swing before of a wider one.
  static constexpr int kOnEnd = 4;        ///< Number of consecutive wider swings that are reported, if
  static constexpr double kGrown = 2.0;   ///< the last is this many times the first; beats stay below that.

  struct Swing {
    bool turns = false;  ///< True if about its axes, not along them.
    double size = 0.0;   ///< [m] or [rad].
  };
  /// Adds the object's present error, along three axes [m] and as an angle [rad]; returns a growing swing.
  std::optional<Swing> add(const Eigen::Vector3d& off_m, double off_rad);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(courses_);
  }

 private:
  struct Course {
    double far = 0.0, turned = 0.0;       ///< Extreme since the last reversal, and that reversal.
    int way = 0;                          ///< Direction: 1 up, -1 down.
    double last = 0.0, one_before = 0.0;  ///< Sizes of swings.
    int wider = 0;
    double first = 0.0;  ///< Last swing that was not wider.
    void add(double now, double least);

    template <typename Archive>
    void members(Archive& a) {
      a(far, turned, way, last, one_before, wider, first);
    }
  };
  std::array<Course, 4> courses_;
};

}  // namespace thenar
