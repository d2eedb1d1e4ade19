// SPDX-License-Identifier: Apache-2.0
#include "engine/results/tick_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

using Numbers = std::vector<double>;

bool grips(const Model& model) { return model.feels() && model.scene.control; }
bool has_phases(const Model& model) { return !model.scene.task.phases.empty(); }
bool turns(const Model& model) { return !model.scene.hand.slides; }
bool slides(const Model& model) { return model.scene.hand.slides; }

constexpr Scenes kGrip{grips, "of scenes with `fingertips.touch` and control"};
constexpr Scenes kChoose{[](const Model& model) { return model.scene.chooses_stiffness(); },
                         "of scenes that choose a stiffness"};
constexpr Scenes kWithEnvironment{[](const Model& model) { return model.scene.environment.has_value(); },
                                  "of scenes with an environment"};
constexpr Scenes kSoftObject{[](const Model& model) { return model.soft_object(); }, "of soft objects"};
constexpr Scenes kPhases{has_phases, "of scenes with a task in phases"};
constexpr Scenes kActing{[](const Model& model) { return model.scene.muscles_act(); },
                         "of scenes whose muscles have activation or stiffness"};
constexpr Scenes kTurn{turns, "of hands with joints that turn"};
constexpr Scenes kSlide{slides, "of fingertips on slides"};

// Where numbers lie.
template <auto Member>
FieldNumbers of_tick(const TickView& view) {
  return {&(view.tick.*Member)};
}
template <auto Member>
FieldNumbers vector_of_tick(const TickView& view) {
  const auto& v = view.tick.*Member;
  return {v.data(), v.size()};
}
template <auto Member>
FieldNumbers of_fingers(const TickView& view) {
  return {(view.tick.*Member).data(), view.model.fingers()};
}
template <auto Member, auto Part>
FieldNumbers part_of_fingers(const TickView& view) {
  using Record = std::remove_cvref_t<decltype(*(view.tick.*Member).data())>;
  static_assert(sizeof(Record) % sizeof(double) == 0);
  return {&((view.tick.*Member).data()->*Part), view.model.fingers(), 1, sizeof(Record) / sizeof(double)};
}
template <auto Part>
FieldNumbers load_of_fingers(const TickView& view) {
  return {(view.load.data()->*Part).data(), view.model.fingers(), 3, sizeof(FingerLoad) / sizeof(double)};
}
template <auto Part>
FieldNumbers of_grips(const TickView& view) {
  const auto& all = view.tick.reflex.grips;
  return {&(all.data()->*Part), view.model.fingers(), 1, sizeof(ContactGrip) / sizeof(double)};
}
template <auto Part>
FieldNumbers of_ledger(const TickView& view) {
  return {&(view.tick.ledger.*Part)};
}
template <auto Part>
FieldNumbers of_contact(const TickView& view) {
  return {&(view.tick.contact.*Part)};
}
template <auto Part>
FieldNumbers of_environment(const TickView& view) {
  return {&(view.tick.contact.environment.*Part)};
}
template <auto Part>
FieldNumbers of_loops(const TickView& view) {
  const auto& part = view.loops->*Part;
  if constexpr (std::is_same_v<std::remove_cvref_t<decltype(part)>, double>)
    return {&part};
  else
    return {part.data(), std::ssize(part)};
}
template <auto Part>
FieldNumbers of_stiffness(const TickView& view) {
  const auto& part = view.stiffness->*Part;
  if constexpr (std::is_same_v<std::remove_cvref_t<decltype(part)>, double>)
    return {&part};
  else
    return {part.data(), part.size()};
}
template <auto Part>
FieldNumbers of_around(const TickView& view) {
  return {(view.environment->*Part).data(), (view.environment->*Part).size()};
}
FieldNumbers angles(const TickView& view) { return {view.q.data(), view.q.size()}; }
FieldNumbers stops(const TickView& view) {
  return {view.tick.contact.stop_Nm.data(), view.tick.contact.stop_Nm.size()};
}

