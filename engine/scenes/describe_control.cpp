// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/drive_file.h"

/// The map `control` of a scene.
namespace thenar {

using Eigen::Vector3d;
using enum Dimension;

namespace {

/// The cones of grasp forces, whose friction is a number, or felt, and how hard the fingers squeeze.
void describe_grasp_forces(Visitor& v, SceneFile& file, bool is_pressed, bool feels) {
  ControlSettings& control = *file.scene.control;
  const KeyRow friction{"friction", kNone, "0 .. 10 | felt", "",
                        "The coefficient of friction of their cones; felt: of each finger, what its fingertip feels, "
                        "with control.grasp.margin."};
  const bool is_felt = !v.word(friction, control.felt_margin ? "felt" : "").empty();
  if (v.when(!is_felt)) v.key(friction, control.grasp_friction);
  if (v.when(is_felt)) {
    double margin = control.felt_margin.value_or(0.0);
    const double now = control.grasp_friction * (1.0 + margin);
    double first = now;
    v.key({"margin", kNone, "0 .. 10", "(Required with felt friction, refused without.)",
           "By how much more the fingers press than the felt friction needs, as a share: 0.3 is what people leave."},
          margin);
    v.key({"first_friction", kNone, "0.01 .. 10", "(Required with felt friction, refused without.)",
           "The friction that is expected of a finger until it has felt some."},
          first);
    if (control.felt_margin != margin || first != now) {  // Else rounding would change it.
      control.felt_margin = margin;
      control.grasp_friction = first / (1.0 + margin);
    }
    if (!feels) v.refuse("friction", "felt needs fingertips.touch");
  } else if (!v.is_refused("friction")) {
    for (const char* key : {"margin", "first_friction"}) {
      if (v.has(key)) v.refuse(key, "counts with friction: felt alone");
    }
  }
  if (file.taken_squeeze_N && !v.has("internal_force")) {
    control.internal_force_N = *file.taken_squeeze_N;
    v.use_default("internal_force", to_text(control.internal_force_N, kForce));
  } else if (v.when(!is_pressed)) {
    v.key({"internal_force",
           kForce,
           ">= 0",
           "(Required without grasp.press, refused with it. With grasp.from: that of the grasp.)",
           "The internal force, by which the fingers squeeze.",
           {"internal_force_N", "squeeze", "N", 0.1, 20.0}},
          control.internal_force_N);
  } else if (v.has("internal_force")) {
    v.refuse("internal_force", "is what grasp.press asks for: leave out one of them");
  }
  v.choice({"cone", kNone, "pyramid | exact", "exact", "The shape of their friction cones."}, control.cone,
           {FrictionCone::kPyramid, FrictionCone::kExact});
}

void describe(Visitor& v, ReflexSettings& reflex) {
  v.key({"load_rate", kForceRate, "> 0", "2 N/s",
         "A finger whose tangential load changes faster than expected gets a pulse of grip."},
        reflex.load_rate_N_per_s);
  v.key({"pulse", kTime, "1 ms .. 2 s", "220 ms", "How long the grip rises in a pulse."}, reflex.pulse_s);
  v.key({"release", kTime, "10 ms .. 10 s", "0.5 s", "The time constant with which the grip goes back after a pulse."},
        reflex.release_s);
  v.key({"stick", kNone, "0 .. 0.95", "0.35",
         "The least share of a patch that is to stick: with less of it, the squeeze rises."},
        reflex.stick);
  v.key({"regulation", kRate, ">= 0", "5 1/s",
         "How fast it rises and falls again. Much above 1/(2 x the touch's delay) it swings."},
        reflex.regulation_per_s);
}

void describe(Visitor& v, ObjectStiffness& wanted) {
  v.key({"translation",
         kStiffness,
         ">= 0",
         "",
         "Along the object's axes.",
         {"asked_N_per_m", "stiffness along x, y, z", "N/m", 0.0, 1000.0}},
        wanted.translation_N_per_m);
  v.key({"rotation",
         kRotationalStiffness,
         ">= 0",
         "",
         "About them.",
         {"asked_Nm_per_rad", "stiffness about x, y, z", "N m/rad", 0.0, 0.5}},
        wanted.rotation_Nm_per_rad);
  v.key({"centre", kLength, "", "(Without it: its origin.)", "The point about which these are meant, object frame."},
        wanted.centre_m);
  v.key({"squeeze", kForce, "> 0", "(Without it the squeeze stays.)",
         "How far the internal force may rise above control.grasp.internal_force for it."},
        wanted.most_squeeze_N);
}

/// What muscles are beyond their forces.
void describe(Visitor& v, MuscleSettings& muscles, const Hand& hand) {
  std::optional<double> rise_s;
  if (muscles.activation) rise_s = muscles.activation->rise_s;
  v.key({"activation", kTime, "1 ms .. 1 s", "(Without it forces are there at once.)",
         "The time constant with which forces rise to what is asked for, at an activation of a third."},
        rise_s);
  if (v.when(rise_s.has_value())) {
    Activation activation = muscles.activation.value_or(Activation{});
    activation.rise_s = rise_s.value_or(0.0);
    v.key({"deactivation", kTime, "1 ms .. 1 s", "40 ms", "Likewise, with which they fall."}, activation.fall_s);
    muscles.activation = activation;
  } else if (v.has("deactivation")) {
    v.refuse("deactivation", "goes with activation: name that, too");
  }
  v.key({"stiffness", kNone, "0.1 .. 100", "(Without it lengths change no force.)",
         "gamma of the stiffness k = gamma f / L of fibres of length L under a force f: 23.4 in Cui et al. 2008."},
        muscles.short_range);
  if (v.when(muscles.short_range.has_value())) {
    v.key({"range", kShare, "0.1 % .. 100 %", "2 %",
           "The strain of the fibres, lengthened or shortened, up to which that stiffness holds. Beyond it they yield: "
           "their force no longer changes with their length."},
          muscles.short_range_strain);
  } else if (v.has("range")) {
    v.refuse("range", "is that of the stiffness: name that, too");
  }
  const auto without = std::ranges::find_if(hand.muscles, [](const Muscle& m) { return !m.fibre_m; });
  if (muscles.short_range && without != hand.muscles.end()) {
    v.refuse("stiffness", "needs the fibre_length of each muscle, and the hand does not say that of " + without->name);
  }
  v.map({"object_stiffness", kNone, "", "(Without it the least muscle forces do.)",
         "How stiff the hand is to hold the object at least: muscle forces are chosen for it. It needs stiffness."},
        muscles.object_stiffness, [&](ObjectStiffness& wanted) { describe(v, wanted); });
  if (muscles.object_stiffness && !muscles.short_range) {
    v.refuse("object_stiffness", "is made of the muscles' stiffness: name that, too");
  }
  v.key({"frozen_from", kTime, ">= 0", "(Without it they follow the law at all times.)",
         "From this time on excitations stay as they are: forces change with lengths alone."},
        muscles.frozen_from_s);
}

/// Muscles by themselves, as torques, or with what they are.
void describe_muscles(Visitor& v, const Hand& hand, std::optional<MuscleSettings>& muscles) {
  const KeyRow row{
      "muscles", kNone, " | true | false", "",
      "Whether muscles drive the joints, or torques as they are; as a map, what muscles are beyond their forces."};
  const bool are_more = muscles && *muscles != MuscleSettings{};
  const std::string word = v.word(row, are_more ? "" : muscles ? "true" : "false");
  if (word.empty()) {
    MuscleSettings now = muscles.value_or(MuscleSettings{});
    v.map(row, [&] { describe(v, now, hand); });
    muscles = now;
  } else if (word == "true") {
    muscles.emplace();
  } else {
    muscles.reset();
  }
  if (muscles && !hand.joints.empty() && hand.muscles.empty()) {
    v.refuse("muscles", "this hand has none: write false, and torques drive its joints");
  }
}

void read_drive(Visitor& v, const std::filesystem::path& drive, SceneFile& file) {
  ControlSettings& control = *file.scene.control;
  if (drive.empty() || file.scene.hand.joints.empty()) return;
  try {
    control.drive = load_drive(drive, file.scene.hand);
  } catch (const ReadError& error) {
    v.refuse("drive", error.what());
    file.is_readable = false;
  } catch (const FileError& error) {
    v.refuse("drive", error.what());
  }
  if (control.drive && control.drive->muscles && !control.muscles) {
    v.refuse("drive", "has muscle forces, which need control.muscles: true");
  }
}

}  // namespace

void describe_position_gains(Visitor& v, PidGains& gains) {
  v.key({"p", kStiffness, ">= 0", "", "Its proportional gain."}, gains.p);
  v.key({"i", kIntegralGain, ">= 0", "0 N/(m*s)", "Its integral gain."}, gains.i);
  v.key({"d", kDamping, ">= 0", "0 N*s/m", "Its derivative gain."}, gains.d);
}

void describe_rotation_gains(Visitor& v, PidGains& gains) {
  v.key({"p", kRotationalStiffness, ">= 0", "", "Its proportional gain."}, gains.p);
  v.key({"i", kRotationalIntegralGain, ">= 0", "0 N*m/(rad*s)", "Its integral gain."}, gains.i);
  v.key({"d", kRotationalDamping, ">= 0", "0 N*m*s", "Its derivative gain."}, gains.d);
}

void describe_control(Visitor& v, SceneFile& file, bool is_pressed) {
  Scene& scene = file.scene;
  if (!scene.control) scene.control.emplace();
  ControlSettings& control = *scene.control;
  const bool feels = scene.fingertips && scene.fingertips->touch;
  v.choice({"law", kNone, "feedforward | paper", "",
            "The law of joint torques: with the desired forces fed forward, or as published, which leaves a steady "
            "force error."},
           control.law, {ControlLaw::kFeedforward, ControlLaw::kPaper});
  const KeyRow gain{"gain", kRotationalStiffness, "> 0 | auto", "",
                    "The gain K of eq. (22); auto takes it from joint viscosity, control period and delay."};
  if (v.word(gain, control.gain ? "" : "auto").empty()) {
    v.key(gain, control.gain, true);
  } else {
    control.gain.reset();
  }
  v.map({"pulp", kNone, "", "", "The controller's model of a pulp."}, [&] {
    v.key({"normal", kStiffness, "> 0", "", "Its normal stiffness."}, control.pulp_normal_N_per_m);
    v.key({"tangential", kStiffness, "> 0", "", "Its tangential stiffness."}, control.pulp_tangential_N_per_m);
  });
  v.map({"grasp", kNone, "", "", "The grasp forces that the controller asks for."},
        [&] { describe_grasp_forces(v, file, is_pressed, feels); });
  v.map({"position", kNone, "", "", "The PID controller of the object's position."},
        [&] { describe_position_gains(v, control.position); });
  v.map({"rotation", kNone, "", "", "The PID controller of the object's rotation."},
        [&] { describe_rotation_gains(v, control.rotation); });
  v.key({"centre", kLength, "", "(Without it: the object's origin.)",
         "The point of the object that control.position keeps at its place, object frame: where forces do not turn it, "
         "and moments do not shift it. At the tip of a peg, walls correct its place and its tilt one by one."},
        control.centre_m);
  v.key({"posture", kRotationalStiffness, "> 0", "(Without it the posture drifts there.)",
         "A spring to the posture of the start, where the fingertips leave the joints free."},
        control.posture_Nm_per_rad);
  v.key({"feedback_delay", kTime, "0 s .. 1 s", "(Without it what is known is of now.)",
         "How old all that the controller knows is: of the object's pose, the joints and the fingers' loads."},
        control.feedback_delay_s);
  v.key({"anticipation", kNone, "", "(Without it nothing is anticipated.)",
         "Whether what the motion that is planned will need is fed forward: against the viscosity of object and "
         "joints, and for the load that the arm makes."},
        control.anticipation);
  v.map({"reflex", kNone, "", "(Without it the grip does not answer to what is felt.)",
         "How the grip answers to what fingertips feel. It needs fingertips.touch."},
        control.reflex, [&](ReflexSettings& reflex) { describe(v, reflex); });
  if (control.reflex && !feels) v.refuse("reflex", "needs fingertips.touch");
  describe_muscles(v, scene.hand, control.muscles);
  std::filesystem::path drive;
  if (control.drive) drive = std::filesystem::absolute(control.drive->file);
  v.key({"drive", kNone, "", "(Without it the law drives them.)",
         "A table of joint torques or muscle forces by time that drive the joints instead: a CSV file with time_s and "
         "a column JOINT_Nm for each joint, or MUSCLE_N for each muscle, as signals.csv has them."},
        drive);
  if (v.reads()) read_drive(v, drive, file);
}

}  // namespace thenar
