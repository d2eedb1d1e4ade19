// SPDX-License-Identifier: Apache-2.0
#include "solvers/grouped_delassus.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "bench/cases/factored_contacts.h"
#include "solvers/gauss_seidel.h"
#include "solvers/residual.h"
#include "tests/support/allocation_counter.h"

namespace thenar::grouped_delassus_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index cols, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

/// A half space with forces at random points of the unit disk, kappa = 1; with room for one more.
SurfaceCompliance half_space(Index contacts, std::mt19937& random) {
  SurfaceCompliance C(contacts + 1);
  const double s = 0.3;
  C.p_m.topLeftCorner(contacts, 2) = random_matrix(contacts, 2, random);
  for (Index j = 0; j < contacts; ++j) {
    C.set_column(j, contacts, [&](Index i) -> SurfaceCompliance::Entry {
      const double rho = std::hypot((C.p_m.row(i) - C.p_m.row(j)).norm(), s), k = 3e-6 / rho;
      return {k, k * s / (rho + s), k / (rho + s) / (rho + s)};
    });
  }
  return C;
}

/// Fingers of these numbers of contacts on one object.
struct RandomGroups : FactoredContacts {
  RandomGroups(const std::vector<Index>& sizes, bool compliant, std::mt19937& random, bool soft = false,
               bool fifth = false) {
    for (const Index size : sizes) begin.push_back(begin.back() + size);
    const Index n = begin.back();
    // More rows than the contacts have, as a workspace of some capacity holds them.
    J_own = random_matrix(3 * n + 6, GroupedDelassus::kOwn, random);
    if (fifth) J_fifth = random_matrix(3 * n + 6, 1, random);
    J_common.setZero(3 * n + 6, GroupedDelassus::kPadded);
    J_common.leftCols<6>() = random_matrix(3 * n + 6, 6, random);
    if (compliant) {
      for (const Index size : sizes) compliance.push_back(half_space(size, random));
      axes.resize(3 * n + 6, 3);
      for (Index i = 0; i < n + 2; ++i) {
        axes.middleRows<3>(3 * i) =
            MatrixXd(random_matrix(3, 3, random)).householderQr().householderQ() * Eigen::Matrix3d::Identity();
      }
    }
    if (soft) {
      common_k = half_space(n, random).k;  // With room for one more, as a frame has it.
      common_T = random_matrix(3 * n + 6, 3, random);
      common_scale = 0.4;
    }
    own_mobility = 2e-6;
    common_mobility << 1e-6, 1e-6, 1e-6, 3e-6, 3e-6, 3e-6, 0.0, 0.0;
    compliance_scale = 0.7;
    delta_free = 1e-5 * random_matrix(3 * n, 1, random);
    mu = 0.5 * random_matrix(n, 1, random).cwiseAbs();
  }

  [[nodiscard]] Index contacts() const { return mu.size(); }
  [[nodiscard]] bool soft() const { return common_k.size() > 0; }
  [[nodiscard]] GroupedWorkspace workspace() const { return {contacts(), std::ssize(begin) - 1, soft()}; }
  operator GroupedContactProblem() const { return problem(delta_free, mu); }

  VectorXd delta_free, mu;
};

const std::vector<std::vector<Index>> kSizes{{4, 3, 5}, {1}, {0, 6, 0, 2}, {7, 7}, {20, 20, 20}};

