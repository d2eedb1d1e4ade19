// SPDX-License-Identifier: Apache-2.0
#include "solvers/ground_contacts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "bench/cases/factored_contacts.h"
#include "solvers/contact_newton.h"
#include "solvers/grouped_delassus.h"
#include "solvers/residual.h"
#include "tests/support/allocation_counter.h"

namespace thenar::ground_contacts_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Motion = GroundProblem::Motion;

MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

/// A body of some centimetres on a ground whose normals are `spread` off one direction.
struct RandomGround {
  RandomGround(Index contacts, double spread, std::mt19937& random) {
    for (Index i = 0; i < contacts; ++i) {
      const Vector3d n = (Vector3d::UnitZ() + spread * random_matrix(3, 1, random)).normalized();
      const Vector3d t1 = n.unitOrthogonal(), r = 0.02 * random_matrix(3, 1, random);
      Eigen::Matrix3d E, r_cross;
      E << n, t1, n.cross(t1);
      r_cross << 0.0, -r[2], r[1], r[2], 0.0, -r[0], -r[1], r[0], 0.0;
      GroundContact contact;
      contact.J << E.transpose(), -E.transpose() * r_cross;
      contact.delta_free = 1e-5 * Vector3d(0.3, 0.1, 0.1).cwiseProduct(Vector3d(random_matrix(3, 1, random)));
      contact.mu = std::min(0.6, std::abs(random_matrix(1, 1, random)(0)));
      all.push_back(contact);
    }
    mobility << 1e-4, 1e-4, 1e-4, 0.2, 0.2, 0.2;
  }

  [[nodiscard]] GroundProblem problem() const { return {all, compliance, mobility}; }
  /// J of all contacts.
  [[nodiscard]] MatrixXd jacobian() const {
    MatrixXd J(3 * std::ssize(all), 6);
    for (std::size_t i = 0; i < all.size(); ++i) J.middleRows<3>(3 * static_cast<Index>(i)) = all[i].J;
    return J;
  }

  std::vector<GroundContact> all;
  Motion mobility;
  double compliance = 1e-7;
};

VectorXd stacked(const std::vector<Vector3d>& f, std::size_t contacts) {
  VectorXd all(3 * static_cast<Index>(contacts));
  for (std::size_t i = 0; i < contacts; ++i) all.segment<3>(3 * static_cast<Index>(i)) = f[i];
  return all;
}

/// The same problem with W written out.
ContactData dense(const RandomGround& ground, const Motion& x_free) {
  const MatrixXd J = ground.jacobian();
  ContactData data;
  data.W = J * ground.mobility.asDiagonal() * J.transpose();
  data.W.diagonal().array() += ground.compliance;
  data.delta_free = J * x_free;
  data.mu.resize(std::ssize(ground.all));
  for (std::size_t i = 0; i < ground.all.size(); ++i) {
    data.delta_free.segment<3>(3 * static_cast<Index>(i)) += ground.all[i].delta_free;
    data.mu[static_cast<Index>(i)] = ground.all[i].mu;
  }
  return data;
}

Motion pressed_down(std::mt19937& random) {
  Motion x = Motion::Zero();
  x << 3e-5 * random_matrix(3, 1, random), 1e-3 * random_matrix(3, 1, random);
  x[2] -= 1e-4;
  return x;
}

// Six equations hold all the laws: what they find has no residual in the problem of 3n rows. Some problems with
// friction have no way from a soft ground to theirs, or none that is found: that is told, and happens to one of a
// hundred. Runs begin with the last tick's motion, and then take a step or two; these begin with none.
TEST(GroundContacts, SolveTheProblemOfAllTheirRows) {
  int steps = 0, unsolved = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const RandomGround ground(1 + static_cast<Index>(seed % 20), 0.15, random);
    const Motion x_free = pressed_down(random);
    GroundWorkspace work(20);
    const GroundReport report = solve_ground(ground.problem(), x_free, work);
    steps += report.steps;
    if (report.status != SolveStatus::kConverged) {
      ++unsolved;
      EXPECT_GT(report.missing, 1e-11);
      continue;
    }
    const ContactData data = dense(ground, x_free);
    const VectorXd f = stacked(work.f, ground.all.size());
    // x is so exact that J x / c is to 1e-11 of the forces, and W f by 1e4 less: rows cancel.
    EXPECT_LE(natural_map(data, f, data.W * f + data.delta_free).norm, 1e-6);
    EXPECT_LE((ground.mobility.cwiseProduct(ground.jacobian().transpose() * f) + x_free - work.x).norm(),
              1e-9 * x_free.norm());
  }
  EXPECT_LE(steps, 500 * 60);
  EXPECT_LE(unsolved, 5);
}

// A solver that knows nothing of six freedoms finds the same motion; forces, too, for c decides between them.
TEST(GroundContacts, AgreeWithTheAccurateSolver) {
  int compared = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    RandomGround ground(1 + static_cast<Index>(seed % 8), 0.1, random);
    ground.compliance = 1e-5;                                                          // Soft enough for the other.
    for (GroundContact& contact : ground.all) contact.mu = std::min(contact.mu, 0.3);  // Which has one solution.
    const Motion x_free = pressed_down(random);
    GroundWorkspace work(8);
    ASSERT_EQ(solve_ground(ground.problem(), x_free, work).status, SolveStatus::kConverged);
    const ContactData data = dense(ground, x_free);
    const Index n = std::ssize(ground.all);
    AccurateWorkspace accurate(n);
    VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
    if (solve_contacts_accurately(data, {.tolerance = 1e-12}, accurate, {f, delta}).solve.status !=
        SolveStatus::kConverged) {
      continue;
    }
    ++compared;
    EXPECT_LE((stacked(work.f, ground.all.size()) - f).norm(), 1e-7 * f.norm() + 1e-12);
  }
  EXPECT_GE(compared, 50);
}

