// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/model_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"
#include "tests/support/three_fingers.h"

namespace thenar::model_parts_test {
namespace {

using Overrides = std::vector<std::string>;

const std::string kSoft = "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}";
const std::string kStiffening = "fingertips.stiffening=0.5 1/N";
const std::string kTouch = "fingertips.touch={delay: 10 ms}", kLate = "control.feedback_delay=10 ms";
const std::string kFelt = "control.grasp={friction: felt, margin: 0.3, first_friction: 0.4, internal_force: 2 N}";
const std::string kExpected = "control.grasp={friction: 0.4, internal_force: 2 N}";

/// The box grasp on few samples, from touch to a moving box.
Scene grasp(Overrides overrides = {}, const std::string& duration = "0.6 s") {
  overrides.insert(overrides.end(), {"object.points=2000", "time.duration=" + duration});
  return scene_of("box_grasp", overrides);
}

/// The box grasp in a file that does not name fingertips.
Scene rigid_grasp() {
  std::ifstream file(config_file("box_grasp"));
  std::string text;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("fingertips:")) text += line + "\n";
  }
  const std::filesystem::path written = scratch() / "rigid.yaml";
  write_file(written, text);
  return load_scene(written, {"hand.model=" + config_file("hand").string(), "object.points=2000", "time.duration=0.1 s",
                              "contact={friction: 0.8, band: 0.3 mm, tolerance: 1e-7, max_sweeps: 200}",
                              "control.pulp={normal: 50 N/mm, tangential: 33.3 N/mm}"});
}

void expect_same_run(const Model& one, const Model& other) {
  const PathRun a = run_path(one), b = run_path(other);
  ASSERT_EQ(a.path.X_WO.size(), b.path.X_WO.size());
  ASSERT_EQ(a.path.X_WO.size(), 100U);
  for (std::size_t i = 0; i < a.path.X_WO.size(); ++i) {
    ASSERT_EQ(a.path.X_WO[i].matrix(), b.path.X_WO[i].matrix()) << i;
    ASSERT_EQ(a.path.force_N[i], b.path.force_N[i]) << i;
  }
}

TEST(ModelParts, LeavingOutIsTheSceneThatNeverNamedThePart) {
  struct Pair {
    Part part;
    Overrides with, without;
  };
  const std::string elastic = "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 0 ms}";
  for (const auto& [part, with, without] :
       std::vector<Pair>{{Part::kSoftObject, {kSoft}, {}},
                         {Part::kDetail, {}, {"contact.level=1"}},
                         {Part::kMuscles, {}, {"control.muscles=false"}},
                         {Part::kObjectMemory, {kSoft}, {elastic}},
                         {Part::kFingertipMemory, {}, {"fingertips.relaxation=0 ms"}},
                         {Part::kStiffening, {kStiffening}, {}},
                         {Part::kTouch, {kTouch, kFelt, "control.reflex={}"}, {kExpected}},
                         {Part::kReflex, {kTouch, kFelt, "control.reflex={}"}, {kTouch, kFelt}},
                         {Part::kAnticipation, {"control.anticipation=true"}, {}},
                         {Part::kFeedbackDelay, {kLate}, {}},
                         {Part::kMuscleStiffness, {"control.muscles={stiffness: 23.4}"}, {}},
                         {Part::kActivation, {"control.muscles={activation: 10 ms}"}, {}}}) {
    SCOPED_TRACE(to_string(part));
    const Scene scene = grasp(with, "0.1 s");
    ASSERT_TRUE(has(scene, part));
    expect_same_run(build_model(leave_out(scene, part)), build_model(grasp(without, "0.1 s")));
  }
  for (const Overrides& named : {Overrides{kSoft}, Overrides{kTouch, "control.reflex={}"}}) {
    expect_same_run(build_model(leave_out(grasp(named, "0.1 s"), Part::kFingertips)), build_model(rigid_grasp()));
  }
}

