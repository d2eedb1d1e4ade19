// SPDX-License-Identifier: Apache-2.0
// What patches do converges: with the step, and with control points as the cap grows along.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/cases/patch_values.h"
#include "tests/support/scenes.h"

namespace thenar::convergence_test {
namespace {

constexpr double kRun_s = 0.14;

// Better than by half an order, from 4 ms on to 1 ms, against a run of 0.25 ms; and small at the default step.
TEST(Convergence, WithTheStep) {
  Scene scene = turned_ball();
  const auto values = [&](double step_s) {
    scene.step_s = scene.control_period_s = step_s;
    return patch_values(scene, kRun_s);
  };
  const PatchValues reference = values(0.25e-3);
  const Eigen::Vector4d coarse = relative_errors(values(4e-3), reference),
                        fine = relative_errors(values(1e-3), reference);
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    EXPECT_LE(fine[i], std::max(coarse[i] / 2.0, 1e-3));  // Of less the reference knows nothing.
    EXPECT_LE(fine[i], 5e-3);
  }
}

// Eight times the control points, with room for all that touch: less than half of the error of slip, spin and margin.
// The moment, a difference of large parts, is accidental with few points; so is the spin of patches of which but a few
// points slip, with less than these.
TEST(Convergence, WithControlPointsAndTheCap) {
  Scene scene = turned_ball();
  scene.step_s = scene.control_period_s = 4e-3;
  const auto values = [&](Eigen::Index controls) { return patch_values(with_controls(scene, controls), kRun_s); };
  const PatchValues reference = values(1280);
  const Eigen::Vector4d coarse = relative_errors(values(80), reference), fine = relative_errors(values(640), reference);
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    EXPECT_LE(fine[i], 0.2);
    if (i < 3) {
      EXPECT_LE(fine[i], coarse[i] / 2.0);
    }
  }
}

}  // namespace
}  // namespace thenar::convergence_test
