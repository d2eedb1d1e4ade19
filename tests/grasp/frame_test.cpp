// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/frame.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <numbers>
#include <random>

#include "tests/grasp/grasp_frame.h"
#include "tests/support/scenes.h"

namespace thenar::frame_test {
namespace {

using namespace grasp_frame;

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// A contact keeps its gap where the object rolls or slides under it, if its surface is the sphere that the frame took
// it for; a frozen plane would lose t^2 / 2R of it.
TEST(ContactGap, FollowsTheLocalSphere) {
  std::mt19937_64 random(4);
  for (const double R : {0.02, 0.1, -0.05}) {  // convex, and the inside of a ball
    const Vector3d n = random_direction(random), centre(0.3, -0.2, 0.5);
    const FrameContact contact{.p_F = centre - (R + 1e-4) * n,
                               .s_O = centre - R * n,
                               .n_O = n,
                               .t_O = n.unitOrthogonal(),
                               .curvature_per_m = 1.0 / R,
                               .ring_curvature_per_m = 1.0 / R};
    for (int trial = 0; trial < 20; ++trial) {
      Isometry3d X_FO = random_rotation_about(centre, random);
      X_FO.pretranslate(2e-3 * random_direction(random));
      const double outside_m = (contact.p_F - X_FO * centre).norm() - std::abs(R);
      const auto [gap_m, n_F] = contact_gap(contact, X_FO, Vector3d::Zero());
      EXPECT_NEAR(gap_m, R > 0.0 ? outside_m : -outside_m, 2e-15);
      const Vector3d inwards = std::copysign(1.0, R) * (X_FO * centre - contact.p_F).normalized();
      EXPECT_LE((n_F - inwards).norm(), 1e-13);
    }
  }
}

// Likewise on a torus about z, whose tube of radius r is around a circle of radius C: at the outer side of that and at
// the inner one, where it is a saddle. With a tube that is straight it is a rod.
TEST(ContactGap, FollowsTheLocalTorus) {
  std::mt19937_64 random(7);
  for (const double C : {0.012, 1e6}) {
    for (const double r : {0.004, 0.009}) {
      for (const double side : {1.0, -1.0}) {
        const double equator = C + side * r, ring_per_m = side / equator;
        const Vector3d outward = side * Vector3d::UnitX(), s_O = equator * Vector3d::UnitX();
        const bool tube_is_sharper = 1.0 / r >= std::abs(ring_per_m);
        const FrameContact contact{.p_F = s_O + 1e-4 * outward,
                                   .s_O = s_O,
                                   .n_O = -outward,
                                   .t_O = Vector3d::UnitZ(),
                                   .curvature_per_m = 1.0 / r,
                                   .ring_curvature_per_m = ring_per_m};
        if (!tube_is_sharper) continue;
        for (int trial = 0; trial < 20; ++trial) {
          const Vector3d p_O = s_O + 2e-3 * random_direction(random);
          const Isometry3d X_FO(Eigen::Translation3d(contact.p_F - p_O));
          const double from_axis_m = p_O.head<2>().norm();
          const double over_m = std::hypot(from_axis_m - C, p_O[2]) - r;
          const auto [gap_m, n_F] = contact_gap(contact, X_FO, Vector3d::Zero());
          EXPECT_NEAR(gap_m, over_m, 1e-12 * (1.0 + C));
          const Vector3d ring_O = C / from_axis_m * Vector3d(p_O[0], p_O[1], 0.0);
          EXPECT_LE((n_F - (ring_O - p_O).normalized()).norm(), 1e-7);
        }
      }
    }
  }
}

// Tangents are fixed in the finger and turn with the normal without a twist: along a great circle from the pulp's mean
// normal the frame turns as the normal does. So the components of a force keep their meaning from frame
// to frame.
TEST(ContactFrame, FollowsTheNormalWithoutATwist) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const Vector3d mean_F = random_direction(random);
    const Vector3d axis_F = mean_F.cross(random_direction(random)).normalized();
    const Eigen::AngleAxisd turn_F(uniform(random, 0.0, 2.5), axis_F);
    const Matrix3d at_rest = contact_frame(mean_F, mean_F);
    EXPECT_LE((at_rest.col(0) - mean_F).norm(), 1e-15);
    const Matrix3d turned = contact_frame(mean_F, turn_F * mean_F);
    EXPECT_LE((turned - turn_F.toRotationMatrix() * at_rest).norm(), 1e-13);
  }
}

// There the turn is less and less defined, and axes stay axes.
TEST(ContactFrame, IsOrthonormalUpToOppositeNormals) {
  std::mt19937_64 random(4);
  for (const double short_rad : {0.1, 3e-2, 1e-3, 1e-5, 1e-7, 0.0}) {
    SCOPED_TRACE(short_rad);
    for (int trial = 0; trial < 50; ++trial) {
      const Vector3d mean_F = random_direction(random);
      const Vector3d axis_F = mean_F.cross(random_direction(random)).normalized();
      const Vector3d n_F = Eigen::AngleAxisd(std::numbers::pi - short_rad, axis_F) * mean_F;
      const Matrix3d E = contact_frame(mean_F, n_F);
      EXPECT_EQ(E.col(0), n_F);
      EXPECT_LE((E.transpose() * E - Matrix3d::Identity()).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace thenar::frame_test