// Numbers that are computed.
template <auto Part>
void count_of_contact(const TickView& view, Numbers& to) {
  to.push_back(static_cast<double>(view.tick.contact.*Part));
}
template <auto Part>
void count_of_environment(const TickView& view, Numbers& to) {
  to.push_back(static_cast<double>(view.tick.contact.environment.*Part));
}
/// 0 is a stage that did not run.
void put_us(double time_s, Numbers& to) { to.push_back(time_s > 0.0 ? 1e6 * time_s : kNotMeasured); }
template <auto Stage>
void stage_us(const TickView& view, Numbers& to) {
  put_us(view.tick.*Stage, to);
}
template <auto Stage>
void contact_stage_us(const TickView& view, Numbers& to) {
  put_us(view.tick.contact.*Stage, to);
}
template <auto Part>
void of_pull(const TickView& view, Numbers& to) {
  const auto& pull = view.picture->pull;
  const Vector3d v = pull ? Vector3d((*pull).*Part) : Vector3d::Constant(kNotMeasured);
  to.insert(to.end(), v.begin(), v.end());
}
template <auto Part>
void asked_stiffness(const TickView& view, Numbers& to) {
  const Vector3d& v = (*view.model.scene.control->muscles->object_stiffness).*Part;
  to.insert(to.end(), v.begin(), v.end());
}
void put_pose(const Isometry3d& X, Numbers& to) { std::ranges::copy(pose_numbers(X), std::back_inserter(to)); }
void segment_poses(const TickView& view, Numbers& to) {
  HandPose pose;
  forward_kinematics(view.model.scene.hand, view.q, pose);
  for (const Isometry3d& X_WS : pose.segments) put_pose(X_WS, to);
}
void body_poses(const TickView& view, Numbers& to) {
  for (const Isometry3d& X_WE : view.environment->X_WE) put_pose(X_WE, to);
}
void put_displacement(const TickView& view, Numbers& to) {
  for (const Eigen::MatrixX3d& u_m : view.picture->u_m) {
    for (Index i = 0; i < u_m.rows(); ++i) {
      for (int axis = 0; axis < 3; ++axis) to.push_back(u_m(i, axis));
    }
  }
}
void body_forces(const TickView& view, Numbers& to) {
  const auto told = std::min<Index>(kToldBodies, std::ssize(view.model.scene.environment->bodies));
  const Eigen::Matrix3Xd forces_N = view.environment != nullptr
                                        ? view.environment->force_N
                                        : Eigen::Matrix3Xd(view.tick.contact.environment.body_N.leftCols(told));
  to.insert(to.end(), forces_N.data(), forces_N.data() + forces_N.size());
}
template <int kFirst>
void environment_wrench(const TickView& view, Numbers& to) {
  for (int i = kFirst; i < kFirst + 3; ++i) to.push_back(view.tick.contact.environment.wrench[i]);
}