TEST(GroundContacts, AGuessThatIsTheSolutionTakesNoStepAndNothingIsAllocated) {
  std::mt19937 random(3);
  const RandomGround ground(12, 0.15, random);
  const Motion x_free = pressed_down(random);
  GroundWorkspace work(12);
  ASSERT_EQ(solve_ground(ground.problem(), x_free, work).status, SolveStatus::kConverged);
  const AllocationCounter allocations;
  EXPECT_EQ(solve_ground(ground.problem(), x_free, work).steps, 0);
  EXPECT_EQ(allocations.count(), 0);
}

TEST(GroundContacts, WhatIsNotFiniteIsTold) {
  std::mt19937 random(4);
  const RandomGround ground(4, 0.1, random);
  Motion x_free = pressed_down(random);
  x_free[1] = std::numeric_limits<double>::quiet_NaN();
  GroundWorkspace work(4);
  EXPECT_EQ(solve_ground(ground.problem(), x_free, work).status, SolveStatus::kNotFinite);
}

/// Points that give way by 1e-4 m/N where they are pressed, and less by forces at others.
SurfaceCompliance pulp(Index contacts, std::mt19937& random) {
  SurfaceCompliance C(contacts);
  C.p_m.topLeftCorner(contacts, 2) = random_matrix(contacts, 2, random);
  for (Index j = 0; j < contacts; ++j) {
    C.set_column(j, contacts, [&](Index i) -> SurfaceCompliance::Entry {
      return {3e-5 / std::hypot((C.p_m.row(i) - C.p_m.row(j)).norm(), 0.3), 0.0, 0.0};
    });
  }
  return C;
}

/// Fingers on a body that stands on a ground.
TEST(GroundContacts, FingersOnABodyOnAGroundSolveTheProblemOfBoth) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    FactoredContacts fingers;
    for (const Index size : {7, 5, 6}) fingers.begin.push_back(fingers.begin.back() + size);
    const Index n = fingers.begin.back();
    const RandomGround ground(1 + static_cast<Index>(seed % 10), 0.1, random);
    fingers.J_own = random_matrix(3 * n, GroupedDelassus::kOwn, random);
    fingers.J_common.setZero(3 * n, GroupedDelassus::kPadded);
    fingers.J_common.leftCols<6>() << random_matrix(3 * n, 3, random), 0.02 * random_matrix(3 * n, 3, random);
    fingers.own_mobility = 1e-4;
    // Pulps, which give way by as much as the bodies move.
    for (Index k = 0; k < 3; ++k) fingers.compliance.push_back(pulp(fingers.begin[k + 1] - fingers.begin[k], random));
    fingers.axes.resize(3 * n, 3);
    for (Index i = 0; i < n; ++i) fingers.axes.middleRows<3>(3 * i).setIdentity();
    fingers.common_mobility << ground.mobility, 0.0, 0.0;
    const Motion x_free = pressed_down(random);
    const VectorXd mu = VectorXd::Constant(n, 0.5);
    const VectorXd apart = 1e-5 * random_matrix(3 * n, 1, random);
    const VectorXd delta_free = apart + fingers.J_common.leftCols<6>() * x_free;
    const CommonGround common{ground.problem(), x_free};

    GroupedWorkspace work(n, 3, false, 10);
    VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
    GroupedContactProblem problem = fingers.problem(delta_free, mu);
    problem.ground = &common;
    const SolveReport report = solve_contacts(problem, {1e-9, 2000}, work, {f, delta});
    EXPECT_EQ(report.status, SolveStatus::kConverged)
        << report.residual << " left after " << report.sweeps << " sweeps";

    // All rows in one: the fingers' W, the ground's, and what they do to one another through the body.
    const ContactData below = dense(ground, x_free);
    const Index m = below.contacts();
    ContactData both;
    const MatrixXd across =
        fingers.J_common.leftCols<6>() * ground.mobility.asDiagonal() * ground.jacobian().transpose();
    both.W.resize(3 * (n + m), 3 * (n + m));
    both.W << fingers.dense(), across, across.transpose(), below.W;
    both.delta_free.resize(3 * (n + m));
    both.delta_free << delta_free, below.delta_free;
    both.mu.resize(n + m);
    both.mu << mu, below.mu;
    VectorXd all(3 * (n + m));
    all << f, stacked(work.ground.f, ground.all.size());
    EXPECT_LE(natural_map(both, all, both.W * all + both.delta_free).norm, 1e-6);
    // The body moves by all of the forces.
    const Motion moved = ground.mobility.cwiseProduct(fingers.J_common.leftCols<6>().transpose() * f +
                                                      ground.jacobian().transpose() * all.tail(3 * m));
    EXPECT_LE((work.common_motion.head<6>() - moved).norm(), 1e-9 * x_free.norm());
    EXPECT_LE((delta - both.W.topRows(3 * n) * all - delta_free).norm(), 1e-9 * delta_free.norm());
  }
}

}  // namespace
}  // namespace thenar::ground_contacts_test
