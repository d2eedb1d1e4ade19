// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "engine/control/task_order.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/object_bounds.h"

/// The map `task` of a scene.
namespace thenar {

using Eigen::Vector3d;
using enum Dimension;
using PhaseKind = Phase::Kind;

namespace {

void describe_translation(Visitor& v, Move& move) {
  const Vector3d now_m = move.amount * move.axis;
  Vector3d by_m = now_m;
  v.key({"by", kLength, "", "", "How far, along the object's axes at the start."}, by_m);
  if (by_m != now_m) {  // Else rounding would change it.
    move.amount = by_m.norm();
    if (move.amount > 0.0) move.axis = by_m / move.amount;
  }
  v.key({"from", kTime, ">= 0", "", "When it begins."}, move.from_s);
  v.key({"over", kTime, "> 0", "", "How long it takes."}, move.over_s);
}

void describe_turn(Visitor& v, Move& move) {
  v.key({"by", kAngle, "", "", "How far."}, move.amount);
  describe_direction(v, {"about", kNone, "", "", "The axis in the object's axes at the start, of any length but zero."},
                     move.axis);
  v.key({"from", kTime, ">= 0", "", "When it begins."}, move.from_s);
  v.key({"over", kTime, "> 0", "", "How long it takes."}, move.over_s);
}

void describe(Visitor& v, Push& push, const Shape& shape) {
  // One of the two is asked for: the force, unless there is a moment.
  if (v.is_there("force", true) || !v.has("moment"))
    v.key({"force", kForce, "", "(Required without task.push.moment.)", "The force."}, push.force_N);
  v.key(
      {"at", kLength, "", "(Without it: its origin.)", "Where the force acts, in the object frame, inside the object."},
      push.at_m);
  if (v.has("at")) {
    check_is_in_object(v, "at", push.at_m, shape);
    if (!v.has("force")) v.refuse("at", "is where a force acts, and there is none: name it, or leave this out");
  }
  v.key({"moment", kTorque, "", "(Without it no moment acts.)", "The moment, with the force or alone."},
        push.moment_Nm);
  v.key({"from", kTime, ">= 0", "", "When it begins."}, push.from_s);
  v.key({"over", kTime, "> 0", "", "How long it lasts."}, push.over_s);
  v.key({"rise", kTime, ">= 0", "(Without it all of it acts at once.)",
         "How long it takes to grow from nothing, linearly."},
        push.rise_s);
  if (push.rise_s > push.over_s) v.refuse("rise", "must not take longer than the push");
}

void describe(Visitor& v, Arm& arm) {
  describe_direction(
      v, {"along", kNone, "", "", "The line, in the object's axes at the start, of any length but zero."}, arm.axis);
  v.key({"amplitude", kLength, "> 0", "", "How far it swings to either side."}, arm.amplitude_m);
  v.key({"frequency", kFrequency, "0.01 Hz .. 100 Hz", "", "Swings a second."}, arm.frequency_Hz);
  v.key({"from", kTime, ">= 0", "", "When it begins: over the first swing, and from the last, it swings less."},
        arm.from_s);
  v.key({"over", kTime, "> 0", "", "How long it lasts."}, arm.over_s);
}

constexpr KeyRow kOver{"over", kTime, "> 0", "", "How long that takes, by minimum jerk."};

/// How far the arm goes in a phase.
void describe_way(Visitor& v, Phase& phase) {
  v.key({"by", kLength, "", "", "How far the arm goes, along the object's axes at the start."}, phase.by_m);
  v.key(kOver, phase.over_s);
}

void describe_closing(Visitor& v, Phase& phase) {
  v.key({"press", kForce, "> 0", "", "The internal force then."}, phase.press_N);
  v.key({"speed", kSpeed, "> 0", "", "How fast a finger goes along the object's nearest normal."}, phase.speed_m_per_s);
}

void describe_loading(Visitor& v, Phase& phase) {
  v.key({"over", kTime, "> 0", "", "How long they rise."}, phase.over_s);
}

void describe_insertion(Visitor& v, Phase& phase) {
  describe_way(v, phase);
  v.key({"most_force", kForce, "> 0", "", "What resists by more has jammed."}, phase.most_N);
  v.map({"position", kNone, "", "(Without it: control.position.)",
         "The PID controller of the object's position in this phase, and in a place that follows it. Without an "
         "integral gain it does not push on against a wall."},
        phase.position, [&](PidGains& gains) { describe_position_gains(v, gains); });
  v.map({"rotation", kNone, "", "(Without it: control.rotation.)", "That of its rotation."}, phase.rotation,
        [&](PidGains& gains) { describe_rotation_gains(v, gains); });
  v.key({"centre", kLength, "", "(Without it: control.centre.)",
         "The point that position keeps at its place, object frame."},
        phase.centre_m);
}

void describe_placing(Visitor& v, Phase& phase) {
  v.key({"by", kLength, "", "", "How far the arm goes at the most, along the object's axes at the start."}, phase.by_m);
  v.key(kOver, phase.over_s);
}

void describe_release(Visitor& v, Phase& phase) {
  v.key({"open", kLength, "> 0", "", "How far, along the object's normals."}, phase.open_m);
  v.key({"speed", kSpeed, "> 0", "", "How fast."}, phase.speed_m_per_s);
}

/// After so long beyond its way, or what else takes so long, a phase has failed.
void describe_within(Visitor& v, Phase& phase) {
  constexpr double kPatience_s = 10.0;
  const bool opens = phase.kind == PhaseKind::kRelease && phase.speed_m_per_s > 0.0;
  const double least_s = opens ? phase.open_m / phase.speed_m_per_s : phase.over_s;
  std::optional<double> within_s = phase.within_s;
  v.key(
      {"within", kTime, "> 0", "(Without it: 10 s more than it takes.)", "What has not come about by then has failed."},
      within_s);
  if (within_s && *within_s < least_s) {
    v.refuse("within", fmt::format("must not be less than the {:g} s that it takes", least_s));
  }
  phase.within_s = within_s.value_or(least_s + kPatience_s);
}

struct PhaseKeys {
  PhaseKind kind;
  std::string_view sentence;
  void (*describe)(Visitor& v, Phase& phase);
};

constexpr std::array kPhases = std::to_array<PhaseKeys>({
    {PhaseKind::kApproach, "The arm goes, the fingers still and clear of the object.", describe_way},
    {PhaseKind::kClose, "The fingers go towards the object until all of them press it.", describe_closing},
    {PhaseKind::kLoad,
     "The fingers take over the object's weight, and their squeeze rises with it to control.grasp.internal_force.",
     describe_loading},
    {PhaseKind::kLift, "The arm goes; in the end the fingers bear the weight, no less and no more.", describe_way},
    {PhaseKind::kMove, "The same, in any direction.", describe_way},
    {PhaseKind::kInsert, "The arm goes against what resists.", describe_insertion},
    {PhaseKind::kPlace,
     "The arm goes until something bears half of the weight, stops, and the fingers leave it the rest.",
     describe_placing},
    {PhaseKind::kRelease, "The fingers let go, and open.", describe_release},
});

/// False: it is none of them, which is reported.
bool describe(Visitor& v, Phase& phase) {
  const PhaseKind kind = phase.kind;
  bool is_one = false;
  for (const PhaseKeys& keys : kPhases) {
    const char* const name = to_string(keys.kind);
    if (!v.chooses(name, keys.kind == kind)) continue;
    phase.kind = keys.kind;
    is_one = true;
    v.map({name, kNone, "", "(Each phase is one of these.)", keys.sentence}, [&] {
      keys.describe(v, phase);
      describe_within(v, phase);
    });
  }
  return is_one;
}

void describe_phases(Visitor& v, std::vector<Phase>& phases) {
  std::size_t i = 0;
  bool is_sound = true;
  v.list({"phases", kNone, "", "(Without it a task goes by times alone.)",
          "The phases of a task in an environment, one after the other. Each ends when what it is for has come about, "
          "and fails if that takes too long. Where the arm goes, what is around the object goes the other way."},
         phases, [&](Phase& phase) {
           is_sound = describe(v, phase) && is_sound;
           const char* const name = to_string(phase.kind);
           const std::string fault = is_sound ? order_fault(phases, i++) : "";
           if (!fault.empty()) v.refuse(name, fault);
           is_sound = is_sound && !v.is_refused(name);
         });
}

/// Rules between the phases and the rest of the scene.
void check_phases(Visitor& v, const Scene& scene) {
  const std::vector<Phase>& phases = scene.task.phases;
  const auto refuse_if = [&](bool wrong, const char* why) {
    if (wrong) v.refuse("phases", why);
  };
  const auto has = [&](PhaseKind kind) { return std::ranges::find(phases, kind, &Phase::kind) != phases.end(); };
  refuse_if(phases.empty(), "names no phase");
  refuse_if(!scene.control, "needs control, which goes through them");
  refuse_if(!scene.environment, "needs an environment, by which the arm goes");
  refuse_if(scene.gravity.isZero(0.0) && has(PhaseKind::kPlace), "place needs gravity: the weight tells what is borne");
  refuse_if(!scene.fingertips && has(PhaseKind::kClose), "close needs fingertips: rigid ones meet with any force");
  refuse_if(scene.control && scene.control->law == ControlLaw::kPaper, "need control.law: feedforward");
  refuse_if(scene.control && scene.control->drive, "needs the control law: leave out control.drive");
  for (const char* key : {"translate", "rotate", "spring"}) {
    if (v.has(key)) v.refuse(key, "moves the target by time: phases hold the object where they took it");
  }
}

void describe_goal(Visitor& v, TaskGoal& goal) {
  v.key({"position", kLength, "", "(Without it any.)", "Where the origin of the object frame should be."},
        goal.position_m);
  describe_rotation(v,
                    {"rotation", kNone, "", "(Without it any.)",
                     "The rotation that the object should have. The turn of a body of revolution about its axis does "
                     "not count."},
                    goal.rotation);
  if (v.reads() && !goal.position_m && !goal.rotation && !v.is_refused("position") && !v.is_refused("rotation"))
    v.refuse("position", "or rotation is required: without them nothing is judged");
  if (!v.is_there("within", true)) return;
  v.map({"within", kNone, "", "(Without it: 2 mm and 5 degrees.)", "How far from them it may be."}, [&] {
    v.key({"distance", kLength, "> 0", "2 mm", "From the position."}, goal.within_m);
    v.key({"angle", kAngle, "> 0", "5 deg", "From the rotation."}, goal.within_rad);
  });
}

}  // namespace

void describe_task(Visitor& v, Scene& scene) {
  TaskSettings& task = scene.task;
  v.map({"translate", kNone, "", "(Without it the target does not move.)", "A minimum-jerk move of the target."},
        task.translate, [&](Move& move) { describe_translation(v, move); });
  v.map({"rotate", kNone, "", "(Without it the target does not turn.)", "A minimum-jerk turn of the target."},
        task.rotate, [&](Move& move) { describe_turn(v, move); });
  v.map(
      {"spring", kNone, "", "(Without it no spring acts.)", "A spring that ties the object to its target."},
      task.spring, [&](Spring& spring) {
        v.key({"translation", kStiffness, "> 0", "", "Its stiffness in translation."}, spring.translation_N_per_m);
        v.key({"rotation", kRotationalStiffness, "> 0", "", "Its stiffness in rotation."}, spring.rotation_Nm_per_rad);
      });
  v.map({"push", kNone, "", "(Without it nothing pushes.)",
         "A constant force and moment on the object, in its axes at the start, which the controller does not know of."},
        task.push, [&](Push& push) { describe(v, push, scene.object.shape); });
  v.map({"arm", kNone, "", "(Without it the hand does not accelerate.)",
         "The arm that carries the hand swings along a line: the hand is the world, and the load of it acts on object "
         "and bones as a gravity that changes."},
        task.arm, [&](Arm& arm) { describe(v, arm); });
  double last_s = -1.0;
  v.list({"friction", kNone, "", "(Without it friction stays what it is.)",
          "Steps of contact.friction, in the order of time: an object that becomes wet."},
         task.friction, [&](FrictionStep& step) {
           v.key({"at", kTime, ">= 0", "", "When it changes."}, step.from_s);
           v.key({"to", kNone, "0 .. 10", "", "The coefficient from then on."}, step.friction);
           if (!(step.from_s > last_s)) v.refuse("at", "must be later than that of the step before it");
           last_s = step.from_s;
         });
  describe_phases(v, task.phases);
  if (v.has("phases")) check_phases(v, scene);
  v.key({"lost", kLength, "> 0", "(Without it: by the radius of its pulp.)",
         "A finger that slid so far has lost the object."},
        task.lost_m);
  v.map(
      {"goal", kNone, "", "(Without it where the object is at the end is not judged.)",
       "Where the object should be at the end, in the axes in which the bodies of the environment are placed, however "
       "the arm has gone; a task that misses it has failed."},
      task.goal, [&](TaskGoal& goal) { describe_goal(v, goal); });
}

}  // namespace thenar
