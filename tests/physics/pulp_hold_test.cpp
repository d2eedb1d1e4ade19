// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/scenes.h"

namespace thenar::pulp_hold_test {
namespace {

using Eigen::Vector3d;

/// The thumb under a constant force, a tenth of it along the face.
Scene held(double force_N, double stiffening_per_N = 0.0) {
  Scene scene = pressed_thumb(1e-3, Vector3d(-force_N, 0.1 * force_N, 0.0), 10.0);
  scene.fingertips->material.stiffening_per_N = stiffening_per_N;
  return scene;
}

// Case T22: ten seconds under a constant force. Once the contact has settled nothing has a reason to change: no contact
// comes or goes, and the normal force does not waver.
TEST(PulpHold, NothingChangesUnderAConstantForce) {
  Loop loop(held(0.9));
  loop.run(0.5);
  const auto ids = [&] {
    std::vector<Eigen::Index> all;
    for (const FrameContact& contact : loop.frame.contacts) all.push_back(contact.control_point);
    return all;
  };
  const std::vector<Eigen::Index> first = ids();
  ASSERT_GT(first.size(), 10u);
  double sum = 0.0, squares = 0.0;
  const int kTicks = 9500;
  for (int k = 0; k < kTicks; ++k) {
    loop.tick();
    ASSERT_EQ(ids(), first) << "tick " << k;
    const double change_N = loop.state.load[0].normal_N - 0.9;
    sum += change_N;
    squares += change_N * change_N;
  }
  const double mean_N = sum / kTicks;
  EXPECT_LT(std::sqrt(std::max(0.0, squares / kTicks - mean_N * mean_N)), 1e-3 * 0.9);
  EXPECT_NEAR(mean_N, 0.0, 1e-2 * 0.9);
}

// Dzidek's law: the secant modulus is linear in the load. A pulp that stiffens comes to rest under each load where one
// that has the modulus E* (1 + beta F) from the start does. Within the tick's tolerance of 1e-6 of depths of 1 mm.
TEST(PulpHold, SecantModulusIsLinearInTheLoad) {
  constexpr double kBeta_per_N = 0.5;
  double last_m = 0.0;
  for (const double force_N : {0.3, 0.6, 0.9}) {
    SCOPED_TRACE(force_N);
    Loop stiffening(held(force_N, kBeta_per_N));
    stiffening.run(0.4);
    const double load_N = stiffening.state.load[0].normal_N;
    EXPECT_NEAR(load_N, force_N, 0.01 * force_N);

    Scene scene = held(force_N);
    scene.fingertips->material.reduced_modulus_Pa *= 1.0 + kBeta_per_N * load_N;
    Loop stiffer(scene);
    stiffer.run(0.4);
    const auto moved_m = [](const Loop& loop) {
      return (loop.model.scene.object.X_WO.inverse() * loop.state.X_WO.translation()).x();
    };
    EXPECT_NEAR(moved_m(stiffening), moved_m(stiffer), 1e-7);
    EXPECT_GT(std::abs(moved_m(stiffening) - last_m), 1e-5);
    last_m = moved_m(stiffening);
  }
}

TEST(PulpHold, WithoutStiffeningTheBitsAreTheSame) {
  Loop without(scene_of("box_grasp", {kCoarseBox}));
  Loop with(scene_of("box_grasp", {kCoarseBox, "fingertips.stiffening=0 1/N"}));
  without.run(0.05);
  with.run(0.05);
  EXPECT_EQ(with.state.q, without.state.q);
  EXPECT_EQ(with.state.u_m[0], without.state.u_m[0]);
  EXPECT_GT(with.state.load[0].normal_N, 0.1);
}

}  // namespace
}  // namespace thenar::pulp_hold_test