// A box that becomes wet is lost without touch. Where cones have the friction that is felt, they ask for the grip that
// holds it by themselves, and the reflex adds little.
TEST(ModelParts, ABoxThatBecomesWetNeedsTouch) {
  const Model model = build_model(scene_of("box_wet", {kCoarseBox, "contact.max_per_finger=20", "time.duration=0.7 s",
                                                       "task.friction=[{at: 0.4 s, to: 0.15}]"}));
  const PathRun full = run_path(model);
  ASSERT_EQ(full.verdict.outcome, Outcome::kSlipping) << "it slid just now: " << full.verdict.reason;
  const std::vector<PartEffect> effects = ablate(model, full);
  const auto without = [&](Part part) -> const PartEffect& {
    return *std::ranges::find(effects, part, &PartEffect::part);
  };
  EXPECT_EQ(without(Part::kTouch).verdict.outcome, Outcome::kLost);
  EXPECT_FALSE(without(Part::kTouch).within);
  EXPECT_TRUE(without(Part::kReflex).within) << in_words(without(Part::kReflex));
  EXPECT_GT(without(Part::kReflex).error.force, 0.0);
  EXPECT_EQ(std::ranges::count(effects, Part::kFeedbackDelay, &PartEffect::part), 1);
  EXPECT_EQ(std::ranges::count(effects, Part::kAnticipation, &PartEffect::part), 0);
}

// Without their shapes pulps are spheres that touch a plane across their normal at the same place; what is a sphere
// stays.
TEST(ModelParts, PulpsWithoutTheirShapeTouchWhereTheyDid) {
  Scene scene = grasp({}, "0.1 s");
  EXPECT_FALSE(has(scene, Part::kPulpShape));
  Fingertip& tip = scene.hand.fingertips[1];
  tip.shape = PulpShape{PulpShape::Form::kEllipsoid, Eigen::Matrix3d::Identity(), {12e-3, 7e-3, 8e-3}};
  tip.radius_m = 7e-3;
  ASSERT_TRUE(has(scene, Part::kPulpShape));
  const Scene spheres = leave_out(scene, Part::kPulpShape);
  EXPECT_FALSE(has(spheres, Part::kPulpShape));
  const Fingertip& round = spheres.hand.fingertips[1];
  const Eigen::Vector3d touched_m = tip.centre_m + support_m(*tip.shape, tip.normal);
  EXPECT_LE((round.centre_m + round.radius_m * tip.normal - touched_m).norm(), 1e-15);
  EXPECT_EQ(spheres.hand.fingertips[0].radius_m, scene.hand.fingertips[0].radius_m);
}

TEST(ModelParts, WhatASceneDoesNotNameCannotBeLeftOut) {
  const Scene minimal = scene_of("minimal");
  for (const Part part : kParts) EXPECT_FALSE(has(minimal, part)) << to_string(part);
  // Its own tolerance has chosen this level.
  EXPECT_FALSE(has(grasp({"contact.level=auto"}), Part::kDetail));
  EXPECT_FALSE(has(grasp({"contact.level=8"}), Part::kDetail));
}

