// SPDX-License-Identifier: Apache-2.0
// Strings around spheres and cylinders.

#include "engine/imports/wrapping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace thenar::wrapping_test {
namespace {

using Eigen::Vector3d;

Vector3d random_point(std::mt19937_64& random, double size_m) {
  std::uniform_real_distribution<double> number(-size_m, size_m);
  return {number(random), number(random), number(random)};
}

/// A taut string leaves a smooth surface along its tangent, and on it runs along a shortest line.
TEST(Wrapping, AStringLeavesTheSurfaceAlongItsTangent) {
  std::mt19937_64 random(1);
  int wrapped = 0;
  for (int i = 0; i < 2000; ++i) {
    const WrapSurface surface{0.01, i % 2 == 0};
    const Vector3d a = random_point(random, 0.04), b = random_point(random, 0.04), side = random_point(random, 0.05);
    if (side.head<2>().norm() < 0.01) continue;  // Inside of a cylinder: the next test.
    const auto touch = wrap(surface, a, b, i % 3 == 0 || !surface.is_cylinder ? std::nullopt : std::optional(side));
    if (!touch) continue;
    ++wrapped;
    std::vector<double> slopes;
    for (const auto& [end, at] : {std::pair{a, (*touch)[0]}, std::pair{b, (*touch)[1]}}) {
      Vector3d normal = at;
      if (surface.is_cylinder) normal.z() = 0.0;
      EXPECT_NEAR(normal.norm(), 0.01, 1e-14);
      EXPECT_NEAR((end - at).normalized().dot(normal.normalized()), 0.0, 1e-7);
      slopes.push_back((end.z() - at.z()) / (end - at).head<2>().norm());
    }
    // Unrolled, a string around a cylinder is straight: it rises alike before and behind it.
    if (surface.is_cylinder) {
      EXPECT_NEAR(slopes[0], -slopes[1], 1e-6 * (1.0 + std::abs(slopes[0])));
    }
  }
  EXPECT_GT(wrapped, 500);
}

TEST(Wrapping, AStringThroughARingIsReflectedAtIt) {
  std::mt19937_64 random(2);
  int touched = 0;
  for (int i = 0; i < 500; ++i) {
    const WrapSurface ring{0.01, true};
    const Vector3d a = random_point(random, 0.04), b = random_point(random, 0.04);
    const auto touch = wrap(ring, a, b, Vector3d(0.001, 0.002, 0));
    if (!touch) continue;
    ++touched;
    // The way over a point of the circle is the shortest where it makes equal angles with the radius.
    const Eigen::Vector2d p = (*touch)[0].head<2>(), n = p.normalized();
    EXPECT_NEAR(n.dot((a.head<2>() - p).normalized()), n.dot((b.head<2>() - p).normalized()), 1e-6);
  }
  EXPECT_GT(touched, 50);
}

TEST(Wrapping, AStringThatMeetsNothingGoesStraight) {
  const WrapSurface surface{0.01, false};
  EXPECT_FALSE(wrap(surface, {0.03, -0.05, 0}, {0.03, 0.05, 0}, std::nullopt));
  EXPECT_FALSE(wrap(surface, {0.03, -0.05, 0}, {0.03, 0.05, 0}, Vector3d(0.02, 0, 0)));
  EXPECT_TRUE(wrap(surface, {0.03, -0.05, 0}, {0.03, 0.05, 0}, Vector3d(-0.02, 0, 0))) << "it goes the other way round";
  EXPECT_FALSE(wrap(surface, {0.003, -0.005, 0}, {0.03, 0.05, 0}, std::nullopt)) << "from inside";
}

}  // namespace
}  // namespace thenar::wrapping_test
