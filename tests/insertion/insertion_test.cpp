// SPDX-License-Identifier: Apache-2.0
#include "engine/insertion/insertion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/insertion/insertion_report.h"
#include "engine/models/build_model.h"
#include "engine/results/summary.h"
#include "engine/scenes/config.h"
#include "tests/support/scenes.h"

namespace thenar::peg_study_test {
namespace {

constexpr PegShape kPeg{10e-3, 10.1e-3, 1e-3, 0.2};

/// The hand goes straight down, aside and tilted by so much.
std::vector<PegPose> straight_down(double aside_m, double tilt_rad) {
  std::vector<PegPose> wanted;
  for (int i = 0; i <= 2000; ++i) wanted.push_back({aside_m, 1e-3 - 1e-5 * i, tilt_rad});
  return wanted;
}

// A spring that does not turn: the wall moves the peg aside by u, so that the hand pushes with K u across. On the 45
// degrees of the chamfer friction turns that into K u (1 + mu) / (1 - mu) along, on one point of the wall into mu K u.
TEST(PegTheory, AStiffTiltHasTheForcesOfAnInclinedPlane) {
  constexpr double kTilt = 1e-5, kAside_m = 0.5e-3, kStiffness = 300.0;  // So small a tilt makes one point of a line.
  int on_chamfer = 0, at_one_point = 0;
  for (const PegForce& force : peg_theory(kPeg, {kStiffness, 1e6, 0.0}, straight_down(kAside_m, kTilt))) {
    if (force.points != 1) continue;
    (force.on_chamfer ? on_chamfer : at_one_point) += 1;
    // The corner of the chamfer goes across as far as the peg's end goes down.
    const double play_m = kPeg.hole_radius_m - kPeg.radius_m;
    const double room_m = force.on_chamfer ? play_m + kPeg.chamfer_m - force.depth_m : play_m;
    const double aside_N = kStiffness * (kAside_m - room_m), mu = kPeg.friction;
    const double slope = force.on_chamfer ? (1.0 + mu) / (1.0 - mu) : mu;
    // The tilt moves the end by itself times r or the depth, 20 mm at most, and turns the friction.
    const double tilted_N = kStiffness * kTilt * 20e-3 + 1e-4 * std::abs(aside_N);
    EXPECT_NEAR(force.push_N, slope * aside_N, slope * tilted_N);
    EXPECT_NEAR(force.aside_N, aside_N, tilted_N);
  }
  EXPECT_GT(on_chamfer, 10);
  EXPECT_GT(at_one_point, 500);
}

// theta l = c D is where two points begin, and the lines of the jamming diagram are where these two slide: both by
// geometry alone, whatever the springs are.
TEST(PegTheory, TwoPointsBeginAndSlideWhereWhitneySays) {
  constexpr double kTilt = 0.02;
  PegScene peg;
  peg.shape = kPeg;
  bool began = false;
  for (const PegForce& force : peg_theory(kPeg, {300.0, 2.0, 5e-3}, straight_down(0.3e-3, kTilt))) {
    if (force.points != 2) continue;
    const double l_m = force.depth_m - kPeg.chamfer_m;
    // Of a rectangle to second order; steps are of 10 um.
    EXPECT_NEAR(l_m * force.tilt_rad, kPeg.clearance() * 2.0 * kPeg.hole_radius_m, 1e-3 * l_m * force.tilt_rad);
    if (!began) {
      EXPECT_GT(l_m, 0.95 * kPeg.two_point_m(kTilt));
    }
    began = true;
    PegTick tick;
    tick.depth_m = force.depth_m;
    tick.push_N = force.push_N;
    tick.aside_N = force.aside_N;
    tick.moment_Nm = force.moment_Nm;
    const auto at = jamming_point(peg, tick);
    ASSERT_TRUE(at);
    EXPECT_NEAR(at->margin, 0.0, 2.0 * force.tilt_rad * (kPeg.friction + 1.0 / kPeg.friction) * kPeg.friction);
  }
  EXPECT_TRUE(began);
}

// With mu = 0 nothing holds a peg against its way in.
TEST(PegTheory, WithoutFrictionOnePointTakesNoPush) {
  PegShape smooth = kPeg;
  smooth.friction = 0.0;
  int at_one_point = 0;
  for (const PegForce& force : peg_theory(smooth, {300.0, 1e6, 0.0}, straight_down(0.5e-3, 1e-5))) {
    if (force.points != 1 || force.on_chamfer) continue;
    ++at_one_point;
    EXPECT_NEAR(force.push_N, 0.0, 1e-4 * force.aside_N);
  }
  EXPECT_GT(at_one_point, 500);
}

InsertionStudy study_of(const std::string& name, const std::vector<std::string>& changes = {}) {
  Scene scene = scene_of(name, changes);
  const PegScene peg = peg_scene(scene, name);
  return study_insertion(build_model(std::move(scene)), peg);
}

const std::vector<std::string> kCoarse = {"object.points=9000"};

TEST(InsertionStudy, TellsHowAPegTouches) {
  const InsertionStudy study = study_of("peg", kCoarse);
  EXPECT_EQ(study.end, PegEnd::kIn);
  EXPECT_NEAR(study.peg.tilt_rad, std::numbers::pi / 180.0, 1e-6);
  EXPECT_NEAR(study.peg.aside_m, 0.5e-3, 1e-6);
  ASSERT_GE(study.phases.size(), 3U);
  EXPECT_EQ(study.phases[0].touch, PegTouch::kFree);
  EXPECT_EQ(study.phases[1].touch, PegTouch::kChamfer);
  EXPECT_EQ(study.phases[2].touch, PegTouch::kOnePoint);
  std::size_t next = 0;
  for (const PegPhase& phase : study.phases) {
    EXPECT_EQ(phase.begin, next);
    next = phase.end;
  }
  EXPECT_EQ(next, study.ticks.size());
  for (std::size_t i = study.phases[2].begin; i < study.phases[2].end; ++i) {
    const PegTick& tick = study.ticks[i];
    if (!tick.comes() || tick.touch != PegTouch::kOnePoint || tick.depth_m < 1e-3) continue;  // The chamfer ends there.
    // One point that slides is a corner of the diagram: F_x / F_z = 1 / mu, but for the tilt of the friction.
    const auto at = jamming_point(study.peg, tick);
    ASSERT_TRUE(at);
    EXPECT_NEAR(0.2 * at->across, 1.0, 1.2 * std::abs(tick.tilt_rad) * (0.2 + 1.0 / 0.2));
    // The plane of the tilt has all of it, but for what the grip turns: a tenth.
    EXPECT_LT(std::abs(tick.across_N), 0.1 * std::abs(tick.aside_N));
  }
}

TEST(InsertionStudy, TellsWhereAPegWedges) {
  const InsertionStudy study = study_of("peg_wedged", kCoarse);
  EXPECT_EQ(study.end, PegEnd::kWedged);
  ASSERT_TRUE(study.wedged && study.two_points);
  EXPECT_THAT(end_in_words(study),
              testing::MatchesRegex("wedged at [0-9.]+ mm: two contacts within the friction cones"));
  // theta l = c D with the tilt at that moment, to the 10 um that it goes in a tick.
  const PegTick& tick = study.ticks[*study.two_points];
  EXPECT_NEAR(tick.depth_m - 1e-3, study.peg.shape.two_point_m(tick.tilt_rad), 2e-5);
  EXPECT_LT(study.ticks[*study.wedged].depth_m - 1e-3, 0.6 * 20e-3) << "friction cannot wedge below mu d";
  const auto json = insertion_json(scene_of("peg_wedged"), study);
  EXPECT_EQ(json.at("end"), "wedged");
  EXPECT_TRUE(json.at("theory").at("can_wedge"));
  EXPECT_NEAR(json.at("theory").at("wedging_tilt_deg").get<double>(), 0.9455, 1e-3);  // 0.2 / 20.2 / 0.6
  // It wedges at the depth that the summary of a run has, but for the object's turns, which that leaves out.
  const Model model = build_model(scene_of("peg_wedged", kCoarse));
  State state(model);
  const auto summary = summarize(model, run_scene(model, state)).at("environment");
  EXPECT_DOUBLE_EQ(summary.at("first_wedged_s").get<double>(), study.ticks[*study.wedged].time_s);
  EXPECT_NEAR(summary.at("wedged_depth_mm").get<double>(), 1e3 * study.ticks[*study.wedged].depth_m, 0.1);
}

TEST(InsertionStudy, RefusesWhatHasNoPegOrNoHole) {
  const auto refusal = [](const Scene& scene) -> std::string {
    try {
      static_cast<void>(peg_scene(scene, "scene.yaml"));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal(scene_of("resting_box")), testing::HasSubstr("its object is no peg"));
  Scene holeless = scene_of("peg");
  holeless.environment->bodies.front().shape = HalfSpace{};
  EXPECT_THAT(refusal(holeless), testing::HasSubstr("there is no hole for its peg"));
  holeless.environment.reset();
  EXPECT_THAT(refusal(holeless), testing::HasSubstr("there is no hole for its peg"));
  Scene narrow = scene_of("peg");
  std::get<HoleShape>(narrow.environment->bodies.front().shape).radius_m = 9.99e-3;
  EXPECT_THAT(refusal(narrow), testing::HasSubstr("its peg is not thinner than 'hole'"));
  EXPECT_EQ(refusal(scene_of("peg")), "");
}

}  // namespace
}  // namespace thenar::peg_study_test
