// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/sampled_solid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "collision/shapes.h"
#include "collision/solids/solid_contacts.h"
#include "tests/support/allocation_counter.h"

namespace thenar::sampled_solid_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

std::vector<SolidContact> contacts_of(const TouchingSolid& a, const Solid& b, const Isometry3d& X_BA, double band_m) {
  std::vector<SolidContact> contacts;
  contacts.reserve(most_contacts(a, b));
  const SolidPair pair(a, b);
  const AllocationCounter allocations;
  find_contacts(pair, X_BA, band_m, contacts);
  EXPECT_EQ(allocations.count(), 0);
  return contacts;
}

std::shared_ptr<const SampledSolid> sampled(const PointCloud& cloud) {
  return std::make_shared<const SampledSolid>(cloud);
}

Isometry3d turned(const Vector3d& turn, const Vector3d& place_m = Vector3d::Zero()) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = place_m;
  if (!turn.isZero(0.0)) X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  return X;
}

double least_gap_m(const std::vector<SolidContact>& contacts) {
  double least_m = 1.0;
  for (const SolidContact& contact : contacts) least_m = std::min(least_m, contact.gap_m);
  return least_m;
}

constexpr double kRadius_m = 25e-3;
const Vector3d kAxes_m(50e-3, 60e-3, 40e-3);  // Of an ellipsoid.

/// How far an ellipsoid reaches along n.
double reach_of_ellipsoid_m(const Vector3d& n) { return 0.5 * kAxes_m.cwiseProduct(n).norm(); }

// On a plane a ball of samples is as high as the ball, whichever of its samples is below: those lie up to
// h^2 / (8 R) = 6 um too high, and each stands for the ball around it.
TEST(SampledSolid, ABallTouchesAPlaneAndABallAsTheBallDoes) {
  const auto ball = sampled(sample_sphere(kRadius_m, 6000));
  const SphereShape body{10e-3};
  std::mt19937 random(1);
  std::normal_distribution<double> unit;
  for (int trial = 0; trial < 300; ++trial) {
    const Isometry3d X = turned({unit(random), unit(random), unit(random)}, {0.0, 0.0, kRadius_m + 0.05e-3});
    const auto on_plane = contacts_of(ball, HalfSpace{}, X, 0.2e-3);
    ASSERT_EQ(on_plane.size(), 1U) << trial;
    EXPECT_NEAR(on_plane[0].gap_m, 0.05e-3, 1e-9) << trial;
    EXPECT_LT(on_plane[0].p_m.head<2>().norm(), 1e-6) << trial;
    const auto on_ball = contacts_of(ball, body, turned({unit(random), 1.0, 0.0}, {0.0, 35.05e-3, 0.0}), 0.2e-3);
    ASSERT_EQ(on_ball.size(), 1U) << trial;
    EXPECT_NEAR(on_ball[0].gap_m, 0.05e-3, 2e-9) << trial;
  }
  EXPECT_LT(ball->round_error_m(), 1e-8);
  EXPECT_TRUE(ball->sharp().empty());
}

// Where curvature changes the next order is left: far less than h^2 / (8 R), of which the bound says no less.
TEST(SampledSolid, AnEllipsoidIsAsFarOffAsItSays) {
  const auto ellipsoid = sampled(sample_ellipsoid(kAxes_m, 6000));
  const double sagitta_m = ellipsoid->spacing_m() * ellipsoid->spacing_m() / (8.0 * 16e-3);
  EXPECT_LT(ellipsoid->round_error_m(), 0.05 * sagitta_m);
  std::mt19937 random(2);
  std::normal_distribution<double> unit;
  double most_m = 0.0;
  for (int trial = 0; trial < 500; ++trial) {
    Isometry3d X = turned({unit(random), unit(random), unit(random)});
    const Vector3d down_O = X.linear().transpose() * -Vector3d::UnitZ();
    X.translation()[2] = reach_of_ellipsoid_m(down_O);
    const auto contacts = contacts_of(ellipsoid, HalfSpace{}, X, 0.2e-3);
    ASSERT_EQ(contacts.size(), 1U) << trial;
    most_m = std::max(most_m, std::abs(contacts[0].gap_m));
  }
  EXPECT_LE(most_m, ellipsoid->round_error_m());
}

