#include "engine/finder/wrench_space.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>
#include <vector>

#include "engine/grasp/frame.h"

namespace thenar::wrench_space_test {
namespace {

using Eigen::Vector3d;
using Points = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Matrix6d some_turn(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Matrix6d A;
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = normal(random);
  return Eigen::HouseholderQR<Matrix6d>(A).householderQ();
}

// The two regular bodies whose size is known in any dimension, however they are turned. Points are moved by up to
// 1e-7 of their size so that no facet has more than six corners: that is the tolerance, with room for the 64 corners.
constexpr double kTolerance = 1e-5;

TEST(Hull6, KnowsTheCrossPolytope) {
  Points points(6, 12);
  points << Matrix6d::Identity(), -Matrix6d::Identity();
  const Hull6 hull = hull6(some_turn(1) * points);
  EXPECT_NEAR(hull.inradius, 1.0 / std::sqrt(6.0), kTolerance);
  EXPECT_NEAR(hull.volume, 64.0 / 720.0, kTolerance);
}

TEST(Hull6, KnowsTheCube) {
  Points points(6, 64);
  for (int i = 0; i < 64; ++i) {
    for (int k = 0; k < 6; ++k) points(k, i) = (i >> k) % 2 == 0 ? -1.0 : 1.0;
  }
  const Hull6 hull = hull6(some_turn(2) * points);
  EXPECT_NEAR(hull.inradius, 1.0, kTolerance);
  EXPECT_NEAR(hull.volume, 64.0, 64.0 * kTolerance);
}

TEST(Hull6, HasNoBallWhereTheOriginIsOutside) {
  Points points(6, 12);
  points << Matrix6d::Identity(), -Matrix6d::Identity();
  points.colwise() += Vector6d(2.0 * Vector6d::Unit(3));
  EXPECT_EQ(hull6(points).inradius, 0.0);
  EXPECT_EQ(hull6(Points::Zero(6, 5)).volume, 0.0) << "no body at all";
}

GraspContact contact(const Vector3d& point_m, const Vector3d& inward) {
  return {point_m, axes_of(inward, inward.unitOrthogonal())};
}

// Two point contacts leave the turn about their line free: no ball. Three hold all.
TEST(GraspQuality, NeedsThreeContactsForABall) {
  std::vector<GraspContact> contacts{contact({-0.02, 0.0, 0.0}, Vector3d::UnitX()),
                                     contact({0.02, 0.0, 0.0}, -Vector3d::UnitX())};
  EXPECT_EQ(grasp_quality(contacts, Vector3d::Zero(), 0.5, 0.02).epsilon, 0.0);
  contacts.pop_back();
  contacts.push_back(contact({0.02, 0.01, 0.0}, -Vector3d::UnitX()));
  contacts.push_back(contact({0.02, -0.01, 0.0}, -Vector3d::UnitX()));
  const GraspQuality three = grasp_quality(contacts, Vector3d::Zero(), 0.5, 0.02);
  EXPECT_GT(three.epsilon, 0.0);
  EXPECT_GT(three.volume, 0.0);
  EXPECT_GT(three.isotropy, 0.0);
  EXPECT_LT(three.isotropy, 1.0);
  const GraspQuality rougher = grasp_quality(contacts, Vector3d::Zero(), 0.8, 0.02);
  EXPECT_GT(rougher.epsilon, three.epsilon) << "wider cones contain the narrower ones";
  EXPECT_GT(rougher.volume, three.volume);
}

}  // namespace
}  // namespace thenar::wrench_space_test
