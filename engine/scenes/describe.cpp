// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/describe.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/scenes/object_bounds.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;
using enum Dimension;

namespace {

// Contact forces are kept for a few control periods, and a frame for each one that lies within the delay.
constexpr double kMaxSteps = 1e7, kMaxStepsAPeriod = 1e4, kMaxPeriodsLate = 100.0;
constexpr double kTimeRounding = 1e-9;  // Of a ratio of two times.

void check_time(Visitor& v, const Scene& scene) {
  if (scene.duration_s / scene.step_s > kMaxSteps) {
    v.refuse("duration", "makes more than 10 million steps of time.step");
  }
  if (!v.is_refused("step")) {
    if (scene.duration_s < scene.step_s * (1.0 - kTimeRounding)) {
      v.refuse("duration", "must not be shorter than time.step");
    }
    const double steps = scene.control_period_s / scene.step_s;
    if (steps < 1.0 - kTimeRounding) v.refuse("control_period", "must not be shorter than time.step");
    if (steps > kMaxStepsAPeriod * (1.0 + kTimeRounding)) {
      v.refuse("control_period", "must not be longer than 10000 times time.step");
    }
  }
  if (!v.is_refused("control_period") &&
      scene.control_delay_s > kMaxPeriodsLate * (1.0 + kTimeRounding) * scene.control_period_s) {
    v.refuse("control_delay", "must not be longer than 100 times time.control_period");
  }
}

// Bounds that are no law of mechanics keep a typo from asking for any amount of memory or time. A step is within the
// rates that loops may have, 100 kHz to 1 Hz. An object's surface takes 430 bytes a point; a pulp's kernel 24 bytes for
// each pair of leaves, 400 MB for 4000; a human fingertip stiffens by about 0.5 1/N.

void describe_time(Visitor& v, Scene& scene) {
  v.key({"duration", kTime, "> 0", "", "How long the scene runs: at most 10 million steps."}, scene.duration_s);
  v.key({"step",
         kTime,
         "10 us .. 1 s",
         "",
         "The period of the contact loop.",
         {"contact_Hz", "contact rate", "Hz", 200.0, 10'000.0}},
        scene.step_s);
  v.key({"control_period",
         kTime,
         "> 0",
         "",
         "The period of the control loop: from one time.step to 10000 of them.",
         {"control_Hz", "control rate", "Hz", 20.0, 2000.0}},
        scene.control_period_s);
  v.key(
      {"control_delay",
       kTime,
       ">= 0",
       "0 s",
       "With two loops: the time from a control tick's snapshot to the use of its frame, at most 100 control periods.",
       {"delay_periods", "delay of frames", "periods", 0.0, 8.0, true}},
      scene.control_delay_s);
  check_time(v, scene);
}

void describe_fingertips(Visitor& v, FingertipSettings& tips) {
  PulpMaterial& material = tips.material;
  v.key({"points", kNone, "1 .. 1000000", "", "The samples of each fingertip's surface."}, tips.points);
  v.key({"leaves", kNone, "1 .. 4000", "",
         "The control points of each fingertip, which its deformation is computed at: at most fingertips.points."},
        tips.leaves);
  if (tips.leaves > tips.points && !v.is_refused("points")) v.refuse("leaves", "must not exceed fingertips.points");
  v.key({"reduced_modulus", kPressure, "> 0", "", "The reduced modulus E* of the pulp."}, material.reduced_modulus_Pa);
  v.key({"poisson", kNone, "0 .. 0.5", "", "Poisson's ratio of the pulp."}, material.poisson);
  v.key({"relaxation", kTime, ">= 0", "",
         "The retardation time of the pulp, in which it loses all but 1/e of its deformation without load; 0 is "
         "elastic."},
        material.relaxation_s);
  v.choice({"kernel",
            kNone,
            "boussinesq | gaussian",
            "boussinesq",
            "How a force deforms the pulp around it: as in an elastic half space, or by the published influence "
            "function, which holds at one depth.",
            {"kernel", "kernel", ""}},
           material.kernel, {PulpKernel::kBoussinesq, PulpKernel::kGaussian});
  v.key({"stiffening", kPerForce, "0 .. 10 1/N", "(Without it the modulus is constant.)",
         "The share by which the modulus grows for each newton of normal load on a fingertip."},
        material.stiffening_per_N);
  v.map({"touch", kNone, "", "(Without it fingertips feel nothing but their loads.)",
         "What fingertips feel of their patches: how much of them sticks, and where the rim slips, the friction."},
        tips.touch, [&](TouchSettings& touch) {
          v.key({"delay", kTime, "0 s .. 1 s", "65 ms",
                 "From what happens at the skin to the command that answers it: people take 60 to 90 ms."},
                touch.delay_s);
          v.key({"noise", kShare, "0 % .. 100 %", "0 %",
                 "Standard deviation of what is felt of each contact's normal and tangential force."},
                touch.noise);
          v.key({"seed", kNone, "0 .. 1000000", "1", "The seed of the noise."}, touch.seed);
        });
}

void describe_contact(Visitor& v, Scene& scene) {
  ContactSettings& contact = scene.contact;
  v.key(
      {"friction", kNone, "0 .. 10", "", "Coulomb's coefficient of friction.", {"friction", "friction", "", 0.0, 2.0}},
      contact.friction);
  v.key({"band", kLength, "> 0", "", "Control points with a gap below this are candidates for contact."},
        contact.band_m);
  if (v.when(scene.fingertips.has_value())) {
    v.key({"distance_error", kLength, "0 .. 0.1 mm", "1 um",
           "How far, for speed, the distances of deformable fingertips' points may be off those of the surface that "
           "the samples stand for: 0 takes the surface itself."},
          contact.distance_error_m);
    v.key({"max_per_finger", kNone, "1 .. 1000", "(Required with deformable fingertips, refused without.)",
           "The most contacts of a finger: those of the smallest gaps are kept."},
          contact.max_per_finger);
    v.choice({"level",
              kNone,
              "leaves | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | auto",
              "leaves",
              "The level of detail of deformable fingertips: all leaves; a control point for about 2, 4, 8 and so on "
              "of them; auto: the coarsest level within contact.force_error.",
              {"level", "level of the pulps", "", 0.0, 6.0, true}},
             contact.level, {0, 1, 2, 3, 4, 5, 6, 7, 8, std::nullopt});
    const int level = contact.level.value_or(0);
    if (level > 0 && (Index{1} << level) > scene.fingertips->leaves) {
      v.refuse("level", "needs fingertips of " + std::to_string(1 << level) + " leaves or more");
    }
  } else if (v.reads()) {
    contact.max_per_finger = 1;
    if (v.has("distance_error")) v.refuse("distance_error", "counts with deformable fingertips alone");
  }
  if (v.when(!contact.level)) {
    v.key({"force_error", kShare, ">= 0", "5 %",
           "With contact.level auto: how far a fingertip's force may be off Hertz's, rms."},
          contact.force_error);
  } else if (v.has("force_error")) {
    v.refuse("force_error", "counts with contact.level: auto alone");
  }
  v.key({"tolerance",
         kNone,
         "1e-14 .. 1",
         "1e-7",
         "The natural-map residual at which a contact tick stops its sweeps.",
         {"tolerance", "solver tolerance", "", 1e-10, 0.1}},
        contact.tolerance);
  v.key({"max_sweeps",
         kNone,
         "1 .. 1000000",
         "200",
         "The most sweeps of a contact tick.",
         {"max_sweeps", "solver sweeps, at most", "", 1.0, 1000.0, true}},
        contact.max_sweeps);
}

void describe_tolerance(Visitor& v, Tolerance& tolerance) {
  v.key({"position", kLength, ">= 0", "0.1 mm", "Of the object's position, rms and at the end."}, tolerance.position_m);
  v.key({"rotation", kAngle, ">= 0", "0.1 deg", "Of the object's rotation, rms and at the end."},
        tolerance.rotation_rad);
  v.key({"force", kShare, ">= 0", "5 %", "Of the fingers' forces, rms."}, tolerance.force);
  v.key(
      {"moment", kShare, ">= 0", "10 %", "Of the fingers' torsions, rms, as a share of the most that friction allows."},
      tolerance.moment);
  v.key({"margin", kNone, "0 .. 1", "0.05", "Of the fingers' margins, rms."}, tolerance.margin);
}

/// A vector, or a direction with a magnitude.
void describe_gravity(Visitor& v, Scene& scene) {
  const KeyRow row{
      "gravity", kAcceleration, "", "[0 m/s^2, 0 m/s^2, 0 m/s^2]",
      "The acceleration of gravity in the hand frame, which is the world; as a map, in which direction, and "
      "how strong."};
  v.value_or_map(row, scene.gravity, scene.gravity_in_object_frame, [&] {
    Vector3d down = scene.gravity;
    double magnitude = scene.gravity.norm();
    describe_direction(v, {"down", kNone, "", "", "The direction in which it acts, of any length but zero."}, down);
    v.key({"magnitude", kAcceleration, ">= 0", "9.81 m/s^2", "How strong it is."}, magnitude);
    if (v.is_there("frame", scene.gravity_in_object_frame)) {
      v.choice({"frame", kNone, "hand | object", "(Without it: hand.)",
                "The frame in which down is: the hand's, or the object's at the start, so that the object is upright "
                "whichever grasp is found."},
               scene.gravity_in_object_frame, {false, true});
    }
    if (v.reads()) scene.gravity = magnitude * down;
  });
}

}  // namespace

void describe_direction(Visitor& v, const KeyRow& row, Vector3d& direction) {
  v.key(row, direction);
  if (!v.reads()) return;
  // One whose square is out of range is scaled first, which rounds.
  const double square = direction.squaredNorm();
  direction = std::isnormal(square) ? direction.normalized() : direction.stableNormalized();
  if (direction.squaredNorm() > 0.0) return;
  v.refuse(row.name, "a direction must not be zero");
  direction = Vector3d::UnitX();
}

void describe_direction(Visitor& v, const KeyRow& row, std::optional<Vector3d>& direction) {
  if (!v.is_there(row.name, direction.has_value())) return direction.reset();
  Vector3d now = direction.value_or(Vector3d::Zero());
  describe_direction(v, row, now);
  direction = now;
}

void refuse_found(Visitor& v, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    if (v.has(key)) v.refuse(key, "is what grasp finds: leave out one of them");
  }
}

void describe(Visitor& v, SceneFile& file) {
  Scene& scene = file.scene;
  const bool slides = v.is_there("hand.slides", !scene.slides.empty());
  const bool is_found = !slides && v.is_there("grasp", scene.grasp.has_value());
  const bool is_controlled = !slides && v.is_there("control", scene.control.has_value());
  v.key({"name", kNone, "", "", "The scene's name in results."}, scene.name);
  v.map({"time", kNone, "", "", "How long the scene runs, and the periods of its two loops."},
        [&] { describe_time(v, scene); });
  describe_gravity(v, scene);
  v.map({"hand", kNone, "", "", "The hand, its posture and its joints; or fingertips on slides in place of it."}, [&] {
    if (v.when(!slides)) describe_hand(v, file, is_found, is_controlled);
    if (v.when(slides)) describe_slides(v, scene);
  });
  v.map({"fingertips", kNone, "", "(Without them fingers are rigid and touch at one point each.)",
         "Deformable fingertips."},
        scene.fingertips, [&](FingertipSettings& tips) { describe_fingertips(v, tips); });
  v.map({"object", kNone, "", "", "The object that is held."},
        [&] { describe_object(v, scene.object, is_found, scene.fingertips.has_value()); });
  if (v.when(is_found)) describe_grasp(v, file, is_controlled);
  v.map({"contact", kNone, "", "", "Contacts between fingers and object."}, [&] { describe_contact(v, scene); });
  const bool is_pressed = scene.grasp && scene.grasp->press_N;
  if (v.when(is_controlled))
    v.map({"control", kNone, "", "(Without it hand.torques drive the joints, or hand.slides the fingertips.)",
           "The controller of the object's position and the grip."},
          [&] { describe_control(v, file, is_pressed); });
  for (const char* key : {"control", "grasp"}) {
    if (slides && v.has(key)) v.refuse(key, "is of a hand, and hand.slides take its place: leave out one of them");
  }
  v.map({"environment", kNone, "", "(Without it the object touches the fingers alone.)",
         "What is around the object: rigid bodies with exact surfaces. Fingers do not touch them."},
        scene.environment, [&](Environment& environment) { describe_environment(v, environment, scene); });
  if (v.reads() && scene.environment) scene.environment->place = v.location("environment");
  if (v.is_there("task", true))
    v.map({"task", kNone, "", "(Without it the target stays where the object starts.)",
           "What becomes of the object's target, and what acts on the object."},
          [&] { describe_task(v, scene); });
  v.choice({"model", kNone, "full | auto", "full",
            "What is modelled: all that the scene names, or only the parts that its tolerance needs."},
           scene.only_needed, {false, true});
  if (v.is_there("tolerance", scene.only_needed))
    v.map({"tolerance", kNone, "", "(Without it its keys have their defaults.)",
           "How far the object's path and the fingers' forces may be off the full model's."},
          [&] { describe_tolerance(v, scene.tolerance); });
}

}  // namespace thenar
