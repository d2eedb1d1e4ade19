// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "collision/shapes.h"
#include "collision/solids/exact_shape.h"
#include "collision/solids/solid.h"
#include "engine/environment/environment.h"
#include "engine/grasp/pulp.h"
#include "engine/hand/hand.h"
#include "engine/hand/muscles.h"
#include "solvers/grasp_forces.h"

namespace thenar {

// Generated shapes are declared in collision/shapes.h and collision/solids/solid.h.

/// A surface from a file, as engine/formats/point_cloud_file.h reads it.
struct CloudShape {
  std::filesystem::path file;
  double unit_m = 1.0;  ///< Length of 1 in the file.
  bool operator==(const CloudShape&) const = default;
};
using Shape = std::variant<BoxShape, SphereShape, EllipsoidShape, CylinderShape, SuperquadricShape, Mug, CloudShape>;

struct ObjectSettings {
  Shape shape;
  Eigen::Index points = 0;  ///< Samples of a generated shape or a mesh; a scan brings its own.
  double mass_kg = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();  ///< Centre of mass; object frame.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();      ///< Pose at the start.
  double translation_damping = 0.0;                            ///< b_t [N s/m].
  double rotation_damping = 0.0;                               ///< b_o [N m s].
  std::optional<PulpMaterial> compliance;                      ///< Compliance of its surface; nothing: rigid.
};

/// Tactile sensing of the fingertips: see Touch (engine/grasp/state.h).
struct TouchSettings {
  double delay_s = 0.0;    ///< Delay from skin to command: age of the signals in control.
  double noise = 0.0;      ///< Standard deviation of each sensed contact force, as a share of it.
  std::uint32_t seed = 1;  ///< Seed of the noise.
};

/// Deformable pulps; a scene without them has rigid point contacts.
struct FingertipSettings {
  Eigen::Index points = 0;
  Eigen::Index leaves = 0;  ///< Number of control points.
  PulpMaterial material;
  std::optional<TouchSettings> touch = {};  ///< Nothing: they sense only their loads.
};

struct ContactSettings {
  double friction = 0.0;
  double band_m = 0.0;              ///< Control points with a gap below this are candidates.
  double distance_error_m = 1e-6;   ///< Allowed error of distances of deformable fingertips' points; 0: exact.
  Eigen::Index max_per_finger = 0;  ///< Largest number of candidates, by least gap.
  std::optional<int> level = 0;     ///< Level of detail of the pulps, see set_level; nothing: chosen by force_error.
  double force_error = 0.05;        ///< Allowed rms error of a pulp's force against Hertz's in the choice of a level.
  double tolerance = 0.0;           ///< Natural-map residual of a tick.
  int max_sweeps = 0;
};

enum class ControlLaw {
  kFeedforward,  ///< tau^d = J' f^d + g + K J^+ y
  kPaper,        ///< tau^d = K J^+ y, eq. (22): leaves a steady force error.
};

/// Gains of one PID: p [N/m or N m/rad], i [p/s], d [p s].
struct PidGains {
  double p = 0.0, i = 0.0, d = 0.0;
};

/// Drive of the hand over time, instead of the control law: linear between its times, constant before and after.
struct DriveTable {
  std::filesystem::path file;
  Eigen::VectorXd time_s;  ///< Rising.
  Eigen::MatrixXd values;  ///< Joints x times, torques [N m]; or muscles x times, forces [N].
  bool muscles = false;

