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
#include "solvers/grasp_forces.h"

namespace thenar {

// Generated shapes are declared in collision/shapes.h and collision/solids/solid.h.

/// A surface from a file, as engine/formats/point_cloud_file.h reads it.
struct CloudShape {
  std::filesystem::path file;
  double unit_m = 1.0;  ///< What 1 in the file measures.
  bool operator==(const CloudShape&) const = default;
};
using Shape = std::variant<BoxShape, SphereShape, EllipsoidShape, CylinderShape, SuperquadricShape, Mug, CloudShape>;

struct ObjectSettings {
  Shape shape;
  Eigen::Index points = 0;  ///< Samples of a generated shape or a mesh; a scan brings its own.
  double mass_kg = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();  ///< Where the weight acts; object frame.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();      ///< Pose at the start.
  double translation_damping = 0.0;                            ///< b_t [N s/m].
  double rotation_damping = 0.0;                               ///< b_o [N m s].
  std::optional<PulpMaterial> compliance;                      ///< How its surface gives way; nothing: rigid.
};

/// What the fingertips feel: see Touch (engine/grasp/state.h).
struct TouchSettings {
  double delay_s = 0.0;    ///< From skin to command: what the control side feels is so old.
  double noise = 0.0;      ///< Standard deviation of what is felt of each contact's force, as a share of it.
  std::uint32_t seed = 1;  ///< Of the noise.
};

/// Deformable pulps; a scene without them has rigid point contacts.
struct FingertipSettings {
  Eigen::Index points = 0;
  Eigen::Index leaves = 0;  ///< Control points.
  PulpMaterial material;
  std::optional<TouchSettings> touch = {};  ///< Nothing: they feel nothing but their loads.
};

struct ContactSettings {
  double friction = 0.0;
  double band_m = 0.0;              ///< Control points with a gap below this are candidates.
  double distance_error_m = 1e-6;   ///< Allowed in distances of deformable fingertips' points; 0: exact ones.
  Eigen::Index max_per_finger = 0;  ///< Of them, those of least gap.
  std::optional<int> level = 0;     ///< Level of detail of the pulps, see set_level; nothing: chosen by force_error.
  double force_error = 0.05;        ///< Of a pulp's force against Hertz's, rms, that the choice of a level allows.
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

/// What drives the hand by time, instead of the control law: linear between its times, and constant before and after.
struct DriveTable {
  std::filesystem::path file;
  Eigen::VectorXd time_s;  ///< Rising.
  Eigen::MatrixXd values;  ///< Joints x times, torques [N m]; or muscles x times, forces [N].
  bool muscles = false;

  [[nodiscard]] Eigen::VectorXd at(double at_s) const;
};

/// How the grip answers to what is felt: see Reflex (engine/control/reflex.h).
struct ReflexSettings {
  double load_rate_N_per_s = 2.0;  ///< A finger whose tangential load changes faster than expected gets a pulse.
  double pulse_s = 0.22;           ///< How long the grip rises in a pulse.
  double release_s = 0.5;          ///< Time constant in which the grip goes back.
  double stick = 0.35;             ///< The least share of a patch that is to stick.
  double regulation_per_s = 5.0;   ///< How fast the squeeze is adjusted to it, as a share of the grip.
};

/// How fast muscles follow what they are asked for: da/dt = (u - a) / tau, with tau = rise (0.5 + 1.5 a) while the
/// activation a rises to the excitation u and fall / (0.5 + 1.5 a) while it falls [Thelen 2003, J Biomech Eng 125:70].
struct Activation {
  double rise_s = 0.0, fall_s = 0.0;
  bool operator==(const Activation&) const = default;
};

/// The least stiffness of the object in the hand that muscle forces are chosen for, object axes.
struct ObjectStiffness {
  Eigen::Vector3d translation_N_per_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_Nm_per_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< Where these belong together; object frame.
  double most_squeeze_N = 0.0;  ///< How far the internal force may rise for it; 0: it stays as it is.
  bool operator==(const ObjectStiffness&) const = default;
};

/// What muscles are beyond the forces that they are asked for.
struct MuscleSettings {
  std::optional<Activation> activation;             ///< Nothing: forces are there at once.
  std::optional<double> short_range;                ///< gamma of k = gamma f / L; nothing: lengths change no force.
  std::optional<ObjectStiffness> object_stiffness;  ///< Nothing: the least forces do. Of muscles with stiffness alone.
  std::optional<double> frozen_from_s;              ///< From then on excitations stay as they are; nothing: never.

