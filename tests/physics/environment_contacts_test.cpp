// SPDX-License-Identifier: Apache-2.0
#include "engine/environment/environment_contacts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "engine/environment/room_for.h"

namespace thenar::environment_contacts_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Motion = GroundProblem::Motion;

constexpr double kBand_m = 1e-3, kCompliance = 1e-7;

Environment around(const Solid& shape) {
  Environment environment;
  environment.compliance_m_per_N = kCompliance;
  EnvironmentBody body;
  body.shape = shape;
  body.friction = 0.5;
  environment.bodies.push_back(body);
  return environment;
}

Isometry3d at(const Vector3d& place_m) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = place_m;
  return X;
}

// A circle on a face is 32 contacts at one place. What one of them remembers is not for the others: friction would be
// there as often as it is taken over.
TEST(EnvironmentContacts, AForceIsTakenOverByTheNearestContactAlone) {
  const Environment table = around(HalfSpace{});
  EnvironmentContacts contacts(table, CylinderShape{10e-3, 20e-3});
  const Isometry3d X = at({0.0, 0.0, 10e-3});
  find_environment_contacts(table, X, 0.0, 1e-3, kBand_m, {}, contacts);
  ASSERT_EQ(contacts.found.size(), 32U);
  EnvironmentForce force;
  force.place = contacts.found[5].at.place;
  force.p_E = contacts.found[5].at.p_m + Vector3d(0.2e-3, 0.1e-3, 0.0);
  force.n_E = Vector3d::UnitZ();
  force.f_E = Vector3d(0.1, 0.2, 1.0);
  find_environment_contacts(table, X, 0.0, 1e-3, kBand_m, {force}, contacts);
  for (std::size_t i = 0; i < contacts.found.size(); ++i) {
    const double friction_N = contacts.found[i].sheared_m.norm() / kCompliance;
    EXPECT_NEAR(friction_N, i == 5 ? std::hypot(0.1, 0.2) : 0.0, 1e-12) << i;
  }
  // Too far along the circle it is that of another contact.
  force.p_E = contacts.found[5].at.p_m + Vector3d(0.0, 0.0, 6e-3);
  find_environment_contacts(table, X, 0.0, 1e-3, kBand_m, {force}, contacts);
  for (const EnvironmentContact& contact : contacts.found) EXPECT_TRUE(contact.sheared_m.isZero(0.0));
}

// What springs held goes with their contacts: c f^2 / 2 of each.
TEST(EnvironmentContacts, TellWhatDroppedOnesHeld) {
  const Environment table = around(HalfSpace{});
  EnvironmentContacts contacts(table, BoxShape{{10e-3, 10e-3, 10e-3}});
  find_environment_contacts(table, at({0.0, 0.0, 5e-3}), 0.0, 1e-3, kBand_m, {}, contacts);
  ASSERT_EQ(contacts.found.size(), 4U);
  const std::vector<Vector3d> f(4, Vector3d(2.0, 0.3, 0.4));
  std::vector<EnvironmentForce> forces;
  keep_forces(contacts, f, forces);
  find_environment_contacts(table, at({0.0, 0.0, 5e-3}), 0.0, 1e-3, kBand_m, forces, contacts);
  EXPECT_EQ(contacts.dropped_J, 0.0);
  find_environment_contacts(table, at({0.0, 0.0, 50e-3}), 0.0, 1e-3, kBand_m, forces, contacts);
  EXPECT_NEAR(contacts.dropped_J, 4.0 * 0.5 * kCompliance * f[0].squaredNorm(), 1e-20);
  EXPECT_EQ(environment_work(table, contacts, {}, Motion::Zero()).dropped_J, contacts.dropped_J);
}

// Who does not look again trusts this bound.
TEST(EnvironmentContacts, StraightLinesMissNoMoreThanTheySay) {
  std::mt19937 random(6);
  std::normal_distribution<double> unit;
  const auto vector = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
  const std::vector<std::pair<Solid, Solid>> pairs{{BoxShape{{30e-3, 40e-3, 50e-3}}, SphereShape{5e-3}},
                                                   {SphereShape{5e-3}, BoxShape{{30e-3, 40e-3, 50e-3}}},
                                                   {CylinderShape{10e-3, 40e-3}, SphereShape{30e-3}},
                                                   {SphereShape{12e-3}, HalfSpace{}},
                                                   {SphereShape{12e-3}, SphereShape{1e-3}}};
  int near_bound = 0;
  for (const auto& [a, b] : pairs) {
    const Environment environment = around(b);
    EnvironmentContacts before(environment, a), after(environment, a);
    for (int trial = 0; trial < 400; ++trial) {
      Isometry3d X = at(15e-3 * vector());
      X.linear() = Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized().matrix();
      find_environment_contacts(environment, X, 0.0, 1e-3, 1.0, {}, before);
      if (before.found.empty()) continue;
      X.translation() -= (before.found[0].at.gap_m - 0.1e-3 * unit(random)) * before.found[0].at.n;  // In touch.
      find_environment_contacts(environment, X, 0.0, 1e-3, kBand_m, {}, before);
      // A centre within the other has several sides that are equally near.
      if (before.found.empty() || !std::isfinite(before.found[0].at.bend_per_m) || before.found[0].at.gap_m < -0.5e-3) {
        continue;
      }
      Motion x;
      x << 20e-6 * vector(), 2e-3 * vector();
      find_environment_contacts(environment, moved(X, x), 0.0, 1e-3, 2.0 * kBand_m, {}, after);
      ASSERT_EQ(after.found.size(), 1U);
      const double expected_m = before.contacts[0].delta_free[0] + before.contacts[0].J.row(0).dot(x);
      const double missed_m = std::abs(after.found[0].at.gap_m - expected_m), bound_m = may_miss_m(before, x);
      EXPECT_LE(missed_m, bound_m + 1e-12) << "trial " << trial << ", seed 6";
      near_bound += missed_m > 0.02 * bound_m;
    }
  }
  EXPECT_GT(near_bound, 100);  // It says something.
}

// Edges that cross are contacts however deep, and far edges none.
TEST(RoomFor, APlankThatIsPressedIntoABeamHasNone) {
  const Environment beam = around(BoxShape{{20e-3, 100e-3, 10e-3}});
  const BoxShape plank{{100e-3, 20e-3, 10e-3}};
  EXPECT_FALSE(find_overlap(beam, plank, at({0.0, 0.0, 10e-3})));
  const auto overlap = find_overlap(beam, plank, at({0.0, 0.0, 9.5e-3}));
  ASSERT_TRUE(overlap);
  EXPECT_NEAR(overlap->depth_m, 0.5e-3, 1e-12);
  EXPECT_FALSE(overlap->against);
}

}  // namespace
}  // namespace thenar::environment_contacts_test
