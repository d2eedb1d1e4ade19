// SPDX-License-Identifier: Apache-2.0
#include "solvers/dual_active_set.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <limits>
#include <random>

#include "tests/support/allocation_counter.h"

namespace thenar::dual_active_set_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kSize = 12;
using Set = ActiveSet<kSize>;

/// min 1/2 |x - x0|^2, Q x = w, A x >= b, with at most three nonzeros in a row of A.
struct Polyhedron {
  MatrixXd Q, A;
  VectorXd x0, w, b;

  // What the projection asks of its constraints.
  [[nodiscard]] Constraint<3> most_violated(const Set::Vector& x, double) const {
    Constraint<3> worst;
    worst.slack = std::numeric_limits<double>::max();
    for (Index j = 0; j < A.rows(); ++j) {
      const double slack = A.row(j).dot(x.head(A.cols()).matrix()) - b[j];
      if (slack >= worst.slack) continue;
      worst = {static_cast<int>(j), slack, {}, {}};
      int k = 0;
      for (Index i = 0; i < A.cols(); ++i) {
        if (A(j, i) == 0.0) continue;
        worst.index[k] = static_cast<int>(i);
        worst.value[k++] = A(j, i);
      }
    }
    return worst;
  }
};

struct Solution {
  ActiveSetReport report;
  VectorXd x;
  VectorXd u;  ///< A multiplier a row of A.
};

Solution solve(const Polyhedron& p) {
  Set set;
  set.equalities = static_cast<int>(p.Q.rows());
  for (int i = 0; i < set.equalities; ++i) {
    set.basis[i].setZero();
    set.basis[i].head(p.Q.cols()) = p.Q.row(i).transpose().array();
  }
  Set::Vector x = Set::Vector::Zero();
  x.head(p.x0.size()) = p.x0 + p.Q.transpose() * (p.w - p.Q * p.x0);
  Solution solution{project(p, set, x), x.head(p.x0.size()), VectorXd::Zero(p.A.rows())};
  EXPECT_TRUE((x.tail(kSize - p.x0.size()) == 0.0).all());
  for (int j = 0; j < set.active; ++j) solution.u[set.id[j]] += set.multiplier[j];
  return solution;
}

/// The best multipliers l of Q x = w leave this of a gradient.
VectorXd without_span(const MatrixXd& Q, const VectorXd& gradient) { return gradient - Q.transpose() * (Q * gradient); }

/// Karush-Kuhn-Tucker, to `tolerance` of what x and the multipliers are made of.
void expect_optimal(const Polyhedron& p, const Solution& s, double tolerance) {
  const double size = 1.0 + s.x.norm() + p.x0.norm() + (p.A.transpose() * s.u.asDiagonal()).norm();
  const VectorXd slack = p.A * s.x - p.b;
  EXPECT_LE((p.Q * s.x - p.w).norm(), tolerance * size);
  EXPECT_GE(slack.minCoeff(), -tolerance * size);
  EXPECT_GE(s.u.minCoeff(), 0.0);
  EXPECT_LE(without_span(p.Q, s.x - p.x0 - p.A.transpose() * s.u).norm(), tolerance * size);
  EXPECT_LE(slack.dot(s.u), tolerance * size * size);
}

/// Farkas: u >= 0 with A'u = Q'l, and u.b > l.w: no x has both Q x = w and A x >= b.
void expect_infeasible(const Polyhedron& p, const Solution& s) {
  const VectorXd a = p.A.transpose() * s.u;
  EXPECT_GE(s.u.minCoeff(), 0.0);
  // Far above rounding of the combination (1e-16, amplified by rows that nearly coincide), far below its terms.
  EXPECT_LE(without_span(p.Q, a).norm(), 1e-9 * s.u.sum());
  EXPECT_GT(s.u.dot(p.b), (p.Q * a).dot(p.w));
}

/// Expects one of both answers, with its proof.
void expect_proved(const Polyhedron& p, const Solution& s, double tolerance) {
  ASSERT_NE(s.report.status, ActiveSetStatus::kBudgetSpent);
  if (s.report.status == ActiveSetStatus::kOptimal) {
    expect_optimal(p, s, tolerance);
  } else {
    expect_infeasible(p, s);
  }
}

/// Entries from `draw`; some columns of padding, some equalities, some constraints.
template <class Draw>
Polyhedron random_polyhedron(std::mt19937& random, Draw draw) {
  const Index n = 3 + random() % (kSize - 2);
  const Index equalities = random() % (n - 1);
  const Index constraints = 1 + random() % (2 * n);
  Polyhedron p;
  p.Q = MatrixXd(equalities, n);
  if (equalities > 0) {
    std::normal_distribution<double> normal;
    const MatrixXd rows = MatrixXd::NullaryExpr(n, equalities, [&] { return normal(random); });
    p.Q = (rows.householderQr().householderQ() * MatrixXd::Identity(n, equalities)).transpose();
  }
  p.A = MatrixXd::Zero(constraints, n);
  for (Index j = 0; j < constraints; ++j) {
    for (int k = 0; k < 3; ++k) p.A(j, random() % n) = draw();
    p.A(j, random() % n) = 1.0;
    if ((p.A.row(j).array() != 0.0).count() > 3) p.A.row(j).setUnit(j % n);
  }
  p.x0 = VectorXd::NullaryExpr(n, draw);
  p.w = VectorXd::NullaryExpr(equalities, draw);
  p.b = VectorXd::NullaryExpr(constraints, [&] { return draw() - 0.5; });
  return p;
}