TEST(ModelParts, DeviationIsOfTheTicksThatCount) {
  GraspPath path, reference;
  for (int i = 0; i < 10; ++i) {
    reference.X_WO.push_back(Eigen::Isometry3d::Identity());
    reference.force_N.push_back(FingerForces::Constant(3, 3, 2.0));
    for (GraspPath* of : {&path, &reference}) of->environment_N.emplace_back(Eigen::Vector3d::Zero());
    // Far off at first; then by 3 mm along x, and in the last tick by 4 mm along y.
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = i < 5 ? Eigen::Vector3d(1.0, 0.0, 0.0) : Eigen::Vector3d(3e-3, 0.0, 0.0);
    if (i == 9) X.translation() = Eigen::Vector3d(0.0, 4e-3, 0.0);
    X.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
    path.X_WO.push_back(X);
    path.force_N.push_back(FingerForces::Constant(3, 3, i < 5 ? 0.0 : 2.2));
    // Torsions are off by 2 of 10 and 1 of 5 mN m, margins of two fingers by 0.1 and 0.2; the third carries nothing.
    auto& patches = path.patch.emplace_back(3);
    auto& full = reference.patch.emplace_back(3);
    for (auto* of : {&patches, &full}) {
      (*of)[0] = {.moment_Nm = 3e-3, .moment_limit_Nm = 10e-3, .margin = 0.5};
      (*of)[1] = {.moment_Nm = -2e-3, .moment_limit_Nm = 5e-3, .margin = 0.7};
    }
    patches[0].moment_Nm += i < 5 ? 1.0 : 2e-3;
    patches[1].moment_Nm -= 1e-3;
    patches[1].moment_limit_Nm *= 2.0;
    patches[0].margin -= 0.1;
    patches[1].margin += 0.2;
  }
  const PathDeviation off = deviation(path, reference, 5);
  EXPECT_NEAR(off.position_rms_m, std::sqrt((4 * 9.0 + 16.0) / 5.0) * 1e-3, 1e-15);
  EXPECT_NEAR(off.position_final_m, 4e-3, 1e-15);
  EXPECT_NEAR(off.rotation_rms_rad, 0.1, 1e-12);
  EXPECT_NEAR(off.rotation_final_rad, 0.1, 1e-12);
  EXPECT_NEAR(off.force, 0.1, 1e-12);
  EXPECT_NEAR(off.moment, std::hypot(2.0, 1.0) / std::hypot(10.0, 5.0), 1e-12);
  EXPECT_NEAR(off.margin, std::hypot(0.1, 0.2) / std::sqrt(2.0), 1e-12);

  path.patch[9][2].margin = 0.3;  // A finger that only one of the paths loads, in one tick of five.
  EXPECT_NEAR(deviation(path, reference, 5).margin, std::sqrt((5 * 0.05 + 1.0) / 11.0), 1e-12);
}

TEST(ModelParts, AModelIsNotOffItself) {
  const Model model = build_model(grasp({}, "0.4 s"));
  const PathRun one = run_path(model), other = run_path(model);
  const PathDeviation off = deviation(one.path, other.path, 0);
  EXPECT_EQ(off.position_rms_m, 0.0);
  EXPECT_LT(off.rotation_rms_rad, 1e-15) << "what quaternions round";
  EXPECT_EQ(off.force, 0.0);
  EXPECT_EQ(off.moment, 0.0);
  EXPECT_EQ(off.margin, 0.0);
  // There is something to be off from: every patch has a limit and carries some of it.
  for (const PatchReport& patch : one.path.patch.back()) {
    EXPECT_GT(patch.moment_limit_Nm, 0.0);
    EXPECT_GT(std::abs(patch.moment_Nm), 0.01 * patch.moment_limit_Nm);
  }
}

// Muscles give the torques that are asked for, to rounding; all else changes the motion.
TEST(ModelParts, WithoutToleranceOnlyWhatChangesNothingIsLeftOut) {
  const Model model = build_model(grasp(
      {"model=auto", "tolerance={position: 0 mm, rotation: 0 deg, force: 0 %, moment: 0 %, margin: 0}", kStiffening}));
  const Scene scene = as_needed(model).scene;
  EXPECT_FALSE(scene.control->muscles);
  ASSERT_TRUE(scene.fingertips);
  EXPECT_EQ(scene.contact.level, 0);
  EXPECT_EQ(scene.fingertips->material.relaxation_s, model.scene.fingertips->material.relaxation_s);
  EXPECT_EQ(scene.fingertips->material.stiffening_per_N, 0.5);
}

