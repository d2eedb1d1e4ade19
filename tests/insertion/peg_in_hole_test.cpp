// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>

#include "engine/environment/environment_contacts.h"
#include "tests/support/allocation_counter.h"

// Whitney's theory of a peg in a hole [Whitney 1982, J Dyn Sys Meas Control 104:65], which knows neither of contact
// points nor of solvers, against the contacts of a peg that no hand holds.

namespace thenar::peg_in_hole_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Motion = GroundProblem::Motion;

constexpr double kStep_s = 1e-3, kBand_m = 0.3e-3;

/// A body without a hand, and its environment.
struct FreeBody {
  FreeBody(const Environment& around, const Solid& body, const Isometry3d& X_WO, const Motion& moves)
      : environment(around),
        contacts(around, body),
        work(static_cast<Eigen::Index>(contacts.most())),
        X(X_WO),
        mobility(moves) {
    forces.reserve(contacts.most());
  }

  /// A tick under a wrench about the origin of the body, world axes; the motion.
  Motion step(const Motion& wrench) {
    const double begin_s = kStep_s * tick;
    find_environment_contacts(environment, X, begin_s, begin_s + kStep_s, kBand_m, forces, contacts);
    report = solve_ground({contacts.contacts, environment.compliance_m_per_N, mobility}, mobility.cwiseProduct(wrench),
                          work);
    ++tick;
    keep_forces(contacts, work.f, forces);
    X = moved(X, work.x);
    return work.x;
  }

  Environment environment;
  EnvironmentContacts contacts;
  GroundWorkspace work;
  std::vector<EnvironmentForce> forces;
  Isometry3d X;
  Motion mobility;
  GroundReport report;
  int tick = 0;
};

Environment hole(double radius_m, double friction, double compliance_m_per_N, double chamfer_m = 0.0) {
  Environment environment;
  environment.compliance_m_per_N = compliance_m_per_N;
  EnvironmentBody body;
  body.name = "hole";
  body.shape = HoleShape{radius_m, 50e-3, chamfer_m};
  body.friction = friction;
  environment.bodies.push_back(body);
  return environment;
}

constexpr double kRadius_m = 10e-3, kLength_m = 60e-3;

/// A peg l deep in its hole and tilted about y as far as it goes: two points touch, below at -x and at the mouth at +x.
Isometry3d two_point_pose(double depth_m, double tilt) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(tilt, Vector3d::UnitY()).toRotationMatrix();
  X.translation() = Vector3d(0.0, 0.0, -0.5 * depth_m) + X.linear() * Vector3d(0.0, 0.0, 0.5 * (kLength_m - depth_m));
  return X;
}

/// Whether a peg with two points in touch goes on into the hole under F_z = -1 N, F_x and a moment M about its tip.
bool goes_on(double mu, double lambda, double F_x, double M_per_r) {
  // So small a tilt, and walls of steel: geometry of the second order and elasticity are far below the bar.
  constexpr double kTilt = 2e-4;
  const double depth_m = 2.0 * kRadius_m * mu * lambda, r = kRadius_m - 0.5 * kTilt * depth_m;
  Motion moves;
  moves << Vector3d::Constant(2e-7), Vector3d::Constant(4e-4);
  FreeBody peg(hole(kRadius_m, mu, 1e-10), CylinderShape{r, kLength_m}, two_point_pose(depth_m, kTilt), moves);
  double way_m = 0.0;
  for (int k = 0; k < 20; ++k) {
    const Vector3d tip = peg.X * Vector3d(0.0, 0.0, -0.5 * kLength_m), F(F_x, 0.0, -1.0);
    Motion wrench;
    wrench << F, Vector3d(0.0, M_per_r * r, 0.0) + (tip - peg.X.translation()).cross(F);
    way_m = -peg.step(wrench)[2];
  }
  return way_m > 4e-3 * moves[2];  // Just inside it is as slow as it is near: 0.5 % of free motion at the bar.
}

// M / (r F_z) = lambda + mu (1 + lambda) F_x / F_z is where two sliding points balance what pushes the peg: below, it
// goes on, and above it jams. The other line is that of a peg tilted the other way.
TEST(PegInHole, JamsWhereWhitneysDiagramSays) {
  for (const double mu : {0.1, 0.2, 0.4}) {
    for (const double lambda : {0.5, 1.0, 2.0}) {
      for (int k = 0; k < 9; ++k) {
        const double F_x = (-1.0 + 2.0 * (k + 0.5) / 9.0) / mu;
        const double theory = lambda + mu * (1.0 + lambda) * F_x, bar = 0.005 * (1.0 + lambda);
        SCOPED_TRACE(testing::Message() << "mu " << mu << ", lambda " << lambda << ", F_x / F_z " << F_x);
        EXPECT_TRUE(goes_on(mu, lambda, F_x, theory - bar));
        EXPECT_FALSE(goes_on(mu, lambda, F_x, theory + bar));
      }
    }
  }
}

/// What is left of the contact forces of a peg that was pushed into its hole with this tilt and released [N].
double left_after_release(double tilt_per_limit, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr double kClearance = 0.01, kMu = 0.3;  // c = (D - d) / D
  const double tilt = tilt_per_limit * kClearance / kMu, azimuth = 3.14159 * unit(random);
  const Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0.0);
  const Vector3d aside_m = 20e-6 * Vector3d(unit(random), unit(random), 0.0);
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(tilt, axis).toRotationMatrix();
  X.translation() = aside_m + X.linear() * Vector3d(0.0, 0.0, 0.5 * kLength_m);
  const Isometry3d X_held = X;
  Motion moves;
  moves << Vector3d::Constant(1e-4), Vector3d::Constant(4e-2);
  FreeBody peg(hole(kRadius_m, kMu, 1e-8), CylinderShape{kRadius_m * (1.0 - kClearance), kLength_m}, X, moves);
  double way_m = 0.0;
  for (int k = 0; k < 600; ++k) {
    // The hand holds the tilt, hardly the place, and pushes; in the end it turns the peg on against the hole.
    const Eigen::AngleAxisd more(k < 400 ? 0.0 : 5e-3, axis);
    const Eigen::AngleAxisd off(Eigen::Matrix3d(more * X_held.linear() * peg.X.linear().transpose()));
    Motion wrench;
    wrench << 100.0 * (X_held.translation() - peg.X.translation()), 10.0 * off.angle() * off.axis();
    wrench[2] = -2.0;
    way_m = -peg.step(wrench)[2];
  }
  EXPECT_LT(way_m, 1e-7) << "it still moves";
  for (int k = 0; k < 200; ++k) peg.step(Motion::Zero());
  double left_N = 0.0;
  for (std::size_t i = 0; i < peg.contacts.contacts.size(); ++i) left_N += peg.work.f[i][0];
  return left_N;
}

// Two points can hold a peg between them where the line through them is in both friction cones: l < mu d. With a tilt
// below c / mu the second point is met deeper than that. Forces that hold one another stay when the hand lets go, and
// only there: they are what friction remembers.
TEST(PegInHole, WedgesWhereItsTiltIsAboveTheLimit) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 50; ++trial) {
    SCOPED_TRACE(trial);
    EXPECT_LT(left_after_release(0.8, random), 1e-9) << "seed 5";
    EXPECT_GT(left_after_release(1.2, random), 1e-3) << "seed 5";
  }
}

}  // namespace
}  // namespace thenar::peg_in_hole_test
