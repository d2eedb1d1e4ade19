// SPDX-License-Identifier: Apache-2.0
#include "engine/results/warnings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/pulps/pulp_levels.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "tests/support/scenes.h"

namespace thenar::warnings_test {
namespace {

Recording run(const Model& model) {
  State state(model);
  return run_scene(model, state);
}

bool names(const std::vector<std::string>& all, const std::string& what) {
  return std::any_of(all.begin(), all.end(), [&](const auto& w) { return w.find(what) != std::string::npos; });
}

Scene short_grasp(std::vector<std::string> changes) {
  changes.insert(changes.end(), {kCoarseBox, "time.duration=0.3 s"});
  return scene_of("box_grasp", changes);
}

// Results say so where a list is too short, and check says it before, with numbers that serve.
TEST(Warnings, TellOfListsThatAreTooShort) {
  const Model few = build_model(short_grasp({"contact.max_per_finger=5"}));
  const Recording recording = run(few);
  const std::vector<std::string> all = warnings(few, recording);
  for (const Fingertip& tip : few.scene.hand.fingertips) EXPECT_TRUE(names(all, tip.finger)) << tip.finger;
  EXPECT_TRUE(names(all, "contact.max_per_finger: 5"));
  EXPECT_EQ(summarize(few, recording).at("warnings").get<std::vector<std::string>>(), all);
  EXPECT_GT(summarize(few, recording).at("contacts").at("max_penetration_um"), 1000.0);

  ASSERT_EQ(warnings(few).size(), 1u);
  EXPECT_TRUE(names(warnings(few), "contact.max_per_finger: 5 is too few"));
  const LevelEstimate estimate = estimate_level(few.scene, few.pulps, 0);
  EXPECT_GT(estimate.missing, 0.1);
  const std::string served = "contact.max_per_finger=" + std::to_string(estimate.needed);
  EXPECT_TRUE(warnings(build_model(short_grasp({served}))).empty());
  const Scene automatic = short_grasp({"contact.max_per_finger=5", "contact.level=auto"});
  EXPECT_LT(estimate_level(automatic, build_model(automatic).pulps, 0).force_error, 0.5 * estimate.force_error);
}

// Pyramids reach sqrt(2) mu_c at their corners. What check says, a run says, too.
TEST(Warnings, TellOfFrictionThatIsNotThere) {
  for (const auto& [cone, least] : {std::pair{"exact", 0.55}, std::pair{"pyramid", 0.55 * std::sqrt(2.0)}}) {
    for (const bool enough : {false, true}) {
      SCOPED_TRACE(testing::Message() << cone << (enough ? ", enough" : ", too little"));
      const Model model = build_model(
          scene_of("box_grasp", {kCoarseBox, "time.duration=10 ms", std::string("control.grasp.cone=") + cone,
                                 "contact.friction=" + std::to_string(least + (enough ? 0.001 : -0.001))}));
      EXPECT_EQ(names(warnings(model), "control.grasp.friction is 0.55"), !enough);
      EXPECT_EQ(names(warnings(model, run(model)), "control.grasp.friction is 0.55"), !enough);
    }
  }
}

// The published 15, 30 and 60 contacts serve 80, 160 and 320 control points: nothing passes into the box.
// Before a run, and only where a controller needs all fingers.
TEST(Warnings, TellOfFingersThatReachNothing) {
  EXPECT_TRUE(warnings(build_model(scene_of("box_grasp", {kCoarseBox}))).empty());
  const Model away = build_model(scene_of("box_grasp", {kCoarseBox, "object.position=[249.4 mm, 46.27 mm, 26.5 mm]"}));
  ASSERT_EQ(warnings(away).size(), 1U);
  const std::string warning = warnings(away).front();
  for (const char* finger : {"thumb", "index", "major"}) {
    EXPECT_NE(warning.find(std::string("the ") + finger + " is "), std::string::npos) << warning;
  }
  EXPECT_NE(warning.find("mm away from the object at the start"), std::string::npos) << warning;
}

TEST(Warnings, AreNoneForThePublishedSizes) {
  for (const int most : {5, 10, 20}) {
    SCOPED_TRACE(most);
    const Model model = build_model(short_grasp(
        {"contact.max_per_finger=" + std::to_string(most), "fingertips.leaves=" + std::to_string(12 * most)}));
    const Recording recording = run(model);
    EXPECT_TRUE(warnings(model, recording).empty()) << warnings(model, recording).front();
    EXPECT_LT(summarize(model, recording).at("contacts").at("max_penetration_um"), 10.0);
  }
}

// sqrt(R d), Hertz; a soft object of the pulp's own material takes half of the displacement.
TEST(Warnings, TellOfPulpsThatAreNoHalfSpace) {
  const Model model = build_model(short_grasp({}));
  const Pulp& pulp = model.pulps[0];
  for (const double depth_m : {0.5e-3, 2e-3}) {
    const double force_N = hertz_force_N(pulp, depth_m);
    EXPECT_NEAR(hertz_radius_m(pulp, force_N), std::sqrt(pulp.radius_m * depth_m), 1e-9);
    EXPECT_NEAR(hertz_radius_m(pulp, force_N, pulp.material), std::cbrt(2.0) * std::sqrt(pulp.radius_m * depth_m),
                1e-9);
  }
  for (const double share : {0.99, 1.01}) {
    Warnings gathered(model);
    TickRecord tick(model.scene.hand);
    tick.time_s = 0.125;
    const double radius_m = share * kHalfSpaceShare * pulp.radius_m;
    tick.force[0].normal_N = hertz_force_N(pulp, radius_m * radius_m / pulp.radius_m);
    gathered.add(tick);
    EXPECT_EQ(gathered.sentences().size(), share > 1.0 ? 1u : 0u);
    EXPECT_EQ(names(gathered.sentences(), "thumb's patch"), share > 1.0);
  }
  EXPECT_TRUE(warnings(build_model(short_grasp({}))).empty());
  EXPECT_TRUE(names(
      warnings(build_model(short_grasp({"control.grasp.internal_force=6 N", "contact.max_per_finger=60"}))), "a / R"));
}

// On a soft object with room for all that touch, contact gives the bodies next to no energy. Where a control point gets
// its place only when it is deep in the object, it does, and the results say why.
TEST(Warnings, TellWhereSoftObjectsInjectEnergy) {
  const std::string soft = "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}";
  for (const int most : {5, 60}) {
    SCOPED_TRACE(most);
    const Model model = build_model(short_grasp({soft, "contact.max_per_finger=" + std::to_string(most)}));
    const Recording recording = run(model);
    double injected_J = 0.0, dissipated_J = 0.0;
    for (const TickRecord& tick : recording.ticks) {
      injected_J += tick.contact.ledger.injected_J;
      dissipated_J += tick.contact.ledger.dissipated_J;
    }
    EXPECT_EQ(injected_J > 0.05 * dissipated_J, most == 5);
    EXPECT_EQ(names(warnings(model, recording), "thumb's list"), most == 5);
  }
}

// A ledger that does not close tells of a motion that is none, also where nothing is infinite.
TEST(Warnings, TellOfEnergyThatIsMissing) {
  const Model model = build_model(short_grasp({}));
  for (const auto& [missing, told] : {std::pair{1e-4, ""},
                                      {5e-3, "the energy balance does not close"},
                                      {1e300, "the energy balance does not close"},
                                      {INFINITY, "are not finite"}}) {
    Warnings all(model);
    TickRecord tick(model.scene.hand);
    tick.contact.ledger.drive_J = 1.0;
    tick.contact.ledger.viscous_J = 1.0 - missing;
    all.add(tick);
    EXPECT_EQ(names(all.sentences(), *told == '\0' ? "energ" : told), *told != '\0') << missing;
  }
}

}  // namespace
}  // namespace thenar::warnings_test