/// What model: auto leaves of a scene, held against the full model by measures of its own.
Scene expect_within(const Scene& named, const Tolerance& tolerance) {
  const Model full = build_model(named), model = as_needed(full);
  const PathRun reference = run_path(full), run = run_path(model);
  EXPECT_EQ(run.verdict.outcome, Outcome::kHeld) << run.verdict.reason;
  EXPECT_EQ(run.path.X_WO.size(), reference.path.X_WO.size());
  double position = 0.0, angle = 0.0, force = 0.0, whole = 0.0, moment = 0.0, limit = 0.0, margin = 0.0, ticks = 0.0;
  for (std::size_t i = 300; i < run.path.X_WO.size(); ++i, ++ticks) {
    const Eigen::Isometry3d &X = run.path.X_WO[i], &X_ref = reference.path.X_WO[i];
    position += (X.translation() - X_ref.translation()).squaredNorm();
    angle += std::pow(Eigen::AngleAxisd(X_ref.linear().transpose() * X.linear()).angle(), 2);
    force += (run.path.force_N[i] - reference.path.force_N[i]).squaredNorm();
    whole += reference.path.force_N[i].squaredNorm();
    for (int k = 0; k < kFingers; ++k) {
      const PatchReport &patch = run.path.patch[i][k], &patch_ref = reference.path.patch[i][k];
      moment += std::pow(patch.moment_Nm - patch_ref.moment_Nm, 2);
      limit += std::pow(patch_ref.moment_limit_Nm, 2);
      margin += std::pow(patch.margin - patch_ref.margin, 2) / kFingers;  // All three are loaded, or this is NaN.
    }
  }
  EXPECT_LE(std::sqrt(position / ticks), tolerance.position_m);
  EXPECT_LE(std::sqrt(angle / ticks), tolerance.rotation_rad);
  EXPECT_LE(std::sqrt(force / whole), tolerance.force);
  EXPECT_LE(std::sqrt(moment / limit), tolerance.moment);
  EXPECT_LE(std::sqrt(margin / ticks), tolerance.margin);
  return model.scene;
}

TEST(ModelParts, AutoStaysWithinTheTolerance) {
  const Scene loose = expect_within(grasp({"model=auto"}), Tolerance{});
  EXPECT_FALSE(loose.control->muscles);
  EXPECT_GT(loose.contact.level, 0);
  EXPECT_FALSE(loose.left_out.empty());

  const Scene tight = expect_within(grasp({"model=auto", "tolerance={position: 2 um, rotation: 0.1 deg, force: 1 %}"}),
                                    {.position_m = 2e-6, .rotation_rad = 0.1, .force = 0.01});
  EXPECT_LT(tight.contact.level, loose.contact.level);
}

// Coarse pulps keep the forces, which the controller sees, but not the torsion of a patch and how much it can carry.
// Both come with the move, which turns the fingers on the box.
TEST(ModelParts, AutoKeepsWhatMomentsAndMarginsNeed) {
  const auto level = [](const std::string& seen) {
    const std::string tolerance = "tolerance={position: 0.1 mm, rotation: 0.2 deg, force: 5 %, " + seen + "}";
    const Overrides moves{"model=auto", tolerance, "task.translate.from=0.3 s", "task.translate.over=0.4 s"};
    return as_needed(build_model(grasp(moves, "0.8 s"))).scene.contact.level;
  };
  const auto forces_alone = level("moment: 1000 %, margin: 1");
  EXPECT_LT(level("moment: 10 %, margin: 1"), forces_alone);
  EXPECT_LT(level("moment: 1000 %, margin: 0.05"), forces_alone);
}

TEST(ModelParts, AutoKeepsASoftObjectThatMatters) {
  const Scene loose = expect_within(grasp({"model=auto", kSoft}, "0.4 s"), Tolerance{});
  EXPECT_FALSE(loose.object.compliance);
  const Scene tight =
      expect_within(grasp({"model=auto", kSoft, "tolerance={position: 1 um, rotation: 0.001 deg, force: 0.1 %}"}),
                    {.position_m = 1e-6, .rotation_rad = 1e-3, .force = 1e-3});
  EXPECT_TRUE(tight.object.compliance);
}

TEST(ModelParts, AutoGivesTheSameBits) {
  const Model full = build_model(grasp({"model=auto"}, "0.1 s"));
  const Model one = as_needed(full), other = as_needed(full);
  EXPECT_EQ(one.scene.left_out, other.scene.left_out);
  expect_same_run(one, other);
}