  [[nodiscard]] Eigen::VectorXd at(double at_s) const;
};

/// Response of the grip to tactile signals: see Reflex (engine/control/reflex.h).
struct ReflexSettings {
  double load_rate_N_per_s = 2.0;  ///< Excess rate of a finger's tangential load that triggers a pulse.
  double pulse_s = 0.22;           ///< Duration of the grip's rise in a pulse.
  double release_s = 0.5;          ///< Time constant of the grip's return.
  double stick = 0.35;             ///< Least share of a patch that should stick.
  double regulation_per_s = 5.0;   ///< Rate of the squeeze's adjustment to it, as a share of the grip.
};

/// Activation dynamics of the muscles: da/dt = (u - a) / tau, with tau = rise (0.5 + 1.5 a) while the
/// activation a rises to the excitation u and fall / (0.5 + 1.5 a) while it falls [Thelen 2003, J Biomech Eng 125:70].
struct Activation {
  double rise_s = 0.0, fall_s = 0.0;
  bool operator==(const Activation&) const = default;
};

/// Least stiffness of the object in the hand for which muscle forces are chosen, object axes.
struct ObjectStiffness {
  Eigen::Vector3d translation_N_per_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_Nm_per_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< Reference point of both; object frame.
  double most_squeeze_N = 0.0;                         ///< Largest rise of the internal force for it; 0: none.
  bool operator==(const ObjectStiffness&) const = default;
};

/// Properties of muscles beyond their commanded forces.
struct MuscleSettings {
  std::optional<Activation> activation;             ///< Nothing: forces act at once.
  std::optional<double> short_range;                ///< gamma of k = gamma f / L; nothing: lengths change no force.
  double short_range_strain = kShortRangeStrain;    ///< Strain of the fibres up to which this holds.
  std::optional<ObjectStiffness> object_stiffness;  ///< Nothing: least forces. Only for muscles with stiffness.
  std::optional<double> frozen_from_s;              ///< Start of constant excitations; nothing: never.

