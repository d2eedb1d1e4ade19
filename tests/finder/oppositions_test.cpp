// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/oppositions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/finder/known_surfaces.h"

namespace thenar::oppositions_test {
namespace {

using namespace known_surfaces;
using Eigen::Vector3d;

OppositionSettings wide_open() {
  OppositionSettings settings;
  settings.cone_rad = std::atan(0.6);
  settings.most_m = 0.1;
  settings.reach_m = 7e-3;
  return settings;
}

// Lines between faces of a box lie within the cones of both ends, and the ends away from edges.
TEST(Oppositions, OfABoxJoinItsFaces) {
  const Vector3d size_m(0.03, 0.04, 0.05);
  const ImplicitSurface object = box(size_m);
  const PatchMeter patches(object, 3e-3);
  const Oppositions found = find_oppositions(object, patches, wide_open());
  ASSERT_GT(found.pairs.size(), 20U);
  EXPECT_TRUE(found.fits);
  for (const Opposition& pair : found.pairs) {
    const Vector3d u = (pair.to_O - pair.from_O) / pair.width_m;
    int axis = 0;
    u.cwiseAbs().maxCoeff(&axis);
    EXPECT_NEAR(std::abs(pair.from_O[axis]), 0.5 * size_m[axis], 1e-9);
    EXPECT_NEAR(std::abs(pair.to_O[axis]), 0.5 * size_m[axis], 1e-9);
    EXPECT_LE(std::acos(std::abs(u[axis])), std::atan(0.6) + 1e-9);
  }
}

TEST(Oppositions, KeepToTheWishedAxis) {
  const ImplicitSurface object = box({0.03, 0.04, 0.05});
  const PatchMeter patches(object, 3e-3);
  OppositionSettings settings = wide_open();
  settings.wish.axis_O = Vector3d::UnitY();
  const Oppositions found = find_oppositions(object, patches, settings);
  ASSERT_FALSE(found.pairs.empty());
  for (const Opposition& pair : found.pairs) EXPECT_NEAR(std::abs(pair.from_O.y()), 0.02, 1e-9);
}

// Friction that is too little leaves none, and the least angle says how much would do: 0 on a sphere, as its samples
// allow: lines between samples miss the centre by their spacing, here 1.3 mm of 40 mm in a subset of them.
TEST(Oppositions, SayHowNearTheyCameToFacing) {
  const ImplicitSurface object = ball(0.02);
  const PatchMeter patches(object, 3e-3);
  OppositionSettings settings = wide_open();
  settings.most_m = 0.03;
  const Oppositions found = find_oppositions(object, patches, settings);
  EXPECT_FALSE(found.fits) << "40 mm do not fit into 30 mm";
  EXPECT_LT(found.least_angle_rad, 0.2);
  EXPECT_NEAR(found.least_width_m, 0.04 * std::cos(std::atan(0.6) * 0.9), 5e-3) << "a chord within the cones";
}

// Samples are counted, about 40 to a patch: a share is right to about 1/sqrt(40).
TEST(PatchMeter, SeesEdges) {
  const Vector3d size_m(0.03, 0.04, 0.05);
  const ImplicitSurface object = box(size_m);
  const PatchMeter patches(object, 3e-3);
  EXPECT_GT(patches.share({0.0, 0.0, 0.025}), 0.8);
  EXPECT_NEAR(patches.share({0.0149, 0.0, 0.025}), 0.5, 0.2);
  const ImplicitSurface round = ball(0.02);
  EXPECT_GT(PatchMeter(round, 3e-3).share({0.0, 0.02, 0.0}), 0.8) << "a cap has the area of its chord's disc";
}

}  // namespace
}  // namespace thenar::oppositions_test