// A dozen changes on rows of order 1 amplify rounding by less than 1e4: 1e-12. A wrong set is off by order 1.
TEST(DualActiveSet, EveryAnswerIsProved) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const Polyhedron p = random_polyhedron(random, [&] { return normal(random); });
    const Solution s = solve(p);
    expect_proved(p, s, 1e-12);
    infeasible += s.report.status == ActiveSetStatus::kInfeasible ? 1 : 0;
  }
  EXPECT_GT(infeasible, 300);
  EXPECT_LT(infeasible, 2700);
}

// Whole numbers: many constraints through one vertex, parallel, opposite or equal ones.
TEST(DualActiveSet, EveryAnswerIsProvedOnDegenerateProblems) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Polyhedron p = random_polyhedron(random, [&] { return static_cast<double>(random() % 3) - 1.0; });
    const Solution s = solve(p);
    expect_proved(p, s, 1e-12);
    infeasible += s.report.status == ActiveSetStatus::kInfeasible ? 1 : 0;
  }
  EXPECT_GT(infeasible, 300);
  EXPECT_LT(infeasible, 2700);
}

// Pairs of faces that nearly coincide, as those of a pyramid of little friction, and such that do: multipliers grow
// like 1/mu, and the errors with them (1e-13 of the multipliers' size, see expect_optimal).
TEST(DualActiveSet, ThinWedges) {
  for (const double mu : {1e-3, 1e-6, 0.0}) {
    for (unsigned seed = 0; seed < 1000; ++seed) {
      SCOPED_TRACE(testing::Message() << mu << ", seed " << seed);
      std::mt19937 random(seed);
      std::normal_distribution<double> normal;
      Polyhedron p = random_polyhedron(random, [&] { return normal(random); });
      const Index n = p.x0.size();
      p.A = MatrixXd::Zero(2 * (n / 2), n);
      p.b = VectorXd::Zero(2 * (n / 2));
      for (Index i = 0; i < n / 2; ++i) {
        p.A(2 * i, 2 * i) = p.A(2 * i + 1, 2 * i) = mu;
        p.A(2 * i, 2 * i + 1) = 1.0;
        p.A(2 * i + 1, 2 * i + 1) = -1.0;
      }
      const Solution s = solve(p);
      expect_proved(p, s, 1e-11);
    }
  }
}

TEST(DualActiveSet, ByHand) {
  // The corner (1, 1) of x >= 1, y >= 1 is nearest to the origin; x + y >= 1 has slack there.
  Polyhedron p;
  p.Q = MatrixXd(0, 2);
  p.w = VectorXd(0);
  p.x0 = VectorXd::Zero(2);
  p.A = (MatrixXd(3, 2) << 1, 0, 0, 1, 1, 1).finished();
  p.b = VectorXd::Ones(3);
  const Solution corner = solve(p);
  ASSERT_EQ(corner.report.status, ActiveSetStatus::kOptimal);
  EXPECT_EQ(corner.x, Eigen::Vector2d(1.0, 1.0));
  EXPECT_EQ(corner.u, Eigen::Vector3d(1.0, 1.0, 0.0));

  // Without constraints that are violated nothing changes.
  p.x0 << 2.0, 3.0;
  const Solution inside = solve(p);
  EXPECT_EQ(inside.report.changes, 0);
  EXPECT_EQ(inside.x, p.x0);

  // x >= 1 and -x >= 1.
  p.A = (MatrixXd(2, 2) << 1, 0, -1, 0).finished();
  p.b = VectorXd::Ones(2);
  const Solution none = solve(p);
  ASSERT_EQ(none.report.status, ActiveSetStatus::kInfeasible);
  EXPECT_EQ(none.u[0], none.u[1]);
}

TEST(DualActiveSet, NotFiniteSlackIsNoAnswer) {
  Polyhedron p;
  p.Q = MatrixXd(0, 2);
  p.w = VectorXd(0);
  p.x0 = VectorXd::Zero(2);
  p.A = MatrixXd::Identity(2, 2);
  p.b = VectorXd::Constant(2, std::numeric_limits<double>::infinity());
  EXPECT_EQ(solve(p).report.status, ActiveSetStatus::kBudgetSpent);
}

}  // namespace
}  // namespace thenar::dual_active_set_test