// Rolling from sample to sample the gap has no steps but what the cells' surfaces differ by.
TEST(SampledSolid, ARollingEllipsoidHasNoSteps) {
  const auto ellipsoid = sampled(sample_ellipsoid(kAxes_m, 6000));
  double before_m = 0.0;
  constexpr double kTurn = 1e-4;
  for (int k = 0; k < 3000; ++k) {
    Isometry3d X = turned(kTurn * k * Vector3d(1.0, 0.2, 0.0));
    const Vector3d down_O = X.linear().transpose() * -Vector3d::UnitZ();
    X.translation()[2] = reach_of_ellipsoid_m(down_O);
    const double gap_m = least_gap_m(contacts_of(ellipsoid, HalfSpace{}, X, 0.2e-3));
    if (k > 0) {
      EXPECT_LT(std::abs(gap_m - before_m), 0.5 * ellipsoid->round_error_m()) << k;
    }
    before_m = gap_m;
  }
}

// No sample lies on an edge: the planes of its faces say where it is. A box of samples has the box's corners, and
// touches a plane where the box does.
TEST(SampledSolid, ABoxHasItsCornersAndTouchesAsTheBox) {
  const Vector3d size_m(50e-3, 40e-3, 30e-3);
  const auto box = sampled(sample_box(size_m, 8000));
  const auto bends = std::ranges::count_if(box->sharp(), [](const SharpPoint& point) { return !point.is_straight; });
  EXPECT_EQ(bends, 8);
  EXPECT_TRUE(box->bent().empty());
  std::mt19937 random(3);
  std::normal_distribution<double> unit;
  for (int trial = 0; trial < 200; ++trial) {
    const double tilt = trial % 2 == 0 ? 1e-3 : 1.0;
    Isometry3d X = turned(tilt * Vector3d(unit(random), unit(random), unit(random)));
    const Vector3d down_O = X.linear().transpose() * -Vector3d::UnitZ();
    X.translation()[2] = 0.5 * size_m.dot(down_O.cwiseAbs());
    const auto ours = contacts_of(box, HalfSpace{}, X, 0.2e-3),
               exact = contacts_of(BoxShape{size_m}, HalfSpace{}, X, 0.2e-3);
    ASSERT_EQ(ours.size(), exact.size()) << trial;
    EXPECT_NEAR(least_gap_m(ours), 0.0, 1e-12) << trial;
  }
}

// It lies on its side as a cylinder, not as the polygon of its rims; upright it stands on these, by no more contacts
// than are allowed.
TEST(SampledSolid, ACylinderLiesOnItsSideAndStandsOnItsRim) {
  const double radius_m = 12e-3, length_m = 50e-3;
  const auto cylinder = sampled(sample_cylinder(radius_m, length_m, 8000));
  for (int k = 0; k < 50; ++k) {
    const Isometry3d roll = turned({0.0, 0.0, 0.013 * k});
    const Isometry3d X = turned({0.5 * std::numbers::pi, 0.0, 0.0}, {0.0, 0.0, radius_m}) * roll;
    const auto contacts = contacts_of(cylinder, HalfSpace{}, X, 0.1e-3);
    EXPECT_NEAR(least_gap_m(contacts), 0.0, 1e-8) << k;
    double low_m = 1.0, high_m = -1.0;
    for (const SolidContact& contact : contacts) {
      if (contact.gap_m > 1e-7) continue;
      low_m = std::min(low_m, contact.p_m.y());
      high_m = std::max(high_m, contact.p_m.y());
    }
    EXPECT_LT(low_m, -0.5 * length_m + 2.5 * cylinder->spacing_m());
    EXPECT_GT(high_m, 0.5 * length_m - 2.5 * cylinder->spacing_m());
  }
  const auto upright = contacts_of(cylinder, HalfSpace{}, turned(Vector3d::Zero(), {0.0, 0.0, 0.5 * length_m}), 0.1e-3);
  EXPECT_GE(upright.size(), 16U);
  EXPECT_LE(upright.size(), 32U);
  for (const SolidContact& contact : upright) {
    EXPECT_NEAR(contact.gap_m, 0.0, 1e-9);
    EXPECT_NEAR(contact.p_m.head<2>().norm(), radius_m, 20e-6);
  }
}