  bool operator==(const MuscleSettings&) const = default;
  /// Whether the contact side has more to do than to apply torques.
  [[nodiscard]] bool act() const { return activation || short_range; }
};

struct ControlSettings {
  ControlLaw law = ControlLaw::kFeedforward;
  std::optional<double> gain;            ///< K of eq. (22) [N m/rad]; nothing: from the joint viscosity and the period.
  double pulp_normal_N_per_m = 0.0;      ///< K_n: the controller's model of the pulp; nu = relaxation * K.
  double pulp_tangential_N_per_m = 0.0;  ///< K_t.
  double grasp_friction = 0.0;           ///< mu_c of the cones of grasp forces; of felt ones until it is felt.
  std::optional<double> felt_margin;  ///< m of cones whose friction is felt: mu_c = mu / (1 + m); nothing: it is not.
  FrictionCone cone = FrictionCone::kExact;  ///< Their shape.
  double internal_force_N = 0.0;             ///< lambda of eq. (13).
  PidGains position, rotation;
  std::optional<Eigen::Vector3d> centre_m;   ///< The point that `position` controls, object frame; nothing: its origin.
  std::optional<double> posture_Nm_per_rad;  ///< Spring to the start posture, where fingertips leave joints free.
  double feedback_delay_s = 0.0;             ///< The laws see the state as it was so long ago.
  bool anticipation = false;                 ///< What the target's motion will need is fed forward.
  std::optional<ReflexSettings> reflex;      ///< Nothing: the grip does not answer. Of fingertips with touch alone.
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

/// What ties the object to its target at every step, as a hand that moves it would: a haptic device's virtual coupling.
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
  double rise_s = 0.0;                             ///< They grow linearly for so long from their beginning on.
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();  ///< Where the force acts, fixed in the object; object frame.
  Eigen::Vector3d moment_Nm = Eigen::Vector3d::Zero();
};

/// The arm that carries the hand swings along a line. World = hand frame: the load that this makes is gravity of time.
struct Arm {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< Unit, object axes at the start.
  double amplitude_m = 0.0;
  double frequency_Hz = 0.0;
  double from_s = 0.0;  ///< From here on it swings, at first and at last over one swing each with less than all.
  double over_s = 0.0;
};

/// A part of a path: a displacement, world axes, and how long it takes.
struct PathLeg {
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();
  double over_s = 1.0;
  bool smooth = false;  ///< By minimum jerk; else at constant speed.
};

/// What moves a fingertip on a slide (Hand::slides); what its kind does not name is 0. See engine/grasp/slides.h.
struct Slide {
  double force_N = 0.0;            ///< Given force along the slide.
  double rise_s = 0.0;             ///< It grows linearly from zero for so long from the beginning on.
  double stiffness_N_per_m = 0.0;  ///< Of a spring along the slide; 0: there is none.
  double rest_m = 0.0;             ///< Where along the slide, from the start, the spring has no force.
  std::vector<PathLeg> path;       ///< One leg after the other. None: force or spring move it.
};

/// From this time on contacts have this friction.
struct FrictionStep {
  double from_s = 0.0, friction = 0.0;
};

/// A part of a task that ends when something has come about, not at a time. What its kind does not name is 0.
struct Phase {
  enum class Kind {
    kApproach,  ///< The arm goes, with the fingers still and clear of the object.
    kClose,     ///< The fingers go towards the object until all of them press it.
    kLoad,      ///< They take over its weight, and their squeeze rises with it.
    kLift,      ///< The arm goes, and the fingers hold the object by themselves.
    kMove,      ///< Likewise.
    kInsert,    ///< The arm goes against what resists.
    kPlace,     ///< It goes until something bears a part of the weight, and the fingers leave it the rest.
    kRelease,   ///< The fingers let go and open.
  };
  Kind kind = Kind::kClose;
  Eigen::Vector3d by_m = Eigen::Vector3d::Zero();        ///< How far the arm goes, in kPlace at the most; object
                                                         ///< axes at the start.
  double over_s = 0.0;                                   ///< How long that takes; of kLoad, how long the load rises.
  double press_N = 0.0;                                  ///< Of kClose: internal force, as of the control.
  double speed_m_per_s = 0.0;                            ///< Of the fingers, in kClose and kRelease.
  double open_m = 0.0;                                   ///< How far they open.
  double most_N = 0.0;                                   ///< Of kInsert: what resists the arm's way by more has jammed.
  std::optional<PidGains> position = {}, rotation = {};  ///< Of kInsert; nothing: the scene's, as the next.
  std::optional<Eigen::Vector3d> centre_m = {};
  double within_s = 0.0;  ///< What has not come about by then has failed.
};
/// "approach", "close", "load", "lift", "move", "insert", "place", "release".
[[nodiscard]] const char* to_string(Phase::Kind kind);

struct TaskSettings {
  std::vector<Phase> phases;  ///< One after the other; none: nothing but times.
  std::optional<Move> translate, rotate;
  std::optional<Spring> spring;
  std::optional<Push> push;
  std::optional<Arm> arm;
  std::vector<FrictionStep> friction;  ///< In the order of time.
  std::optional<double> lost_m;  ///< A finger that has slid so far has lost the object; nothing: its pulp's radius.
};

/// How far a scene may be off its full model where parts of it are left out: the object's path, rms and at the end, and
/// the rest as PathDeviation (engine/studies/model_parts.h) has it.
struct Tolerance {
  double position_m = 1e-4;
  double rotation_rad = std::numbers::pi / 1800.0;
  double force = 0.05;   ///< A share of the forces.
  double moment = 0.1;   ///< A share of the torsion that friction allows.
  double margin = 0.05;  ///< A difference of margins.
};

/// What a user asks of a grasp that is to be found; what is left out is chosen. Object axes.
struct GraspWish {
  std::vector<int> fingers = {};                   ///< Of the hand, by index; empty: chosen.
  std::optional<Eigen::Vector3d> axis_O = {};      ///< Unit: the line on which the fingers face each other.
  std::optional<Eigen::Vector3d> at_O = {};        ///< Near where on that line the object is held [m].
  std::optional<Eigen::Vector3d> approach_O = {};  ///< Unit: the way in which the hand comes to the object.
  std::optional<double> press_N = {};              ///< Normal load of the least loaded finger, without weight.
  int rank = 1;                                    ///< Of all that are found; 1 is the best.
  std::uint32_t seed = 1;
  std::string place = {};  ///< Of the wish in its file, for refusals: "file:line:column".