  bool operator==(const MuscleSettings&) const = default;
  /// Returns whether the contact side does more than apply torques.
  [[nodiscard]] bool act() const { return activation || short_range; }
};

struct ControlSettings {
  ControlLaw law = ControlLaw::kFeedforward;
  std::optional<double> gain;            ///< K of eq. (22) [N m/rad]; nothing: from the joint viscosity and the period.
  double pulp_normal_N_per_m = 0.0;      ///< K_n: the controller's model of the pulp; nu = relaxation * K.
  double pulp_tangential_N_per_m = 0.0;  ///< K_t.
  double grasp_friction = 0.0;           ///< mu_c of the cones of grasp forces; of felt ones until it is felt.
  std::optional<double> felt_margin;  ///< m of cones whose friction is felt: mu_c = mu / (1 + m); nothing: it is not.
  FrictionCone cone = FrictionCone::kExact;  ///< Shape of the cones.
  double internal_force_N = 0.0;             ///< lambda of eq. (13).
  PidGains position, rotation;
  std::optional<Eigen::Vector3d> centre_m;   ///< The point that `position` controls, object frame; nothing: its origin.
  std::optional<double> posture_Nm_per_rad;  ///< Spring to the start posture, where fingertips leave joints free.
  double feedback_delay_s = 0.0;             ///< Age of the state that the laws use.
  bool anticipation = false;                 ///< Feedforward of the demand of the target's motion.
  std::optional<ReflexSettings> reflex;      ///< Nothing: no reflex. Only for fingertips with touch.
  std::optional<MuscleSettings> muscles;     ///< Muscle forces drive the joints; nothing: the torques act as they are.
  std::optional<DriveTable> drive;           ///< Nothing: the law drives them.
};

/// A minimum-jerk move of the target: by a distance or an angle along or about `axis` (unit, object axes at the start).
struct Move {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  double amount = 0.0;  ///< [m] or [rad].
  double from_s = 0.0;
  double over_s = 1.0;
};

/// Spring from the object to its target at every step, like a hand that moves it: a haptic device's virtual coupling.
struct Spring {
  double translation_N_per_m = 0.0;
  double rotation_Nm_per_rad = 0.0;
};

/// A force at a point of the object, and a moment besides, both in object axes at the start, constant but for their
/// rise. The controller does not know of them.
struct Push {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  double from_s = 0.0;
  double over_s = 0.0;
  double rise_s = 0.0;                             ///< Duration of their linear rise from their beginning.
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();  ///< Point of action of the force, fixed in the object; object frame.
  Eigen::Vector3d moment_Nm = Eigen::Vector3d::Zero();
};

/// The arm that carries the hand swings along a line. World = hand frame: the load that this makes is gravity of time.
struct Arm {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< Unit, object axes at the start.
  double amplitude_m = 0.0;
  double frequency_Hz = 0.0;
  double from_s = 0.0;  ///< Start of the swing; its first and last period have a reduced amplitude.
  double over_s = 0.0;
};

/// A part of a path: a displacement, world axes, and its duration.
struct PathLeg {
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double over_s = 1.0;
  bool smooth = false;  ///< Minimum jerk; else constant speed.
};

/// Drive of a fingertip on a slide (Hand::slides); values that its kind does not name are 0. See engine/grasp/slides.h.
struct Slide {
  double force_N = 0.0;            ///< Given force along the slide.
  double rise_s = 0.0;             ///< Duration of its linear rise from zero at the beginning.
  double stiffness_N_per_m = 0.0;  ///< Stiffness of a spring along the slide; 0: none.
  double rest_m = 0.0;             ///< Rest position of the spring along the slide, from the start.
  std::vector<PathLeg> path;       ///< One leg after the other. None: force or spring move it.
};

/// Friction of the contacts from this time on.
struct FrictionStep {
  double from_s = 0.0, friction = 0.0;
};

/// A part of a task that ends when something has come about, not at a time. What its kind does not name is 0.
struct Phase {
  enum class Kind {
    kApproach,  ///< The arm goes, with the fingers still and clear of the object.
    kClose,     ///< The fingers go towards the object until all of them press it.
    kLoad,      ///< The fingers take over its weight, and their squeeze rises with it.
    kLift,      ///< The arm goes, and the fingers hold the object by themselves.
    kMove,      ///< Same as kLift.
    kInsert,    ///< The arm goes against what resists.
    kPlace,     ///< The arm goes until something bears a part of the weight, and the fingers leave it the rest.
    kRelease,   ///< The fingers let go and open.
  };
  Kind kind = Kind::kClose;
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();  ///< Arm's displacement, in kPlace the largest; object
                                                   ///< axes at the start.
  double over_s = 0.0;                             ///< Its duration; in kLoad the load's rise time.
  double press_N = 0.0;                            ///< Internal force in kClose, as of the control.
  double speed_m_per_s = 0.0;                      ///< Speed of the fingers in kClose and kRelease.
  double open_m = 0.0;                             ///< Opening distance of the fingers.
  double most_N = 0.0;                             ///< Resistance to the arm in kInsert above which it has jammed.
  std::optional<PidGains> position = {}, rotation = {};  ///< Gains in kInsert; nothing: the scene's, as the next.
  std::optional<Eigen::Vector3d> centre_m = {};
  double within_s = 0.0;  ///< Time limit, after which the phase has failed.
};
/// "approach", "close", "load", "lift", "move", "insert", "place", "release".
[[nodiscard]] const char* to_string(Phase::Kind kind);

/// Where the object should be at the end, in the axes in which the bodies of the environment are placed
/// (Environment::in_object_frame): the arm's displacement does not change them. What is not named is not judged.
struct TaskGoal {
  std::optional<Eigen::Vector3d> position_m;
  std::optional<Eigen::Matrix3d> rotation;
  double within_m = 2e-3;                              ///< Largest distance from the position.
  double within_rad = 5.0 * std::numbers::pi / 180.0;  ///< Largest angle: see turn_rad.
};

struct TaskSettings {
  std::vector<Phase> phases;  ///< One after the other; none: nothing but times.
  std::optional<Move> translate, rotate;
  std::optional<Spring> spring;
  std::optional<Push> push;
  std::optional<Arm> arm;
  std::vector<FrictionStep> friction;  ///< Ordered by time.
  std::optional<double> lost_m;  ///< A finger that has slid so far has lost the object; nothing: its pulp's radius.
  std::optional<TaskGoal> goal;  ///< Nothing: the object's pose at the end is not judged.
};

/// Allowed error of a scene against its full model where parts are left out: the object's path, rms and at the end, and
/// the rest as in PathDeviation (engine/studies/model_parts.h).
struct Tolerance {
  double position_m = 1e-4;
  double rotation_rad = std::numbers::pi / 1800.0;
  double force = 0.05;   ///< Share of the forces.
  double moment = 0.1;   ///< Share of the torsion that friction allows.
  double margin = 0.05;  ///< Difference of margins.
};

/// A user's requirements on a grasp to be found; those left out are chosen. Object axes.
struct GraspWish {
  std::vector<int> fingers = {};                   ///< Fingers of the hand, by index; empty: chosen.
  std::optional<Eigen::Vector3d> axis_O = {};      ///< Unit: the line on which the fingers face each other.
  std::optional<Eigen::Vector3d> at_O = {};        ///< Approximate point on that line where the object is held [m].
  std::optional<Eigen::Vector3d> approach_O = {};  ///< Unit: the way in which the hand comes to the object.
  std::optional<double> press_N = {};              ///< Normal load of the least loaded finger, without weight.
  int rank = 1;                                    ///< Rank among all that are found; 1 is the best.
  std::uint32_t seed = 1;
  std::string place = {};  ///< Position of the wish in its file, for refusals: "file:line:column".

