// SPDX-License-Identifier: Apache-2.0
#include "solvers/residual.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/recorded_problems.h"

namespace thenar::residual_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

double cone_violation(const Vector3d& f, double mu) { return f.tail<2>().norm() - mu * f[0]; }

// What makes a point p of a closed convex cone the projection of x: x - p is normal to p, and makes an obtuse angle
// with every other point of the cone. Forces are of order 1, so rounding is of order 1e-16.
TEST(ProjectOnCone, IsTheNearestPointOfTheCone) {
  for (const double mu : {0.0, 0.3, 1.0, 4.0}) {
    std::mt19937 random(1);
    for (int k = 0; k < 2000; ++k) {
      const Vector3d x = random_vector(random);
      const Vector3d p = project_on_cone(x, mu);
      EXPECT_LE(cone_violation(p, mu), 1e-14);
      EXPECT_NEAR((x - p).dot(p), 0.0, 1e-14 * (1.0 + x.squaredNorm()));
      Vector3d y = random_vector(random);
      y[0] = std::abs(y[0]);
      y.tail<2>() *= std::min(1.0, mu * y[0] / y.tail<2>().norm());
      EXPECT_LE((x - p).dot(y), 1e-14 * (1.0 + x.norm() * y.norm()));
    }
  }
}

TEST(ProjectOnCone, LeavesTheConeAndSendsItsPolarToTheTip) {
  const Vector3d inside(2.0, 0.5, -0.5);
  EXPECT_EQ(project_on_cone(inside, 0.5), inside);
  EXPECT_EQ(project_on_cone({-1.0, 0.5, 0.0}, 0.5), Vector3d::Zero());
  EXPECT_EQ(project_on_cone(Vector3d::Zero(), 0.5), Vector3d::Zero());
}

// The files state the residual of their reference forces; both computations round delta = W f + delta_free, by
// about sqrt(180) * 1e-16 of its terms, which are a few times delta_free.
TEST(NaturalMapResidual, AgreesWithTheRecordedReferences) {
  for (const ContactFile& problem : recorded_contact_problems()) {
    SCOPED_TRACE(problem.name);
    const VectorXd delta = problem.W * problem.f_reference + problem.delta_free[0];
    const double residual = natural_map(problem.problem(), problem.f_reference, delta).norm;
    EXPECT_NEAR(residual, problem.reference_residual, 1e-14);
  }
}

// One contact by hand: W = 2 I, so rho = 1/2; delta_free = (-4, 0, 0) needs f = (2, 0, 0). With f = (1, 0, 0) the
// gap is -2, the map goes to (1 + 1, 0, 0), the error is 1 N, the scale 4/2 = 2 N.
TEST(NaturalMapResidual, OfOneContactByHand) {
  const ContactData problem{2.0 * Matrix3d::Identity(), Vector3d(-4.0, 0.0, 0.0), VectorXd::Constant(1, 0.5)};
  const auto residual_of = [&](const Vector3d& f) {
    return natural_map(problem, f, problem.W * f + problem.delta_free).norm;
  };
  EXPECT_DOUBLE_EQ(residual_of({1.0, 0.0, 0.0}), 0.5);
  EXPECT_LE(residual_of({2.0, 0.0, 0.0}), 1e-15);
}

// Two walls, no solution: gaps of W (f_1 - f_2) - 1 and W (f_2 - f_1) - 1. Forces of 1e20 N make both round to zero.
TEST(NaturalMapResidual, ForcesWithoutDigitsLeftAreNoSolution) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(6, 6);
  W(0, 3) = W(3, 0) = -1.0;
  const VectorXd delta_free = (VectorXd(6) << -1.0, 0.0, 0.0, -1.0, 0.0, 0.0).finished();
  const VectorXd f = 1e20 * (VectorXd(6) << 1.0, 0.0, 0.0, 1.0, 0.0, 0.0).finished();
  // As a solver sums them up: W f first, then delta_free.
  const VectorXd delta = VectorXd::Zero(6);
  EXPECT_GT(natural_map({W, delta_free, VectorXd::Ones(2)}, f, delta).norm, 1.0);
}

// The norm is that of all contacts' errors, the worst is the largest of them: by hand, 3 N and 4 N over 5 N.
TEST(NaturalMap, WorstIsOneContacts) {
  const ContactData problem{Eigen::MatrixXd::Identity(6, 6), (VectorXd(6) << -3.0, 0.0, 0.0, -4.0, 0.0, 0.0).finished(),
                            VectorXd::Ones(2)};
  const Residual residual = natural_map(problem, VectorXd::Zero(6), problem.delta_free);
  EXPECT_DOUBLE_EQ(residual.norm, 1.0);
  EXPECT_DOUBLE_EQ(residual.worst, 0.8);
  EXPECT_DOUBLE_EQ(residual_scale_N(problem), 5.0);
}

TEST(NaturalMapResidual, IsZeroWithoutContactOrFreeMotion) {
  const VectorXd none(0);
  EXPECT_EQ(natural_map({Eigen::MatrixXd(0, 0), none, none}, none, none).norm, 0.0);
  const VectorXd zero = VectorXd::Zero(3);
  EXPECT_EQ(natural_map({Matrix3d::Identity(), zero, VectorXd::Ones(1)}, zero, zero).norm, 0.0);
}

// Without friction the cone is a ray: a pull goes to its tip, also one without any tangential part, and an open contact
// is solved.
TEST(Residual, AConeWithoutFrictionIsARay) {
  EXPECT_EQ(project_on_cone({-1.0, 0.0, 0.0}, 0.0), Eigen::Vector3d::Zero());
  EXPECT_EQ(project_on_cone({-1.0, 2.0, 0.0}, 0.0), Eigen::Vector3d::Zero());
  EXPECT_EQ(project_on_cone({1.0, 2.0, 0.0}, 0.0), Eigen::Vector3d(1.0, 0.0, 0.0));
  const Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d open(0.1, 0.0, 0.0), no_force = Eigen::Vector3d::Zero();
  EXPECT_EQ(natural_map({W, open, VectorXd::Zero(1)}, no_force, open).norm, 0.0);
}

}  // namespace
}  // namespace thenar::residual_test
