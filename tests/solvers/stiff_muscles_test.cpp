// SPDX-License-Identifier: Apache-2.0
#include "solvers/muscles/stiff_muscles.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <vector>

#include "bench/cases/random.h"
#include "solvers/muscles/stiff_proof.h"
#include "tests/solvers/stiff_laws.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/json_eigen.h"

namespace thenar::stiff_muscles_test {
namespace {

using namespace stiff_laws;

// ---- Against the reference ----------------------------------------------------------------------------------------

// Drawn here by the same generator. The interior points are good to 1e-11 of the effort.
TEST(StiffMuscles, AgreeWithTheInteriorPoints) {
  int infeasible = 0, bound = 0;
  for (const auto& row : read_json(THENAR_TEST_DATA "/stiff_muscles.json")) {
    SCOPED_TRACE(row.at("seed"));
    StiffDraw draw;
    draw.fingers = row.at("fingers");
    draw.joints = row.at("joints");
    draw.muscles = row.at("muscles");
    draw.has_tendons = row.at("tendons");
    draw.has_squeeze = row.at("squeeze");
    draw.draw(row.at("seed").get<std::uint64_t>());
    draw.want(row.at("theta"));
    const Solution solution = solve(draw.problem);
    if (row.at("status") == "infeasible") {
      expect_infeasible(draw.problem, solution);
      ++infeasible;
      continue;
    }
    expect_optimal(draw.problem, solution);
    const double expected = row.at("effort");
    EXPECT_NEAR(effort(draw.problem, solution), expected, 1e-6 * expected);
    // The problem is strongly convex: f is as near as the root of the error of the effort.
    EXPECT_LE((solution.f - vector_of(row.at("f"))).norm(), 1e-4 * solution.f.norm());
    if (draw.has_squeeze) {
      EXPECT_NEAR(solution.report.squeeze, row.at("s"), 1e-4);
    }
    bound += solution.report.Z.isZero(0.0) ? 0 : 1;
  }
  EXPECT_EQ(infeasible, 40);
  EXPECT_GT(bound, 100);
}

// ---- Properties ---------------------------------------------------------------------------------------------------

TEST(StiffMuscles, EveryAnswerIsProvedAndMoreStiffnessNeverTakesLess) {
  int optimal = 0, infeasible = 0, postures = 0;
  for (std::uint64_t seed = 5000; seed < 5100; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, seed % 2 == 1, seed % 3 == 0);
    if (seed % 4 == 1) draw.problem.kappa = 0.3;  // Postures bind, too.
    double last = 0.0;
    bool was_possible = true;
    for (const double theta : {0.5, 1.0, 2.0, 4.0, 8.0}) {
      SCOPED_TRACE(theta);
      draw.want(theta);
      const Solution solution = solve(draw.problem);
      ASSERT_NE(solution.report.status, MuscleStatus::kBudgetSpent);
      if (solution.report.status == MuscleStatus::kInfeasible) {
        expect_infeasible(draw.problem, solution);
        was_possible = false;
        ++infeasible;
        continue;
      }
      ASSERT_TRUE(was_possible) << "less stiffness was found to be too much";
      expect_optimal(draw.problem, solution);
      EXPECT_GE(effort(draw.problem, solution), last * (1.0 - 1e-9));
      last = effort(draw.problem, solution);
      ++optimal;
      for (int k = 0; k < draw.fingers; ++k) postures += solution.report.Y[k].isZero(0.0) ? 0 : 1;
    }
  }
  EXPECT_GT(optimal, 100);
  EXPECT_GT(infeasible, 50);
  EXPECT_GT(postures, 20);
}

// Forces that are stiff enough as they are have the bits of those without a wish.
TEST(StiffMuscles, WithoutNeedOfStiffnessAreTheLeastForces) {
  int equal = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed);
    draw.want(-1e6);
    draw.problem.kappa = -1e6;
    draw.problem.limit *= 0.2;
    // No finger gives way.
    draw.problem.D += 100.0 * MatrixXd::Identity(12, 12);
    VectorXd f = VectorXd::Zero(23);
    const MuscleReport alone = solve_muscle_forces({draw.problem.H, draw.problem.tau, draw.problem.limit}, f);
    const Solution solution = solve(draw.problem);
    ASSERT_EQ(solution.report.status, alone.status);
    if (alone.status != MuscleStatus::kOptimal) continue;
    EXPECT_EQ(solution.f, f);
    ++equal;
  }
  EXPECT_GT(equal, 25);
}