// A plate whose sides have next to no samples has no edges by them; what is at the rim of its faces stands in.
TEST(SampledSolid, AThinPlateDoesNotFallThrough) {
  const Vector3d size_m(60e-3, 40e-3, 0.3e-3);
  const auto plate = sampled(sample_box(size_m, 1500));
  const auto contacts = contacts_of(plate, HalfSpace{}, turned(Vector3d::Zero(), {0.0, 0.0, 0.15e-3}), 0.1e-3);
  Eigen::AlignedBox2d support_m;
  for (const SolidContact& contact : contacts) {
    EXPECT_NEAR(contact.gap_m, 0.0, 1e-9);
    support_m.extend(Eigen::Vector2d(contact.p_m.head<2>()));
  }
  ASSERT_GE(contacts.size(), 4U);
  EXPECT_GT(support_m.sizes().x(), size_m.x() - 4.0 * plate->spacing_m());
  EXPECT_GT(support_m.sizes().y(), size_m.y() - 4.0 * plate->spacing_m());
}

// Noise makes bumps: a scan stands on the highest of them. It stands as far off as its samples do, and no farther.
TEST(SampledSolid, ANoisyScanTouchesWithinItsNoise) {
  PointCloud cloud = sample_sphere(kRadius_m, 6000);
  std::mt19937 random(4);
  std::normal_distribution<double> unit;
  constexpr double kNoise_m = 10e-6;
  for (Eigen::Index i = 0; i < cloud.points_m.cols(); ++i) {
    cloud.points_m.col(i) += kNoise_m * unit(random) * cloud.normals.col(i);
    cloud.normals.col(i) =
        (cloud.normals.col(i) + 0.02 * Vector3d(unit(random), unit(random), unit(random))).normalized();
  }
  const auto scan = sampled(cloud);
  for (int trial = 0; trial < 300; ++trial) {
    const Isometry3d X = turned({unit(random), unit(random), unit(random)}, {0.0, 0.0, kRadius_m});
    const auto contacts = contacts_of(scan, HalfSpace{}, X, 0.2e-3);
    ASSERT_GE(contacts.size(), 1U) << trial;
    EXPECT_NEAR(least_gap_m(contacts), 0.0, 5.0 * kNoise_m) << trial;
  }
  EXPECT_GT(scan->round_error_m(), 0.1 * kNoise_m);
}

// Corners and edges of a body meet the samples' surface from below: a box that is larger than the body stands on it.
TEST(SampledSolid, ABoxStandsOnASmallerBox) {
  const auto box = sampled(sample_box({60e-3, 60e-3, 20e-3}, 8000));
  const auto contacts =
      contacts_of(box, BoxShape{{20e-3, 20e-3, 20e-3}}, turned({0.0, 0.0, 0.3}, {0.0, 0.0, 20e-3}), 0.1e-3);
  int corners = 0;
  for (const SolidContact& contact : contacts) {
    EXPECT_NEAR(contact.gap_m, 0.0, 1e-7);
    EXPECT_GT(contact.n.z(), 0.999999);
    corners += contact.p_m.head<2>().cwiseAbs().minCoeff() > 9.99e-3;
  }
  EXPECT_EQ(corners, 4);
}

}  // namespace
}  // namespace thenar::sampled_solid_test