  bool operator==(const GraspWish&) const = default;
};

/// The exact solid of a shape that is one; nothing of others.
[[nodiscard]] std::optional<Solid> solid_of(const Shape& shape);

/// The surface of a shape that has a formula; nothing of one from a file.
[[nodiscard]] std::optional<ExactShape> exact_shape_of(const Shape& shape);

/// All that a scene file says, in SI. What it does not name is absent here, and costs nothing.
struct Scene {
  std::string name;
  double duration_s = 0.0;
  double step_s = 0.0;
  double control_period_s = 0.0;  ///< Not shorter than the step.
  double control_delay_s =
      0.0;  ///< From a control tick's snapshot to its frame's use, where the two have clocks of their own.
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< World = hand frame.
  Hand hand;
  JointVector posture;                 ///< q at the start.
  bool settles = false;                ///< The fingers move until they press as they are asked to: see settle().
  std::optional<GraspWish> grasp;      ///< Posture, and pose of the object, are to be found: until build_model has.
  double joint_viscosity = 0.0;        ///< b [N m s], of fingers that have no other: viscosity().
  std::optional<JointVector> torques;  ///< Without control: what drives the joints [N m].
  std::vector<Slide> slides;           ///< What moves the fingertips of a hand that slides; else none.
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
  /// Whether the contact side is to know the muscles: they have stiffness, or take time.
  [[nodiscard]] bool muscles_act() const { return has_muscles() && control->muscles->act(); }
  /// Whether muscle forces are chosen for a stiffness of the object.
  [[nodiscard]] bool chooses_stiffness() const { return has_muscles() && control->muscles->object_stiffness; }
  /// b of finger k's joints [N m s; N s/m of slides].
  [[nodiscard]] double viscosity(int k) const { return hand.fingertips[k].joint_viscosity.value_or(joint_viscosity); }
  /// Whether fingertip k goes along a path, whatever resists.
  [[nodiscard]] bool has_path(int k) const { return !slides.empty() && !slides[k].path.empty(); }
};

}  // namespace thenar
