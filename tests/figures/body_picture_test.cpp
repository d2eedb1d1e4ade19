// SPDX-License-Identifier: Apache-2.0
// Outlines of bodies: they lie on the bodies' surfaces, and near.

#include "engine/figures/body_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/scenes.h"

namespace thenar::body_picture_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// How far a point is off the solid's surface.
double off_m(const Solid& solid, const Vector3d& point) {
  double least_m = std::numeric_limits<double>::infinity();
  for (int facet = 0; facet < facets(solid); ++facet) {
    if (const auto at = foot(solid, facet, point)) least_m = std::min(least_m, std::abs(at->gap_m));
  }
  return least_m;
}

TEST(BodyPicture, DrawsLinesOnTheSurfaceAndNear) {
  const std::vector<Solid> solids = {HalfSpace{}, BoxShape{{0.04, 3.0, 0.02}}, SphereShape{0.02},
                                     CylinderShape{0.01, 0.06}, HoleShape{0.0101, 0.04, 1e-3}};
  std::mt19937_64 random(3);
  const Vector3d to_eye = random_direction(random);
  for (const Solid& solid : solids) {
    SCOPED_TRACE(solid.index());
    const Isometry3d X_WE = Eigen::Translation3d(0.1, 0.2, 0.3) * random_rotation_about(Vector3d::Zero(), random);
    const Vector3d near_m = X_WE * Vector3d(0.01, 0.005, 0.01);
    std::vector<Surfel> surfels;
    add_outline(solid, X_WE, near_m, to_eye, surfels);
    EXPECT_GT(surfels.size(), 300U);  // Lines of 100 mm at least, in dots of 0.35 mm.
    for (const Surfel& surfel : surfels) {
      // Of places of up to 3 m, the rounding.
      ASSERT_LE(off_m(solid, X_WE.inverse() * surfel.point_m), 1e-14);
      ASSERT_LE((surfel.point_m - near_m).norm(), 0.08);
      ASSERT_EQ(surfel.normal, to_eye);
    }
    surfels.clear();
    add_outline(solid, X_WE, X_WE * Vector3d(0.0, 0.0, 10.0), to_eye, surfels);
    EXPECT_TRUE(surfels.empty());
  }
}

}  // namespace
}  // namespace thenar::body_picture_test
