// SPDX-License-Identifier: Apache-2.0
#include "engine/pulps/pulp_levels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "engine/models/build_model.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/scenes/config.h"
#include "tests/support/algebra.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::pulp_levels_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

Scene grasp(const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"object.points=500"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return scene_of("box_grasp", all);
}

std::vector<LevelEstimate> estimates(const Scene& scene) {
  std::vector<Pulp> pulps = make_pulps(scene);
  return estimate_levels(scene, pulps);
}

// Whatever the level, the control points lie on the sphere and share all of it. 320 leaves halve to 5, then 2 and 3.
TEST(PulpLevels, ShareTheSurfaceAmongFewerPoints) {
  Pulp pulp = make_spherical_pulp(Vector3d(1e-3, 0.0, 2e-3), 8e-3, 2400, 320, {0.24e6, 0.5, 0.0});
  const std::vector<Index> controls{320, 128, 64, 32, 16, 8};
  for (int level = 0; level < std::ssize(controls); ++level) {
    SCOPED_TRACE(level);
    set_level(pulp, level);
    EXPECT_EQ(pulp.controls(), controls[level]);
    EXPECT_NEAR(pulp.area_m2.sum(), 4.0 * std::numbers::pi * 64e-6, 1e-15);
    const Eigen::VectorXd radii_m = (pulp.control_points_m.colwise() - pulp.centre_m).colwise().norm();
    EXPECT_TRUE(radii_m.isApproxToConstant(8e-3, 1e-12));
    EXPECT_TRUE(is_positive_definite(pulp.kernel));
  }
  set_level(pulp, 20);
  EXPECT_EQ(pulp.controls(), 1);
}

TEST(PulpLevels, LevelZeroIsWhatAPulpIsMadeWith) {
  const Pulp made = make_spherical_pulp(Vector3d::Zero(), 8e-3, 600, 80, {0.24e6, 0.5, 0.0});
  Pulp set = made;
  set_level(set, 2);
  set_level(set, 0);
  EXPECT_EQ(set.control_points_m, made.control_points_m);
  EXPECT_EQ(set.kernel, made.kernel);
}

// Every point of a cloud may be a control point of its own, with any kernel.
TEST(PulpLevels, ComplianceOfEveryPulpIsPositiveDefinite) {
  for (const PulpKernel kernel : {PulpKernel::kBoussinesq, PulpKernel::kGaussian}) {
    for (const Index points : {1, 2, 3, 10, 100, 600}) {
      for (const Index leaves : {Index{1}, (points + 1) / 2, points}) {
        SCOPED_TRACE(std::to_string(points) + " points, leaves " + std::to_string(leaves));
        const Pulp pulp = make_spherical_pulp(Vector3d::Zero(), 8e-3, points, leaves, {0.24e6, 0.5, 0.0, kernel});
        EXPECT_TRUE(pulp.kernel.allFinite());
        EXPECT_TRUE(is_positive_definite(pulp.kernel));
      }
    }
  }
}

// The estimate is made from a few presses; what the same pulps really do over many directions and all depths up to the
// load's is within a factor of two of it.
TEST(PulpLevels, EstimateIsTheErrorOfRealPresses) {
  const Scene scene = grasp();
  std::vector<Pulp> pulps = make_pulps(scene);
  const std::vector<LevelEstimate> levels = estimate_levels(scene, pulps);
  std::mt19937_64 random(5);
  for (const LevelEstimate& level : levels) {
    if (level.force_error > 0.2) break;  // Coarser ones hardly touch: nobody takes them.
    SCOPED_TRACE(level.level);
    double sum = 0.0, count = 0.0;
    for (int k = 0; k < kFingers; ++k) {
      set_level(pulps[k], level.level);
      const double deepest_m = hertz_depth_m(pulps[k], expected_load_N(scene, pulps[k]));
      while (count < 100.0 * (k + 1)) {
        const Vector3d n = random_direction(random);
        if (n.dot(scene.hand.fingertips[k].normal) < 0.7) continue;
        const double depth_m = uniform(random, 0.5, 1.0) * deepest_m;
        const double force_N =
            press(pulps[k], n, depth_m, scene.contact.band_m, scene.contact.max_per_finger).force_N.sum();
        sum += std::pow(force_N / hertz_force_N(pulps[k], depth_m) - 1.0, 2);
        count += 1.0;
      }
    }
    const double real = std::sqrt(sum / count);
    EXPECT_GT(level.force_error, 0.5 * real);
    EXPECT_LT(level.force_error, 2.0 * real);
  }
}