// A table that the box never reaches is left out, and the reason is told; one that is 10 um in it lifts it by so much,
// which is more than half of that.
TEST(ModelParts, AutoKeepsAnEnvironmentThatTouches) {
  const auto kept = [](double z_mm) {
    Scene scene = grasp({"model=auto", "tolerance={position: 5 um, rotation: 1 deg, force: 20 %}"}, "0.4 s");
    EnvironmentBody table{"table", HalfSpace{}, Eigen::Isometry3d::Identity(), 0.3, {}};
    // Against gravity, which pulls along no axis of the hand.
    const Eigen::Vector3d up = -scene.gravity.normalized();
    table.X_WE.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
    const Eigen::Vector3d half_m = 0.5 * std::get<BoxShape>(scene.object.shape).size_m;
    const double lowest_m = (scene.object.X_WO.linear().transpose() * up).cwiseAbs().dot(half_m);
    table.X_WE.translation() = scene.object.X_WO.translation() - (lowest_m - 1e-3 * z_mm) * up;
    scene.environment = Environment{{table}, 1e-5};
    return as_needed(build_model(scene)).scene;
  };
  const Scene far = kept(-30.0), near = kept(0.01);
  EXPECT_FALSE(far.environment);
  EXPECT_EQ(far.left_out.back(), "left out: environment (environment): nothing of it ever touches the object");
  EXPECT_TRUE(near.environment);
  EXPECT_TRUE(near.left_out.back().starts_with("not left out: environment (environment): off by "))
      << near.left_out.back();
}

TEST(ModelParts, ASceneThatFailsIsLeftAsItIs) {
  const Model model = as_needed(build_model(grasp({"model=auto", "contact.friction=0.1"})));
  ASSERT_EQ(model.scene.left_out.size(), 1U);
  EXPECT_TRUE(model.scene.left_out[0].starts_with("nothing left out, for the scene fails: "))
      << model.scene.left_out[0];
  EXPECT_TRUE(model.scene.control->muscles);
}

TEST(ModelParts, AFullModelIsNotTried) { EXPECT_TRUE(as_needed(build_model(grasp())).scene.left_out.empty()); }

TEST(ModelParts, ScenesSayWhatTheyTolerate) {
  EXPECT_FALSE(grasp().only_needed);
  EXPECT_FALSE(grasp({"model=full"}).only_needed);
  const Scene scene = grasp({"model=auto", "tolerance={position: 1 mm, force: 2 %, margin: 0.1}"});
  EXPECT_TRUE(scene.only_needed);
  EXPECT_EQ(scene.tolerance.position_m, 1e-3);
  EXPECT_EQ(scene.tolerance.rotation_rad, Tolerance{}.rotation_rad);
  EXPECT_EQ(scene.tolerance.force, 0.02);
  EXPECT_EQ(scene.tolerance.moment, Tolerance{}.moment);
  EXPECT_EQ(scene.tolerance.margin, 0.1);
  const auto lists = [](const Scene& s) {
    return std::ranges::any_of(s.defaults_used, [](const std::string& d) { return d.starts_with("tolerance"); });
  };
  EXPECT_TRUE(lists(scene)) << "the rotation";
  EXPECT_TRUE(lists(grasp({"model=auto"})));
  EXPECT_FALSE(lists(grasp()));
  EXPECT_THROW(grasp({"model=some"}), ConfigError);
  EXPECT_THROW(grasp({"tolerance={position: -1 mm}"}), ConfigError);
  EXPECT_THROW(grasp({"tolerance={position: 1 deg}"}), ConfigError);
  EXPECT_THROW(grasp({"tolerance={moment: 1 mm}"}), ConfigError);
  EXPECT_THROW(grasp({"tolerance={margin: 5 %}"}), ConfigError);
  EXPECT_THROW(grasp({"tolerance={speed: 1 mm}"}), ConfigError);
  // The default that is listed is what a file may say.
  const Scene listed = grasp({"model=auto", "tolerance=" + in_words(Tolerance{})});
  EXPECT_EQ(in_words(listed.tolerance), in_words(Tolerance{}));
}

}  // namespace
}  // namespace thenar::model_parts_test
