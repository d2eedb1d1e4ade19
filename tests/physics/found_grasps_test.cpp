// SPDX-License-Identifier: Apache-2.0
// What the finder promises holds in the engine: random objects that it grasps, one of each kind, are carried by 20 mm
// and pushed by 0.5 N. A step of force may ask a muscle for more than its limit for some milliseconds: that loses
// nothing.
// A quick part of bench/report/grasp_finding_figures.cpp.

#include <gtest/gtest.h>

#include <iostream>
#include <string>

#include "bench/cases/random_objects.h"
#include "engine/models/scene_grasp.h"
#include "tests/support/scenes.h"

namespace thenar::found_grasps_test {
namespace {

// Contact lists are long enough for a ball of 10 mm, which pulps enclose: one that is full drops contacts and takes
// them back every few ticks, and the forces chatter.
TEST(FoundGrasps, HoldInTheEngine) {
  const Scene base = scene_of("box_grasp", {"contact.friction=0.6", "contact.max_per_finger=60",
                                            "control.grasp={friction: 0.42, internal_force: 2 N}"});
  constexpr std::uint32_t kFirst = 1, kLast = 7;  // The seeds.
  int found = 0;
  for (std::uint32_t seed = kFirst; seed <= kLast; ++seed) {
    const RandomObject object = random_object(seed);
    const Scene scene = scene_with(base, object);
    const ImplicitSurface surface = surface_of(scene, object);
    const FinderReport report = find_tried_grasps(scene, surface);
    if (report.grasps.empty()) {
      ASSERT_TRUE(report.refusal);
      EXPECT_FALSE(report.refusal->reason.empty());
      std::cout << "seed " << seed << ": " << object.name << ": " << in_words(*report.refusal) << '\n';
      continue;
    }
    ++found;
    const HoldTrial trial =
        carry_and_push(model_with(scene, surface, report.grasps.front()), report.grasps.front().travel_W, seed);
    EXPECT_TRUE(trial.verdict.outcome == Outcome::kHeld || trial.verdict.outcome == Outcome::kOverLimits)
        << "seed " << seed << ": " << object.name << ": " << in_words(trial.verdict);
  }
  EXPECT_GE(found, 6) << "of " << kLast - kFirst + 1;
}

// Plates of 5 mm, of which most grasps fail that fit: a push across turns the plate about the line of two fingers, and
// pulps that roll take its short lever away. The search goes on until one holds; the push, which it does not try, may
// ask a muscle for more than it has.
TEST(FoundGrasps, OfThinPlatesHoldToo) {
  const Scene base =
      scene_of("box_grasp", {"contact.friction=0.6", "control.grasp={friction: 0.42, internal_force: 2 N}"});
  for (const std::uint32_t seed : {146U, 188U}) {
    const RandomObject object = random_object(seed);
    const Scene scene = scene_with(base, object);
    const ImplicitSurface surface = surface_of(scene, object);
    const FinderReport report = find_tried_grasps(scene, surface);
    ASSERT_FALSE(report.grasps.empty()) << object.name << ": " << in_words(*report.refusal);
    const FoundGrasp& grasp = report.grasps.front();
    EXPECT_TRUE(grasp.rehearsal.held()) << object.name;
    EXPECT_FALSE(grasp.travel_W.isZero()) << "it was carried nowhere";
    const HoldTrial trial = carry_and_push(model_with(scene, surface, grasp), grasp.travel_W, seed);
    EXPECT_TRUE(trial.verdict.outcome == Outcome::kHeld || trial.verdict.outcome == Outcome::kOverLimits)
        << object.name << ": " << in_words(trial.verdict);
  }
}

// The friction that a grasp is said to need is the least one with which no finger slides, of objects that are large
// against pulps: to 6 %, where bisection leaves 1 %, the ellipsoid between friction and torsion up to 6 % of what a
// torsion adds, and normals that fan out over a patch on a round object press a little more than the pulp does.
TEST(FoundGrasps, NeedTheFrictionThatTheySay) {
  const Scene base =
      scene_of("box_grasp", {"contact.friction=0.6", "control.grasp={friction: 0.42, internal_force: 2 N}"});
  for (const std::uint32_t seed : {3U, 5U, 8U}) {
    const RandomObject object = random_object(seed);
    const Scene scene = scene_with(base, object);
    const ImplicitSurface surface = surface_of(scene, object);
    const FinderReport report = find_tried_grasps(scene, surface);
    ASSERT_FALSE(report.grasps.empty()) << object.name;
    const double said = report.grasps.front().needed_friction;
    const double least = least_friction(model_with(scene, surface, report.grasps.front()), 0.5 * said, 2.0 * said);
    EXPECT_NEAR(least / said, 1.0, 0.06) << "seed " << seed << ": " << object.name;
  }
}

}  // namespace
}  // namespace thenar::found_grasps_test