  bool operator==(const GraspWish&) const = default;
};

/// Returns the exact solid of a shape that is one; nothing for others.
[[nodiscard]] std::optional<Solid> solid_of(const Shape& shape);

/// Returns the surface of a shape that has a formula; nothing for one from a file.
[[nodiscard]] std::optional<ExactShape> exact_shape_of(const Shape& shape);

/// Returns the angle by which a body with rotation R is turned against R_goal, without what cannot be seen: any turn of
/// a sphere, and the turn of a body of revolution about its axis.
[[nodiscard]] double turn_rad(const Shape& shape, const Eigen::Matrix3d& R_goal, const Eigen::Matrix3d& R);

/// Contents of a scene file, in SI. Parts that it does not name are absent and cost nothing.
struct Scene {
  std::string name;
  double duration_s = 0.0;
  double step_s = 0.0;
  double control_period_s = 0.0;  ///< Not shorter than the step.
  double control_delay_s =
      0.0;  ///< From a control tick's snapshot to its frame's use, where the two have clocks of their own.
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< World = hand frame.
  bool gravity_in_object_frame = false;  ///< It is in object axes, until the pose is known: see place_by_object().
  Hand hand;
  JointVector posture;                 ///< q at the start.
  bool settles = false;                ///< The fingers move until they press as they are asked to: see settle().
  std::optional<GraspWish> grasp;      ///< Posture, and pose of the object, are to be found: until build_model has.
  double joint_viscosity = 0.0;        ///< b [N m s], of fingers that have no other: viscosity().
  std::optional<JointVector> torques;  ///< Drive of the joints without control [N m].
  std::vector<Slide> slides;           ///< Drives of the fingertips of a hand on slides; else none.
  std::optional<FingertipSettings> fingertips;
  ObjectSettings object;
  ContactSettings contact;
  std::optional<Environment> environment;  ///< Nothing: the object touches the fingers alone.
  std::optional<ControlSettings> control;
  TaskSettings task;
  bool only_needed = false;  ///< Parts that change less than the tolerance are left out: engine/studies/model_parts.h.
  Tolerance tolerance;
  std::vector<std::string> left_out;       ///< A line for each part that was left out or kept so, and why.
  std::vector<std::string> defaults_used;  ///< "key = value" of each value the file left to us.

  [[nodiscard]] bool has_muscles() const { return control && control->muscles; }
  /// Returns whether the contact side needs the muscles: they have stiffness or activation dynamics.
  [[nodiscard]] bool muscles_act() const { return has_muscles() && control->muscles->act(); }
  /// Returns whether muscle forces are chosen for a stiffness of the object.
  [[nodiscard]] bool chooses_stiffness() const { return has_muscles() && control->muscles->object_stiffness; }
  /// Returns b of finger k's joints [N m s; N s/m of slides].
  [[nodiscard]] double viscosity(int k) const { return hand.fingertips[k].joint_viscosity.value_or(joint_viscosity); }
  /// Returns whether fingertip k follows a path, whatever resists.
  [[nodiscard]] bool has_path(int k) const { return !slides.empty() && !slides[k].path.empty(); }
};

}  // namespace thenar