TEST(PulpLevels, LooserTolerancesTakeCoarserLevels) {
  const std::vector<LevelEstimate> levels = estimates(grasp());
  int last = 0;
  for (const double allowed : {0.0, 0.005, 0.02, 0.05, 0.4, 1.0}) {
    const LevelEstimate& level = choose_level(levels, allowed);
    EXPECT_GE(level.level, last);
    last = level.level;
    const double least = std::min_element(levels.begin(), levels.end(), [](const auto& a, const auto& b) {
                           return a.force_error < b.force_error;
                         })->force_error;
    EXPECT_LE(level.force_error, std::max(allowed, least));
  }
  EXPECT_GT(last, 2);
  // Coarser is worse, and cheaper.
  for (std::size_t l = 1; l < levels.size(); ++l) {
    EXPECT_LT(levels[l].controls, levels[l - 1].controls);
    EXPECT_LE(levels[l].contacts, levels[l - 1].contacts);
    if (l < 4) {
      EXPECT_GT(levels[l].force_error, 0.9 * levels[l - 1].force_error);
    }
  }
}

// With room for five contacts, a fine level leaves out most of what touches, and a coarser one is better.
TEST(PulpLevels, KnowThatContactsAreFew) {
  const std::vector<LevelEstimate> levels = estimates(grasp({"contact.max_per_finger=5"}));
  EXPECT_LE(levels.front().contacts, 5.0);
  EXPECT_GT(levels.front().force_error, 2.0 * levels[2].force_error);
  EXPECT_GT(choose_level(levels, 0.0).level, 0);
}

TEST(PulpLevels, SceneTakesItsLevel) {
  EXPECT_EQ(build_model(grasp()).pulps[0].controls(), 320);
  EXPECT_EQ(build_model(grasp({"contact.level=leaves"})).pulps[0].controls(), 320);
  EXPECT_EQ(build_model(grasp({"contact.level=1"})).pulps[0].controls(), 128);

  const Scene automatic = grasp({"contact.level=auto", "contact.force_error=5 %"});
  const LevelEstimate chosen = choose_level(estimates(automatic), 0.05);
  const Model model = build_model(automatic);
  EXPECT_EQ(model.pulps[0].controls(), chosen.controls);
  EXPECT_EQ(model.max_contacts, kFingers * 22);
  EXPECT_EQ(build_model(grasp({"contact.level=5"})).max_contacts, kFingers * 8);
}

TEST(PulpLevels, SceneRefusesWhatIsNoLevel) {
  EXPECT_THROW(grasp({"contact.level=9"}), ConfigError);
  EXPECT_THROW(grasp({"contact.level=coarse"}), ConfigError);
  EXPECT_THROW(grasp({"fingertips.leaves=100", "contact.level=7"}), ConfigError);
  EXPECT_NO_THROW(grasp({"fingertips.leaves=100", "contact.level=6"}));
  EXPECT_THROW(grasp({"contact.level=auto", "contact.force_error=0.05"}), ConfigError);
  // Without a choice to make it would mean nothing.
  EXPECT_THROW(grasp({"contact.force_error=5 %"}), ConfigError);
  EXPECT_THROW(grasp({"fingertips.stiffening=-1 1/N"}), ConfigError);
}

// A coarser pulp holds the box as well, with fewer contacts, and fewer of them pressed.
TEST(PulpLevels, CoarserPulpsHoldTheBox) {
  double contacts = 1e9;
  for (const char* level : {"contact.level=leaves", "contact.level=1", "contact.level=2"}) {
    SCOPED_TRACE(level);
    Scene scene = scene_of("box_grasp", {level, kCoarseBox});
    scene.task = {};
    Loop loop(scene);
    loop.run(0.3);
    const TickReport report = loop.tick();
    EXPECT_EQ(report.solve.status, SolveStatus::kConverged);
    EXPECT_LT(static_cast<double>(report.active), contacts);
    contacts = static_cast<double>(report.active);
    // The controller asks for 2 N of internal force a finger, and for somewhat more or less to hold the weight.
    double normal_N = 0.0;
    for (const FingerLoad& load : loop.state.load) normal_N += load.normal_N;
    EXPECT_NEAR(normal_N, kFingers * 2.0, 0.2 * kFingers * 2.0);
    EXPECT_LT((loop.state.X_WO.translation() - loop.model.target(0.3).translation()).norm(), 2e-3);
  }
}

}  // namespace
}  // namespace thenar::pulp_levels_test