// The forces solve the problem whose W is written out, the gaps are theirs, and the bodies have moved as they say.
TEST(GroupedDelassus, SolvesTheProblemThatItsFactorsMake) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const RandomGroups problem(kSizes[seed % kSizes.size()], true, random, seed >= 20, seed % 2 == 1);
    const Index n = problem.contacts();
    const GroupedDelassus W = problem.operator_of();
    const ContactData dense{problem.dense(), problem.delta_free, problem.mu};
    GroupedWorkspace work = problem.workspace();
    for (const double tolerance : {1e-4, 1e-10}) {
      VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
      const SolveReport report = solve_contacts(problem, {tolerance, 2000}, work, {f, delta});
      ASSERT_EQ(report.status, SolveStatus::kConverged);
      // W f is summed in another order, and rho comes from W_ii in single precision: 1e-7 of the residual.
      const VectorXd expected_delta = dense.W * f + problem.delta_free;
      EXPECT_LE((delta - expected_delta).norm(), 1e-13 * (problem.delta_free.norm() + dense.W.norm() * f.norm()));
      const Residual residual = natural_map(dense, f, expected_delta);
      EXPECT_LE(residual.norm, 1.001 * tolerance + 1e-13);
      EXPECT_NEAR(residual.norm, report.residual, 1e-3 * report.residual + 1e-13);
      EXPECT_NEAR(residual.worst, report.residual_worst, 1e-3 * report.residual + 1e-13);

      const auto J_common = problem.J_common.topRows(3 * n);
      const GroupedDelassus::CommonMotion common = problem.common_mobility.cwiseProduct(J_common.transpose() * f);
      EXPECT_LE((work.common_motion - common).norm(), 1e-13 * (1e-6 + f.norm()) * J_common.norm());
      for (Index k = 0; k < W.groups(); ++k) {
        const Index first = 3 * W.begin[k], rows = 3 * W.begin[k + 1] - first;
        const VectorXd own =
            W.own_mobility * problem.J_own.middleRows(first, rows).transpose() * f.segment(first, rows);
        EXPECT_LE((work.own_motion.col(k).head<4>() - own).norm(), 1e-13 * (1e-6 + f.norm()) * problem.J_own.norm());
        const double fifth = seed % 2 == 1 ? problem.J_fifth.segment(first, rows).dot(f.segment(first, rows)) : 0.0;
        EXPECT_NEAR(work.own_motion(4, k), W.own_mobility * fifth, 1e-13 * (1e-6 + f.norm()) * problem.J_own.norm());
      }
    }
  }
}

// A fifth freedom of the groups' bodies adds its own products to W, group by group, and to the blocks that sweeps
// see: 1e-6 of single precision.
TEST(GroupedDelassus, AFifthFreedomIsAColumnMore) {
  std::mt19937 random(2);
  RandomGroups problem({4, 0, 5}, true, random, false, true);
  const Index n = problem.contacts();
  GroupedWorkspace work = problem.workspace();
  VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
  ASSERT_EQ(solve_contacts(problem, {1e-8, 2000}, work, {f, delta}).status, SolveStatus::kConverged);
  const MatrixXd with = problem.dense();
  const VectorXd column = std::exchange(problem.J_fifth, VectorXd()).head(3 * n);
  MatrixXd added = with - problem.dense();
  for (const auto& group : work.sweeps.groups) {
    const Index first = 3 * group.begin, rows = 3 * (group.end - group.begin);
    const auto own = column.segment(first, rows);
    added.block(first, first, rows, rows) -= problem.own_mobility * own * own.transpose();
    const MatrixXd block = work.sweeps.block(group).topRows(rows).cast<double>();
    EXPECT_LE((block - with.block(first, first, rows, rows)).norm(), 1e-6 * with.norm());
  }
  EXPECT_LE(added.norm(), 1e-14 * with.norm());
}

// C of the header stands in W's diagonal blocks, times s: W with it less W without. The surface motion is its product
// with forces. Rounding.
TEST(GroupedDelassus, ComplianceIsTheOneOfTheHeader) {
  std::mt19937 random(1);
  RandomGroups problem({4, 3, 5}, true, random);
  const Index n = problem.contacts();
  const MatrixXd with = problem.dense();
  const std::vector<SurfaceCompliance> compliance = std::exchange(problem.compliance, {});
  const MatrixXd without = problem.dense();
  const Eigen::Matrix3d D = Eigen::Vector3d(0.0, 1.0, 1.0).asDiagonal();
  for (Index k = 0; k < std::ssize(compliance); ++k) {
    const SurfaceCompliance& C = compliance[k];
    const Index begin = problem.begin[k], end = problem.begin[k + 1];
    for (Index i = begin; i < end; ++i) {
      for (Index j = 0; j < n; ++j) {
        Eigen::Matrix3d C_ij = Eigen::Matrix3d::Zero();
        if (j >= begin && j < end) {
          const Eigen::Matrix3d A_i = problem.axes.middleRows<3>(3 * i), A_j = problem.axes.middleRows<3>(3 * j);
          const Eigen::Vector3d r = C.p_m.row(i - begin) - C.p_m.row(j - begin);
          const Eigen::Matrix3d across =
              C.a(i - begin, j - begin) * Eigen::Matrix3d::Identity() + C.b(i - begin, j - begin) * r * r.transpose();
          C_ij = 0.7 * (C.k(i - begin, j - begin) * A_i * A_j.transpose() + D * A_i * across * A_j.transpose() * D);
        }
        const Eigen::Matrix3d found = (with - without).block<3, 3>(3 * i, 3 * j);
        EXPECT_LE((found - C_ij).norm(), 1e-14 * with.norm());
      }
    }
  }
  VectorXd f = random_matrix(3 * n, 1, random);
  for (Index i = 0; i < n; ++i) f[3 * i] = std::abs(f[3 * i]);
  f.segment<3>(3).setZero();  // one that bears nothing
  problem.compliance = compliance;
  GroupedWorkspace work(n, std::ssize(compliance));
  find_motion(problem.operator_of(), f, work);
  const VectorXd expected = (with - without) * f;
  EXPECT_LE((work.surface_motion.head(3 * n) - expected).norm(), 1e-14 * expected.norm());
}