TEST(StiffMuscles, TheOrderOfMusclesHasNoMeaning) {
  for (std::uint64_t seed = 6000; seed < 6030; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, true);
    draw.want(1.0);
    const Solution first = solve(draw.problem);
    std::vector<Index> order(23);
    std::iota(order.begin(), order.end(), 0);
    Random random(seed);
    for (Index j = 22; j > 0; --j) std::swap(order[j], order[random.whole(0, j)]);
    StiffMuscleData p = draw.problem;
    p.H = draw.problem.H(Eigen::all, order);
    p.arm = draw.problem.arm(Eigen::all, order);
    p.turn = draw.problem.turn(Eigen::all, order);
    p.limit = draw.problem.limit(order);
    p.fibre_per_m = draw.problem.fibre_per_m(order);
    p.tendon_N_per_m = draw.problem.tendon_N_per_m(order);
    const Solution second = solve(p);
    ASSERT_EQ(first.report.status, second.report.status);
    if (first.report.status != MuscleStatus::kOptimal) continue;
    EXPECT_LE((second.f - first.f(order)).norm(), 1e-6 * first.f.norm());
  }
}

// Tendons in series take stiffness away: the same wish takes more effort, and very stiff ones nothing.
TEST(StiffMuscles, TendonsTakeEffort) {
  int compared = 0;
  for (std::uint64_t seed = 6100; seed < 6130; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, true);
    draw.want(1.0);
    StiffMuscleData rigid = draw.problem, stiff = draw.problem;
    rigid.tendon_N_per_m.setConstant(kInfinity);
    stiff.tendon_N_per_m *= 1e9;
    const Solution soft_one = solve(draw.problem), rigid_one = solve(rigid), stiff_one = solve(stiff);
    if (soft_one.report.status != MuscleStatus::kOptimal) continue;
    ASSERT_EQ(rigid_one.report.status, MuscleStatus::kOptimal);
    ASSERT_EQ(stiff_one.report.status, MuscleStatus::kOptimal);
    EXPECT_GE(effort(draw.problem, soft_one), effort(rigid, rigid_one) * (1.0 - 1e-9));
    EXPECT_NEAR(effort(stiff, stiff_one), effort(rigid, rigid_one), 1e-6 * effort(rigid, rigid_one));
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

// A squeeze that may be anything takes no more effort than one that may not.
TEST(StiffMuscles, TheSqueezeIsChosen) {
  int compared = 0;
  for (std::uint64_t seed = 6200; seed < 6270; ++seed) {
    SCOPED_TRACE(seed);
    StiffDraw draw = drawn(seed, false, true);
    draw.want(1.0);
    const Solution free = solve(draw.problem);
    StiffMuscleData held = draw.problem;
    held.squeeze->low = held.squeeze->high = 1.0;
    const Solution fixed = solve(held);
    if (fixed.report.status != MuscleStatus::kOptimal) continue;
    ASSERT_EQ(free.report.status, MuscleStatus::kOptimal);
    EXPECT_EQ(fixed.report.squeeze, 1.0);
    EXPECT_LE(effort(draw.problem, free), effort(held, fixed) * (1.0 + 1e-9));
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

// ---- In a loop ----------------------------------------------------------------------------------------------------

// A loop of torques and wishes that drift: from the last optimum the answer is that from nothing.
TEST(StiffMuscles, FromTheLastOptimumItIsTheSame) {
  StiffWarmStart last;
  int warm_steps = 0, cold_steps = 0;
  StiffDraw draw = drawn(6001);
  const VectorXd tau = draw.problem.tau;
  for (int period = 0; period < 200; ++period) {
    SCOPED_TRACE(period);
    draw.problem.tau = (1.0 + 0.2 * std::sin(0.02 * period)) * tau;
    draw.want(1.0 + 0.3 * std::sin(0.03 * period));
    VectorXd f(23);
    const StiffMuscleReport warm = solve_stiff_muscles(draw.problem, last, f);
    const Solution cold = solve(draw.problem);
    ASSERT_EQ(warm.status, cold.report.status);
    ASSERT_EQ(warm.status, MuscleStatus::kOptimal);
    EXPECT_LE((f - cold.f).norm(), 1e-7 * f.norm());
    warm_steps += warm.iterations;
    cold_steps += cold.report.iterations;
  }
  EXPECT_LT(3 * warm_steps, cold_steps);
}

/// A loop as control has it: torques, arms and wishes that drift, with some `jitter` of torques, and one jump.
struct DriftingLoop {
  DriftingLoop(std::uint64_t seed, double jitter) : draw(drawn(seed, seed % 2 == 1, seed % 3 == 0)), random(seed) {
    share = jitter;
    at_start = draw.problem;
  }

  void go_on(int period) {
    draw.problem.tau = (1.0 + 0.1 * std::sin(0.02 * period)) * at_start.tau;
    for (double& tau : draw.problem.tau) tau *= 1.0 + random.uniform(-share, share);
    for (Index j = 0; j < at_start.H.cols(); ++j) {
      const double longer = 1.0 + 0.05 * std::sin(0.01 * period + static_cast<double>(j));
      draw.problem.H.col(j) = longer * at_start.H.col(j);
    }
    draw.problem.arm = draw.problem.H;
    draw.want(1.0 + 0.2 * std::sin(0.03 * period) + (period < 100 ? 0.0 : 0.3));
  }

  StiffDraw draw;
  StiffMuscleData at_start;
  Random random;
  double share;
};

// Along a path each answer is as good as from nothing, whether the path goes straight on, trembles or jumps.
TEST(StiffMuscles, AlongPathsTheyKeepTheirAccuracy) {
  int compared = 0, steps = 0, steps_from_last = 0;
  for (std::uint64_t seed = 6010; seed < 6022; ++seed) {
    const double jitter = seed % 4 == 0 ? 1e-3 : seed % 4 == 2 ? 1e-5 : 0.0;
    DriftingLoop loop(seed, jitter);
    StiffWarmStart last, last_alone;
    for (int period = 0; period < 200; ++period) {
      SCOPED_TRACE(testing::Message() << seed << ' ' << period);
      loop.go_on(period);
      VectorXd f = VectorXd::Constant(23, std::numeric_limits<double>::quiet_NaN());
      const StiffMuscleReport warm = solve_stiff_muscles(loop.draw.problem, last, f);
      const Solution cold = solve(loop.draw.problem);
      ASSERT_EQ(warm.status, cold.report.status);
      if (warm.status != MuscleStatus::kOptimal) continue;
      const double expected = effort(loop.draw.problem, cold);
      EXPECT_NEAR(effort(loop.draw.problem, {warm, f}), expected, 1e-6 * expected);
      EXPECT_LE(stiff_kkt_error(loop.draw.problem, f, warm), 1e-9);
      if (period % 40 == 39) expect_optimal(loop.draw.problem, {warm, f});
      ++compared;
      if (jitter > 0.0) continue;
      steps += warm.iterations;
      last_alone.order = 0;
      steps_from_last += solve_stiff_muscles(loop.draw.problem, last_alone, f).iterations;
    }
  }
  EXPECT_GT(compared, 1500);
  // Where the path goes straight on, so does the start.
  EXPECT_LT(1.05 * steps, steps_from_last);
}

TEST(StiffMuscles, DoNotAllocateAndRepeatTheirBits) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  StiffDraw draw = drawn(6001, true, true), hopeless = drawn(6001);
  draw.want(1.0);
  hopeless.want(100.0);
  VectorXd f(23), again(23);
  StiffWarmStart last;
  const AllocationCounter counter;
  EXPECT_EQ(solve_stiff_muscles(draw.problem, f).status, MuscleStatus::kOptimal);
  EXPECT_EQ(solve_stiff_muscles(draw.problem, last, again).status, MuscleStatus::kOptimal);
  EXPECT_EQ(f, again);
  const StiffMuscleReport report = solve_stiff_muscles(hopeless.problem, again);
  EXPECT_EQ(report.status, MuscleStatus::kInfeasible);
  (void)stiff_lack(hopeless.problem, report);
  EXPECT_EQ(solve_stiff_muscles(draw.problem, last, again).status, MuscleStatus::kOptimal);
  EXPECT_EQ(counter.count(), 0);
}

TEST(StiffMuscles, NotFiniteInputIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  StiffDraw draw = drawn(6001, true, true);
  draw.want(1.0);
  const auto expect_refused = [](const StiffMuscleData& p) {
    const Solution solution = solve(p);
    EXPECT_EQ(solution.report.status, MuscleStatus::kBudgetSpent);
    EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
  };
  for (const double bad : {nan, kInfinity}) {
    for (int which = 0; which < 9; ++which) {
      SCOPED_TRACE(which);
      StiffMuscleData p = draw.problem;
      double* const number[] = {&p.H(2, 2), &p.tau[3],  &p.arm(1, 1), &p.turn(3, 3), &p.fibre_per_m[1],
                                &p.A(1, 2), &p.B(2, 3), &p.D(1, 1),   &p.K_des(0, 0)};
      *number[which] = bad;
      expect_refused(p);
    }
    StiffMuscleData p = draw.problem;
    p.squeeze->tau[1] = bad;
    expect_refused(p);
  }
  StiffMuscleData p = draw.problem;
  p.limit[2] = nan;
  expect_refused(p);
  p = draw.problem;
  p.limit[2] = -1.0;
  expect_refused(p);
  p = draw.problem;
  p.tendon_N_per_m[2] = 0.0;
  expect_refused(p);
}

// As many joints and muscles as there may be, and fingers of different sizes.
TEST(StiffMuscles, OfTheLargestHand) {
  StiffDraw draw;
  draw.fingers = 6;
  draw.joints = 5;
  draw.muscles = 64;
  draw.has_squeeze = true;
  draw.draw(3);
  draw.want(0.5);
  const Solution solution = solve(draw.problem);
  expect_optimal(draw.problem, solution);
}

}  // namespace
}  // namespace thenar::stiff_muscles_test