constexpr auto kFields = std::to_array<TickField>({
    {.name = "time_s",
     .unit = "s",
     .sentence = "Simulated time at the end of the tick.",
     .block = Block::kTime,
     .at = of_tick<&TickRecord::time_s>},
    {.name = "tick",
     .of = Of::kCount,
     .sentence = "Contact ticks done.",
     .compute = [](const TickView& v, Numbers& to) { to.push_back(static_cast<double>(v.number)); }},
    {.name = "frame",
     .of = Of::kCount,
     .sentence = "Sequence number of the frame in use; -1: none yet.",
     .compute = count_of_contact<&TickReport::sequence>},
    {.name = "held",
     .of = Of::kFlag,
     .sentence = "The frame is too old, and its drive is held.",
     .compute = count_of_contact<&TickReport::held>},
    {.name = "object",
     .unit = "m",
     .of = Of::kPose,
     .shown = "object_pose",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Pose of the object, world axes.",
     .at = [](const TickView& v) -> FieldNumbers { return {v.X_WO.data()}; }},
    {.name = "target",
     .unit = "m",
     .of = Of::kPose,
     .shown = "target_pose",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Pose where the object should be, world axes.",
     .at = [](const TickView& v) -> FieldNumbers { return {v.tick.X_WT.data()}; }},
    {.name = "q_rad",
     .unit = "rad",
     .of = Of::kJoint,
     .shown_unit = "rad",
     .sentence = "Joint angles.",
     .scenes = &kTurn,
     .block = Block::kJoints,
     .at = angles},
    {.name = "q_m",
     .unit = "m",
     .of = Of::kJoint,
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "How far fingertips on slides are from where they began.",
     .scenes = &kSlide,
     .block = Block::kJoints,
     .at = angles},
    {.name = "stop_Nm",
     .unit = "N m",
     .of = Of::kJoint,
     .shown = "stop",
     .shown_unit = "Nm",
     .sentence = "What the stops at the ends of the joints' ranges bear.",
     .scenes = &kTurn,
     .at = stops},
    {.name = "stop_N",
     .unit = "N",
     .of = Of::kJoint,
     .shown = "stop",
     .shown_unit = "N",
     .sentence = "What the stops at the ends of the slides bear.",
     .scenes = &kSlide,
     .at = stops},
    {.name = "segments",
     .unit = "m",
     .of = Of::kShape,
     .sentence = "Poses of the hand's segments: position, then rotation by rows.",
     .compute = segment_poses},
    {.name = "force_N",
     .unit = "N",
     .of = Of::kFingerAxis,
     .shown = "force",
     .shown_unit = "N",
     .sentence = "Force of each finger on the object, world axes.",
     .at = load_of_fingers<&FingerLoad::force_N>},
    {.name = "desired_N",
     .unit = "N",
     .of = Of::kFingerAxis,
     .shown = "desired_force",
     .shown_unit = "N",
     .sentence = "What the controller asks of each finger, world axes.",
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.tick.desired_N.data()->data(), v.model.fingers(), 3, 3};
     }},
    {.name = "centre_m",
     .unit = "m",
     .of = Of::kFingerAxis,
     .shown = "centre",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Pressure centre of each finger, world axes.",
     .at = load_of_fingers<&FingerLoad::centre_m>},
    {.name = "normal",
     .of = Of::kFingerAxis,
     .shown = "contact_normal",
     .sentence = "Mean normal of each finger's contacts, into the object, world axes.",
     .at = load_of_fingers<&FingerLoad::normal>},
    {.name = "normal_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "normal",
     .shown_unit = "N",
     .sentence = "Part of `force_N` along the normal.",
     .block = Block::kGrip,
     .at = part_of_fingers<&TickRecord::force, &NormalTangential::normal_N>},
    {.name = "tangential_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "tangential",
     .shown_unit = "N",
     .sentence = "Part of `force_N` across the normal.",
     .block = Block::kGrip,
     .at = part_of_fingers<&TickRecord::force, &NormalTangential::tangential_N>},
    {.name = "desired_normal_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "desired_normal",
     .shown_unit = "N",
     .sentence = "Part of `desired_N` along the normal.",
     .block = Block::kGrip,
     .at = part_of_fingers<&TickRecord::force_desired, &NormalTangential::normal_N>},
    {.name = "desired_tangential_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "desired_tangential",
     .shown_unit = "N",
     .sentence = "Part of `desired_N` across the normal.",
     .block = Block::kGrip,
     .at = part_of_fingers<&TickRecord::force_desired, &NormalTangential::tangential_N>},
    {.name = "force_error_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "force_error",
     .shown_unit = "N",
     .sentence = "Length of `desired_N` - `force_N`.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::force_error_N>},
    {.name = "margin",
     .of = Of::kFinger,
     .shown = "margin",
     .sentence = "Friction to spare, of force and torsion together: 1 without tangential load, 0 where the whole "
                 "patch slides or turns; NaN without load.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::margin>},
    {.name = "slip_m",
     .unit = "m",
     .of = Of::kFinger,
     .shown = "slip",
     .shown_unit = "um",
     .factor = 1e6,
     .sentence = "How far each patch has moved on the object since its first contact.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::slip_m>},
    {.name = "start_slip_m",
     .unit = "m",
     .of = Of::kFinger,
     .shown = "start_slip",
     .shown_unit = "um",
     .factor = 1e6,
     .sentence = "The part of `slip_m` in the first 0.3 s.",
     .at = of_fingers<&TickRecord::start_slip_m>},
    {.name = "spin_rad",
     .unit = "rad",
     .of = Of::kFinger,
     .shown = "spin",
     .shown_unit = "deg",
     .factor = kDegrees,
     .sentence = "How far each patch has turned on the object since its first contact.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::spin_rad>},
    {.name = "start_spin_rad",
     .unit = "rad",
     .of = Of::kFinger,
     .shown = "start_spin",
     .shown_unit = "deg",
     .factor = kDegrees,
     .sentence = "The part of `spin_rad` in the first 0.3 s.",
     .at = of_fingers<&TickRecord::start_spin_rad>},
    {.name = "walk_m",
     .unit = "m",
     .of = Of::kFingerAxis,
     .shown = "walk",
     .shown_unit = "um",
     .factor = 1e6,
     .sentence =
         "Net way of each patch on the object from 0.3 s on: the sum of its slips as vectors, the object's axes.",
     .block = Block::kGrip,
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.tick.walk_m.data()->data(), v.model.fingers(), 3, 3};
     }},
    {.name = "turn_rad",
     .unit = "rad",
     .of = Of::kFinger,
     .shown = "turn",
     .shown_unit = "deg",
     .factor = kDegrees,
     .sentence = "Net turn of each patch on the object from 0.3 s on, about its normal into the object.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::turn_rad>},
    {.name = "dent_m",
     .unit = "m",
     .of = Of::kFingerAxis,
     .shown = "dent",
     .shown_unit = "um",
     .factor = 1e6,
     .sentence = "How far the object's surface has given way under each patch: the mean of u_o at its points, weighted "
                 "by normal force, the object's axes.",
     .scenes = &kSoftObject,
     .block = Block::kGrip,
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.tick.contact.patch.data()->dent_O.data(), v.model.fingers(), 3, sizeof(PatchReport) / sizeof(double)};
     }},
    {.name = "sliding_share",
     .of = Of::kFinger,
     .shown = "sliding_share",
     .sentence = "Share of the normal force on points that slide.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::sliding_share>},
    {.name = "creep_m_per_s",
     .unit = "m/s",
     .of = Of::kFinger,
     .shown = "creep",
     .shown_unit = "um_per_s",
     .factor = 1e6,
     .sentence = "Speed of the fastest loaded point inside its friction cone.",
     .block = Block::kGrip,
     .at = of_fingers<&TickRecord::creep_m_per_s>},
    {.name = "stick",
     .of = Of::kFinger,
     .shown = "stick",
     .sentence = "Share of each patch's loaded area that sticks.",
     .scenes = &kFeelingScenes,
     .block = Block::kTouch,
     .at = part_of_fingers<&TickRecord::touch, &Touch::stick>},
    {.name = "rim_friction",
     .of = Of::kFinger,
     .shown = "rim_friction",
     .sentence = "Friction where the patch slips; NaN where nothing does.",
     .scenes = &kFeelingScenes,
     .block = Block::kTouch,
     .at = part_of_fingers<&TickRecord::touch, &Touch::friction>},
    {.name = "slip_speed_m_per_s",
     .unit = "m/s",
     .of = Of::kFinger,
     .shown = "slip_speed",
     .shown_unit = "um_per_s",
     .factor = 1e6,
     .sentence = "Mean speed of what slips of the patch.",
     .scenes = &kFeelingScenes,
     .block = Block::kTouch,
     .at = part_of_fingers<&TickRecord::touch, &Touch::slip_m_per_s>},
    {.name = "torsion_Nm",
     .unit = "N m",
     .of = Of::kFinger,
     .shown = "torsion",
     .shown_unit = "N_mm",
     .factor = 1e3,
     .sentence = "Moment about the mean normal.",
     .scenes = &kFeelingScenes,
     .at = part_of_fingers<&TickRecord::touch, &Touch::moment_Nm>},
    {.name = "friction_felt",
     .of = Of::kFinger,
     .shown = "friction_felt",
     .sentence = "Friction that the hand has felt last, or expects; 0 before it does.",
     .scenes = &kGrip,
     .block = Block::kTouch,
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.tick.reflex.friction.data(), v.model.fingers()};
     }},
    {.name = "squeeze_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "squeeze",
     .shown_unit = "N",
     .sentence = "By how much the controller lets each finger squeeze.",
     .scenes = &kGrip,
     .block = Block::kTouch,
     .at = of_grips<&ContactGrip::internal_force_N>},
    {.name = "reflex",
     .of = Of::kCount,
     .sentence = "What the grip began to answer before this tick: 0 nothing, 1 a load, 2 a slip.",
     .scenes = &kGrip,
     .block = Block::kReflex,
     .compute = [](const TickView& v,
                   Numbers& to) { to.push_back(v.tick.controlled ? static_cast<double>(v.tick.reflex.event) : 0.0); }},
    {.name = "last_reflex",
     .of = Of::kCount,
     .sentence = "The last answer since the start, as `reflex`.",
     .scenes = &kGrip,
     .compute = [](const TickView& v, Numbers& to) { to.push_back(static_cast<double>(v.tick.last_reflex.event)); }},
    {.name = "last_reflex_finger",
     .sentence = "Which finger felt it most, from 0 on; NaN before the first.",
     .scenes = &kGrip,
     .compute =
         [](const TickView& v, Numbers& to) {
           to.push_back(v.tick.last_reflex.event == ReflexEvent::kNone ? kNotMeasured : v.tick.last_reflex.finger);
         }},
    {.name = "last_reflex_s",
     .unit = "s",
     .sentence = "When it began; NaN before the first.",
     .scenes = &kGrip,
     .compute =
         [](const TickView& v, Numbers& to) {
           to.push_back(v.tick.last_reflex.event == ReflexEvent::kNone ? kNotMeasured : v.tick.last_reflex.time_s);
         }},
    {.name = "asked_N_per_m",
     .unit = "N/m",
     .of = Of::kList,
     .sentence = "Stiffness that is asked for along the object's axes.",
     .scenes = &kChoose,
     .from = From::kState,
     .compute = asked_stiffness<&ObjectStiffness::translation_N_per_m>},
    {.name = "asked_Nm_per_rad",
     .unit = "N m/rad",
     .of = Of::kList,
     .sentence = "Stiffness that is asked for about the object's axes.",
     .scenes = &kChoose,
     .from = From::kState,
     .compute = asked_stiffness<&ObjectStiffness::rotation_Nm_per_rad>},
    {.name = "stiffness_share",
     .sentence = "Share of it that the last control period had.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::share>},
    {.name = "stiffness_squeeze_N",
     .unit = "N",
     .sentence = "By how much the internal force is raised for it.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::squeeze_N>},
    {.name = "stiffness_N_per_m",
     .unit = "N/m",
     .of = Of::kList,
     .sentence = "Stiffness that the chosen forces make, object axes, by columns: of the force for a motion without "
                 "a turn.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::along_N_per_m>},
    {.name = "stiffness_Nm_per_rad",
     .unit = "N m/rad",
     .of = Of::kList,
     .sentence = "The same of the moment for a turn about `object_stiffness.centre_m`.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::about_Nm_per_rad>},
    {.name = "lack_s",
     .unit = "s",
     .sentence = "When a control period last found no forces for it.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::lack_s>},
    {.name = "lack_N_per_m",
     .unit = "N/m",
     .sentence = "How much was lacking then along an axis; NaN where another cause was found.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::lack_N_per_m>},
    {.name = "lack_Nm_per_rad",
     .unit = "N m/rad",
     .sentence = "How much was lacking then about an axis; NaN where another cause was found.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::lack_Nm_per_rad>},
    {.name = "lack_axis",
     .of = Of::kList,
     .sentence = "That axis, object axes.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::lack_axis>},
    {.name = "lack_muscles",
     .of = Of::kList,
     .sentence = "Of each muscle, 1: it was at its limit then.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::at_limit>},
    {.name = "least_muscles_N",
     .unit = "N",
     .of = Of::kList,
     .sentence = "Of each muscle, the least force for the same torques.",
     .scenes = &kChoose,
     .from = From::kState,
     .at = of_stiffness<&ShownStiffness::least_N>},
    {.name = "bodies",
     .unit = "m",
     .of = Of::kShape,
     .sentence = "Pose of each body: position, then rotation by rows.",
     .scenes = &kWithEnvironment,
     .from = From::kPicture,
     .compute = body_poses},
    {.name = "bodies_N",
     .unit = "N",
     .of = Of::kBodyAxis,
     .shown = "environment_force",
     .shown_unit = "N",
     .sentence =
         "Force of each body of the environment on the object, world axes; in messages of all bodies, elsewhere "
         "of the first 16.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .compute = body_forces},
    {.name = "bodies_m",
     .unit = "m",
     .of = Of::kList,
     .sentence = "Mean of the points where each body touches the object, by normal force; NaN where it does not.",
     .scenes = &kWithEnvironment,
     .from = From::kPicture,
     .at = of_around<&ShownEnvironment::mean_m>},
    {.name = "touches_m",
     .unit = "m",
     .of = Of::kShape,
     .sentence = "Points of the contacts with bodies that carry most force, 64 at most, the strongest first; NaN "
                 "behind the last.",
     .scenes = &kWithEnvironment,
     .from = From::kPicture,
     .at = of_around<&ShownEnvironment::point_m>},
    {.name = "touches_N",
     .unit = "N",
     .of = Of::kShape,
     .sentence = "Their forces on the object.",
     .scenes = &kWithEnvironment,
     .from = From::kPicture,
     .at = of_around<&ShownEnvironment::touch_N>},
    {.name = "touches_margin",
     .of = Of::kShape,
     .sentence = "Their 1 - f_t / (mu f_n).",
     .scenes = &kWithEnvironment,
     .from = From::kPicture,
     .at = of_around<&ShownEnvironment::margin>},
    {.name = "phase",
     .of = Of::kCount,
     .sentence = "Which phase of the task runs, from 0 on; as many as there are: all are done; -1: it has none.",
     .scenes = &kPhases,
     .block = Block::kTask,
     .compute = [](const TickView& v, Numbers& to) { to.push_back(v.tick.phase); }},
    {.name = "borne_N",
     .unit = "N",
     .sentence = "What the fingers bear against gravity.",
     .scenes = &kPhases,
     .block = Block::kTask,
     .at = of_tick<&TickRecord::borne_N>},
    {.name = "arm_m",
     .unit = "m",
     .of = Of::kAxis,
     .shown = "arm",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Where the arm is, object axes at the start.",
     .scenes = &kPhases,
     .block = Block::kTask,
     .at = vector_of_tick<&TickRecord::arm_m>},
    {.name = "friction",
     .sentence = "Friction of the contacts at this time.",
     .compute = [](const TickView& v, Numbers& to) { to.push_back(v.model.friction(v.tick.time_s)); }},
    {.name = "position_m",
     .unit = "m",
     .of = Of::kAxis,
     .shown = "position",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Displacement of the object from its start, object axes at the start.",
     .block = Block::kPath,
     .at = vector_of_tick<&TickRecord::position_m>},
    {.name = "path_target_m",
     .unit = "m",
     .of = Of::kAxis,
     .shown = "target",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Where it should be, likewise.",
     .block = Block::kPath,
     .at = vector_of_tick<&TickRecord::target_m>},
    {.name = "rotation_error_rad",
     .unit = "rad",
     .shown = "rotation_error",
     .shown_unit = "deg",
     .factor = kDegrees,
     .sentence = "Angle between the object and its target.",
     .block = Block::kPath,
     .at = of_tick<&TickRecord::rotation_error_rad>},
    {.name = "muscles_N",
     .unit = "N",
     .of = Of::kMuscle,
     .shown_unit = "N",
     .sentence =
         "Forces with which the muscles pulled: by their activation, and by their stretch at the tick's end. Of "
         "one that pulls several fingers, the sum.",
     .block = Block::kMuscles,
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.muscle_N.data(), std::ssize(v.muscle_N)};
     }},
    {.name = "muscles_asked_N",
     .unit = "N",
     .of = Of::kMuscle,
     .shown = "asked",
     .shown_unit = "N",
     .sentence = "Muscle forces that were asked for.",
     .scenes = &kActing,
     .block = Block::kMuscles,
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.asked_N.data(), std::ssize(v.asked_N)};
     }},
    {.name = "pull_anchor_m",
     .unit = "m",
     .of = Of::kAxis,
     .shown = "pull_anchor",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Where the spring of a drag acts on the object; NaN without one.",
     .from = From::kPicture,
     .compute = of_pull<&ShownPull::anchor_m>},
    {.name = "pull_handle_m",
     .unit = "m",
     .of = Of::kAxis,
     .shown = "pull_handle",
     .shown_unit = "mm",
     .factor = 1e3,
     .sentence = "Where its other end is; NaN without one.",
     .from = From::kPicture,
     .compute = of_pull<&ShownPull::handle_m>},
    {.name = "pull_force_N",
     .unit = "N",
     .of = Of::kAxis,
     .shown = "pull_force",
     .shown_unit = "N",
     .sentence = "Its force on the object; NaN without one.",
     .from = From::kPicture,
     .compute = of_pull<&ShownPull::force_N>},
    {.name = "contacts",
     .of = Of::kCount,
     .sentence = "Contacts of the tick.",
     .block = Block::kSolve,
     .compute = count_of_contact<&TickReport::contacts>},
    {.name = "active",
     .of = Of::kCount,
     .sentence = "Those that carry force.",
     .block = Block::kSolve,
     .compute = count_of_contact<&TickReport::active>},
    {.name = "sweeps",
     .of = Of::kCount,
     .sentence = "Sweeps of the contact solve.",
     .block = Block::kSolve,
     .compute = [](const TickView& v, Numbers& to) { to.push_back(v.tick.contact.solve.sweeps); }},
    {.name = "residual",
     .sentence = "Residual of the contact solve: natural map.",
     .block = Block::kSolve,
     .compute = [](const TickView& v, Numbers& to) { to.push_back(v.tick.contact.solve.residual); }},
    {.name = "penetration_m",
     .unit = "m",
     .shown = "penetration",
     .shown_unit = "um",
     .factor = 1e6,
     .sentence = "The deepest of all control points in the object.",
     .block = Block::kSolve,
     .at = of_contact<&TickReport::penetration_m>},
    {.name = "environment_force_N",
     .unit = "N",
     .of = Of::kAxis,
     .shown = "environment_force",
     .shown_unit = "N",
     .sentence = "Force of the environment on the object, world axes.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .compute = environment_wrench<0>},
    {.name = "environment_moment_Nm",
     .unit = "N m",
     .of = Of::kAxis,
     .shown = "environment_moment",
     .shown_unit = "N_mm",
     .factor = 1e3,
     .sentence = "Its moment about the object's origin, world axes.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .compute = environment_wrench<3>},
    {.name = "environment_normal_N",
     .unit = "N",
     .sentence = "Sum of its normal forces.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .at = of_environment<&EnvironmentReport::normal_N>},
    {.name = "environment_contacts",
     .of = Of::kCount,
     .sentence = "Its contacts within the band.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .compute = count_of_environment<&EnvironmentReport::contacts>},
    {.name = "environment_active",
     .of = Of::kCount,
     .sentence = "Those that carry force.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .compute = count_of_environment<&EnvironmentReport::active>},
    {.name = "environment_penetration_m",
     .unit = "m",
     .shown = "environment_penetration",
     .shown_unit = "um",
     .factor = 1e6,
     .sentence = "How far object and body give way to each other, at the most.",
     .scenes = &kWithEnvironment,
     .block = Block::kAround,
     .at = of_environment<&EnvironmentReport::penetration_m>},
    {.name = "frame_age_s",
     .unit = "s",
     .sentence = "Time from the frame's snapshot to the start of the tick.",
     .compute =
         [](const TickView& v, Numbers& to) {
           to.push_back(static_cast<double>(v.tick.contact.frame_age) * v.model.scene.step_s);
         }},
    {.name = "grasp_failed",
     .of = Of::kFlag,
     .sentence = "The control tick found no grasp forces.",
     .compute = [](const TickView& v,
                   Numbers& to) { to.push_back(v.tick.grasp == GraspStatus::kOptimal ? 0.0 : 1.0); }},
    {.name = "muscles_failed",
     .of = Of::kFlag,
     .sentence = "The control tick found no muscle forces.",
     .compute = [](const TickView& v,
                   Numbers& to) { to.push_back(v.tick.muscle == MuscleStatus::kOptimal ? 0.0 : 1.0); }},
    {.name = "find_us",
     .unit = "us",
     .sentence = "Time of contact finding; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = stage_us<&TickRecord::find_s>},
    {.name = "factors_us",
     .unit = "us",
     .sentence = "Time of what a frame needs beside its contacts; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = stage_us<&TickRecord::factors_s>},
    {.name = "grasp_us",
     .unit = "us",
     .sentence = "Time of grasp forces; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = stage_us<&TickRecord::grasp_s>},
    {.name = "muscle_us",
     .unit = "us",
     .sentence = "Time of muscle forces; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = stage_us<&TickRecord::muscle_s>},
    {.name = "assemble_us",
     .unit = "us",
     .sentence = "Time of assembly of the contact problem; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = contact_stage_us<&TickReport::assemble_s>},
    {.name = "solve_us",
     .unit = "us",
     .sentence = "Time of the contact solve; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = contact_stage_us<&TickReport::solve_s>},
    {.name = "deform_us",
     .unit = "us",
     .sentence = "Time of deformation of the fingertips; in the window, the median of the last second.",
     .from = From::kClock,
     .compute = contact_stage_us<&TickReport::deform_s>},
    {.name = "contact_Hz",
     .unit = "Hz",
     .sentence = "Rate of the contact loop in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::contact_Hz>},
    {.name = "contact_compute_us",
     .unit = "us",
     .of = Of::kPercentile,
     .shown = "contact_compute",
     .shown_unit = "us",
     .sentence = "Compute time of its ticks in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::contact_compute_us>},
    {.name = "contact_jitter_us",
     .unit = "us",
     .of = Of::kPercentile,
     .shown = "contact_jitter",
     .shown_unit = "us",
     .sentence = "Lateness of its ticks in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::contact_jitter_us>},
    {.name = "contact_overruns",
     .sentence = "Its ticks that took longer than their period, since the start.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::contact_overruns>},
    {.name = "contact_slipped",
     .sentence = "Its ticks that were left out, since the start.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::contact_slipped>},
    {.name = "control_Hz",
     .unit = "Hz",
     .sentence = "Rate of the control loop in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::control_Hz>},
    {.name = "control_compute_us",
     .unit = "us",
     .of = Of::kPercentile,
     .shown = "control_compute",
     .shown_unit = "us",
     .sentence = "Compute time of its ticks in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::control_compute_us>},
    {.name = "control_jitter_us",
     .unit = "us",
     .of = Of::kPercentile,
     .shown = "control_jitter",
     .shown_unit = "us",
     .sentence = "Lateness of its ticks in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::control_jitter_us>},
    {.name = "control_slipped",
     .sentence = "Its ticks that were left out, since the start.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::control_slipped>},
    {.name = "realtime_factor",
     .sentence = "Simulated over wall time in the last second.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::realtime_factor>},
    {.name = "drive_J",
     .unit = "J",
     .sentence = "Work of the drive, since the start.",
     .at = of_ledger<&Ledger::drive_J>},
    {.name = "viscous_J",
     .unit = "J",
     .sentence = "Work of the viscosities, since the start.",
     .at = of_ledger<&Ledger::viscous_J>},
    {.name = "deformation_J",
     .unit = "J",
     .sentence = "Work on the pulps and a soft object, since the start.",
     .at = of_ledger<&Ledger::deformation_J>},
    {.name = "stored_J", .unit = "J", .sentence = "Energy that these hold now.", .at = of_ledger<&Ledger::stored_J>},
    {.name = "injected_J",
     .unit = "J",
     .sentence = "Work of contacts that give energy, since the start.",
     .at = of_ledger<&Ledger::injected_J>},
    {.name = "dissipated_J",
     .unit = "J",
     .sentence = "Work of contacts that take energy, since the start.",
     .at = of_ledger<&Ledger::dissipated_J>},
    {.name = "dropped_J",
     .unit = "J",
     .sentence = "Elastic energy that went with contacts that are no more, since the start.",
     .at = of_ledger<&Ledger::dropped_J>},
    {.name = "unaccounted",
     .sentence = "Frames and snapshots that the buffers lost or tore, counted when the loops rest: should be 0; NaN "
                 "before the first count.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::unaccounted>},
    {.name = "lost_records",
     .sentence = "Records of ticks of both loops that found no room since the start: should be 0.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::lost_records>},
    {.name = "reference_error",
     .sentence = "Relative difference of a tick's contact forces from an accurate solve.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::reference_error>},
    {.name = "reference_residual",
     .sentence = "Residual of these forces.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::reference_residual>},
    {.name = "latency_us",
     .unit = "us",
     .of = Of::kPercentile,
     .shown = "latency",
     .shown_unit = "us",
     .sentence = "Time from an input to the first force that saw it, since the start.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::latency_us>},
    {.name = "latency_counts",
     .of = Of::kShape,
     .sentence = "How many of them in bins of a factor sqrt(2) from 50 us on; the first and the last are open.",
     .from = From::kLoops,
     .at = of_loops<&LoopFigures::latency_counts>},
    {.name = "displacement_m",
     .unit = "m",
     .of = Of::kShape,
     .sentence = "Displacements of the control points, distal axes: the surface of a pulp moves by -u.",
     .from = From::kPicture,
     .compute = put_displacement},
    {.name = "torques_Nm",
     .unit = "N m",
     .of = Of::kJoint,
     .shown = "torque",
     .shown_unit = "Nm",
     .sentence = "What the controller asks of the joints.",
     .scenes = &kTurn,
     .at = vector_of_tick<&TickRecord::torques_Nm>},
    {.name = "felt_normal_N",
     .unit = "N",
     .of = Of::kFinger,
     .shown = "felt_normal",
     .shown_unit = "N",
     .sentence = "Load along the mean normal, with the noise of what is felt.",
     .scenes = &kFeelingScenes,
     .at = part_of_fingers<&TickRecord::touch, &Touch::normal_N>},
    {.name = "felt_tangential_N",
     .unit = "N",
     .of = Of::kFingerAxis,
     .shown = "felt_tangential",
     .shown_unit = "N",
     .sentence = "Load across it, likewise, world axes.",
     .scenes = &kFeelingScenes,
     .at = [](const TickView& v) -> FieldNumbers {
       return {v.tick.touch.data()->tangential_N.data(), v.model.fingers(), 3, sizeof(Touch) / sizeof(double)};
     }},
    {.name = "cone_friction",
     .of = Of::kFinger,
     .shown = "cone_friction",
     .sentence = "Friction of the cones that the controller plans with.",
     .scenes = &kGrip,
     .at = of_grips<&ContactGrip::friction>},
});

}  // namespace

TickView view_of(const Model& model, const TickRecord& tick, std::span<const double> muscle_N,
                 std::span<const double> asked_N) {
  const auto number = static_cast<std::int64_t>(std::llround(tick.time_s / model.scene.step_s));
  return {model, tick, number, tick.q_rad, tick.X_WO, tick.load, muscle_N, asked_N};
}

std::span<const TickField> tick_fields() { return kFields; }

const TickField* tick_field(std::string_view name) {
  const auto* const field = std::ranges::find(kFields, name, &TickField::name);
  return field == kFields.end() ? nullptr : field;
}

void add_numbers(const TickField& field, const TickView& view, std::vector<double>& to) {
  if (field.compute != nullptr) return field.compute(view, to);
  const FieldNumbers place = field.at(view);
  if (field.of == Of::kPose) return put_pose(Isometry3d(Eigen::Map<const Eigen::Matrix4d>(place.first)), to);
  for (Index row = 0; row < place.rows; ++row) {
    const double* const first = place.first + row * place.stride;
    to.insert(to.end(), first, first + place.columns);
  }
}

std::array<double, 12> pose_numbers(const Isometry3d& X) {
  std::array<double, 12> numbers{};
  Eigen::Map<Vector3d> position(numbers.data());
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(numbers.data() + 3);
  position = X.translation();
  rotation = X.linear();
  return numbers;
}

}  // namespace thenar