// The same of the common body: C stands among all contacts. Rounding.
TEST(GroupedDelassus, SharedComplianceIsTheOneOfTheHeader) {
  std::mt19937 random(1);
  RandomGroups problem({4, 3, 5}, true, random, true);
  const Index n = problem.contacts();
  VectorXd f = random_matrix(3 * n, 1, random);
  for (Index i = 0; i < n; ++i) f[3 * i] = std::abs(f[3 * i]);
  f.segment<3>(6).setZero();
  GroupedWorkspace work = problem.workspace();
  find_motion(problem.operator_of(), f, work);
  const MatrixXd with = problem.dense(), k = std::exchange(problem.common_k, {}), C = with - problem.dense();
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const Eigen::Matrix3d expected =
          0.4 * k(i, j) * problem.common_T.middleRows<3>(3 * i) * problem.common_T.middleRows<3>(3 * j).transpose();
      EXPECT_LE((C.block<3, 3>(3 * i, 3 * j) - expected).norm(), 1e-14 * with.norm());
    }
  }
  EXPECT_LE((work.shared_motion.head(3 * n) - C * f).norm(), 1e-14 * with.norm() * f.norm());
}

// The sweeps are the same as those on the dense matrix, but for the order of single-precision sums.
TEST(GroupedDelassus, ConvergesAsTheDenseSweepsDo) {
  int grouped_sweeps = 0, dense_sweeps = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    const RandomGroups problem(kSizes[seed % kSizes.size()], true, random, seed >= 20);
    const Index n = problem.contacts();
    const ContactData dense{problem.dense(), problem.delta_free, problem.mu};
    GroupedWorkspace grouped = problem.workspace();
    SweepWorkspace work(n);
    VectorXd f = VectorXd::Zero(3 * n), g = f, delta(3 * n);
    grouped_sweeps += solve_contacts(problem, {1e-6, 2000}, grouped, {f, delta}).sweeps;
    dense_sweeps += solve_contacts(dense, {1e-6, 2000}, work, {g, delta}).sweeps;
  }
  EXPECT_NEAR(grouped_sweeps, dense_sweeps, 0.1 * dense_sweeps);
}

// Blocks that an edition keeps are those of Jacobians that have changed a little since. They lead to forces that solve
// the problem as it is now, in hardly more sweeps; Jacobians that have changed much, and another edition, get new ones.
TEST(GroupedDelassus, KeptBlocksLeadToTheSolutionOfNow) {
  int kept_sweeps = 0, fresh_sweeps = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    RandomGroups problem(kSizes[seed % kSizes.size()], true, random, seed >= 10);
    const Index n = problem.contacts();
    GroupedWorkspace work = problem.workspace();
    VectorXd f = VectorXd::Zero(3 * n), g = f, delta(3 * n);
    GroupedContactProblem first = problem;
    first.W.edition = 3;
    ASSERT_EQ(solve_contacts(first, {1e-8, 2000}, work, {f, delta}).status, SolveStatus::kConverged);
    const auto blocks = [&] {
      SweepWorkspace& sweeps = work.sweeps;
      std::vector<MatrixXd> copies;
      for (const SweepWorkspace::Group& group : sweeps.groups) copies.push_back(sweeps.block(group).cast<double>());
      return copies;
    };
    for (const double change : {5e-4, 0.3}) {
      problem.J_common.leftCols<6>() += change * random_matrix(problem.J_common.rows(), 6, random);
      problem.J_own += change * random_matrix(problem.J_own.rows(), GroupedDelassus::kOwn, random);
      GroupedContactProblem now = problem;
      now.W.edition = 3;
      f.setZero();
      const auto before = blocks();
      const SolveReport kept = solve_contacts(now, {1e-8, 2000}, work, {f, delta});
      ASSERT_EQ(kept.status, SolveStatus::kConverged);
      // 5e-4 is of a standard deviation; the largest entries of all are at least one, and the changes' three times it.
      EXPECT_EQ(before == blocks(), change < 0.1);
      const ContactData dense{problem.dense(), problem.delta_free, problem.mu};
      // The residual's own scale is that of the kept blocks: as far off as these.
      EXPECT_LE(natural_map(dense, f, dense.W * f + dense.delta_free).norm, 1.01e-8);
      GroupedWorkspace fresh = problem.workspace();
      g.setZero();
      kept_sweeps += kept.sweeps;
      fresh_sweeps += solve_contacts(problem, {1e-8, 2000}, fresh, {g, delta}).sweeps;
    }
  }
  EXPECT_LE(kept_sweeps, 1.2 * fresh_sweeps);
}

// Another edition, another step, and no edition at all: blocks are made of the problem as it is.
TEST(GroupedDelassus, BlocksAreOfOneEditionAndStep) {
  std::mt19937 random(1);
  const RandomGroups problem({6, 5, 4}, true, random);
  const Index n = problem.contacts();
  GroupedWorkspace work = problem.workspace();
  VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
  const auto made_anew = [&](std::int64_t edition, double scale) {
    GroupedContactProblem now = problem;
    now.W.edition = edition;
    now.W.compliance_scale = scale;
    work.sweeps.blocks[0] *= 2.0F;
    const float spoilt = work.sweeps.blocks[0];
    (void)solve_contacts(now, {1e-6, 100}, work, {f, delta});
    return work.sweeps.blocks[0] != spoilt;
  };
  EXPECT_TRUE(made_anew(3, 0.7));
  EXPECT_FALSE(made_anew(3, 0.7));
  EXPECT_TRUE(made_anew(4, 0.7));
  EXPECT_TRUE(made_anew(4, 0.3));
  EXPECT_TRUE(made_anew(-1, 0.3));
  EXPECT_TRUE(made_anew(-1, 0.3));
}

/// Solves problems of the same contacts that change a little from one to the next, each from the last one's forces, and
/// from what was learned where `keeps`. Returns the sweeps.
int sweeps_along(unsigned seed, bool keeps) {
  std::mt19937 random(seed);
  RandomGroups problem(kSizes[seed % kSizes.size()], true, random, seed >= 10);
  const Index n = problem.contacts();
  GroupedWorkspace work = problem.workspace();
  VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
  const MatrixXd way = 1e-7 * random_matrix(3 * n, 1, random);
  int sweeps = 0;
  for (int tick = 0; tick < 20; ++tick) {
    problem.delta_free += way;
    problem.J_own += 1e-5 * random_matrix(problem.J_own.rows(), GroupedDelassus::kOwn, random);
    GroupedContactProblem now = problem;
    if (keeps) now.W.list = 7;
    const SolveReport report = solve_contacts(now, {1e-8, 2000}, work, {f, delta});
    EXPECT_EQ(report.status, SolveStatus::kConverged);
    const ContactData dense{problem.dense(), problem.delta_free, problem.mu};
    EXPECT_LE(natural_map(dense, f, dense.W * f + dense.delta_free).norm, 1.01e-8);
    if (tick > 0) sweeps += report.sweeps;
  }
  return sweeps;
}

// What the last sweeps have learned of the same contacts is no part of the result: the residual is that of the problem
// as it is, written out. Here active laws change in each step, so that nothing is gained by it; nor lost, within 5 %.
TEST(GroupedDelassus, WhatSweepsLearnedIsNoPartOfTheResult) {
  int kept = 0, anew = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    kept += sweeps_along(seed, true);
    anew += sweeps_along(seed, false);
  }
  EXPECT_LE(kept, 1.05 * anew) << kept << " and " << anew;
}

// Nothing is learned for other contacts, nor where a solve was not finite: then sweeps do to the last bit what they
// would do at first.
TEST(GroupedDelassus, SweepsLearnNothingOfOtherContacts) {
  for (const bool fails : {false, true}) {
    SCOPED_TRACE(fails);
    std::mt19937 random(3);
    const RandomGroups problem({6, 5, 4}, true, random), other({6, 5, 4}, true, random);
    const Index n = problem.contacts();
    GroupedWorkspace work = problem.workspace(), fresh = problem.workspace();
    VectorXd f = VectorXd::Zero(3 * n), g = f, delta(3 * n);
    const auto solve_first = [&](const RandomGroups& of) {
      GroupedContactProblem first = of;
      first.W.list = 1;
      return solve_contacts(first, {1e-8, 2000}, work, {f, delta}).status;
    };
    ASSERT_EQ(solve_first(other), SolveStatus::kConverged);
    if (fails) {
      RandomGroups broken = other;
      broken.delta_free[4] = std::numeric_limits<double>::quiet_NaN();
      ASSERT_EQ(solve_first(broken), SolveStatus::kNotFinite);
    }
    GroupedContactProblem now = problem;
    now.W.list = fails ? 1 : 2;
    f.setZero();
    const SolveReport report = solve_contacts(now, {1e-8, 2000}, work, {f, delta});
    EXPECT_EQ(solve_contacts(problem, {1e-8, 2000}, fresh, {g, delta}).sweeps, report.sweeps);
    EXPECT_EQ(f, g);
  }
}

// Rigid fingertips: 10 freedoms a group for up to 60 rows. Forces are not unique, the residual tells.
TEST(GroupedDelassus, NeedsNoCompliance) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    RandomGroups problem({3, 2, 3}, false, random);
    problem.mu.setConstant(0.5);
    const Index n = problem.contacts();
    const ContactData dense{problem.dense(), problem.delta_free, problem.mu};
    GroupedWorkspace work(n, 3);
    VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
    const SolveReport report = solve_contacts(problem, {1e-8, 500}, work, {f, delta});
    const double residual = natural_map(dense, f, dense.W * f + dense.delta_free).norm;
    EXPECT_NEAR(residual, report.residual, 1e-3 * report.residual + 1e-12);
  }
}

TEST(GroupedDelassus, NotFiniteInputGivesZeros) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::mt19937 random(1);
  const RandomGroups good({3, 3, 3}, true, random, true);
  GroupedWorkspace work = good.workspace();
  // Within an edition, too: what was kept is no excuse.
  const auto expect_refused = [&](const RandomGroups& problem) {
    VectorXd f = VectorXd::Zero(27), delta(27);
    GroupedContactProblem now = problem;
    (void)solve_contacts(good, {1e-6, 100}, work, {f, delta});
    now.W.edition = work.edition = 5;
    f.setZero();
    const SolveReport report = solve_contacts(now, {1e-6, 100}, work, {f, delta});
    EXPECT_EQ(report.status, SolveStatus::kNotFinite);
    EXPECT_TRUE(f.isZero(0.0) && delta.isZero(0.0));
    EXPECT_TRUE(work.own_motion.isZero(0.0) && work.common_motion.isZero(0.0));
    EXPECT_TRUE(std::isinf(report.residual) && std::isinf(report.residual_worst));
  };
  RandomGroups problem = good;
  problem.J_own(4, 1) = nan;
  expect_refused(problem);
  problem = good;
  problem.J_common(20, 3) = std::numeric_limits<double>::infinity();
  expect_refused(problem);
  problem = good;
  problem.compliance[1].set_column(0, 1, [&](Index) -> SurfaceCompliance::Entry { return {nan, 0.0, 0.0}; });
  expect_refused(problem);
  problem = good;
  problem.axes(7, 2) = nan;
  expect_refused(problem);
  problem = good;
  problem.common_k(4, 4) = nan;
  expect_refused(problem);
  problem = good;
  problem.common_T(8, 1) = nan;
  expect_refused(problem);
  problem = good;
  problem.delta_free[5] = nan;
  expect_refused(problem);
  problem = good;
  problem.mu[2] = nan;
  expect_refused(problem);
}

TEST(GroupedDelassus, SameProblemSameBitsWhateverTheWorkspaceHeld) {
  std::mt19937 random(1);
  const RandomGroups problem({6, 5, 4}, true, random, true), other({15, 1, 9}, true, random);
  GroupedWorkspace work(30, 4, true);
  const auto run = [&](const RandomGroups& p) {
    VectorXd f = VectorXd::Zero(3 * p.contacts()), delta(f.size());
    (void)solve_contacts(p, {1e-7, 500}, work, {f, delta});
    return f;
  };
  const VectorXd first = run(problem);
  (void)run(other);
  EXPECT_EQ(run(problem), first);
}

TEST(GroupedDelassus, DoesNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  std::mt19937 random(1);
  for (const auto& sizes : kSizes) {
    for (const bool soft : {false, true}) {
      const RandomGroups problem(sizes, true, random, soft);
      GroupedWorkspace work = problem.workspace();
      VectorXd f = VectorXd::Zero(3 * problem.contacts()), delta(f.size());
      const AllocationCounter counter;
      (void)solve_contacts(problem, {1e-8, 500}, work, {f, delta});
      EXPECT_EQ(counter.count(), 0);
    }
  }
}

}  // namespace
}  // namespace thenar::grouped_delassus_test
