// SPDX-License-Identifier: Apache-2.0
#include "solvers/ground_contacts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {
namespace {

using Eigen::Vector3d;
using Motion = GroundProblem::Motion;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Lanes = GroundLanes::Lanes;

constexpr int kNewtonSteps = 25, kMostSteps = 250, kHalvings = 8;
// Relative to the ground's own compliance; and the largest ratio of stiffness between stages.
constexpr double kSoftest = 1e5, kFirstStage = 0.1, kLongestStage = 0.01, kShortestStage = 0.99;
constexpr double kStageTolerance = 1e-6;

/// The state of four contacts at a motion: d, and friction's effect on its force.
struct FourContacts {
  FourContacts(const GroundLanes& at, const Motion& x, double per_c) : d(at.delta_free) {
    for (int j = 0; j < 6; ++j) {
      for (int r = 0; r < 3; ++r) d[r] += x[j] * at.J[r][j];
    }
    f_n = per_c * (-d[0]).max(0.0);
    d_t = (d[1].square() + d[2].square()).sqrt();
    sticks = per_c * d_t <= at.mu * f_n;
    part = sticks.select(Lanes::Constant(per_c), at.mu * f_n / d_t);  // f_t = -part d_t
  }

  std::array<Lanes, 3> d;
  Lanes d_t, f_n, part;
  Eigen::Array<bool, 4, 1> sticks;
};

Motion wrench_at(const std::vector<GroundLanes>& lanes, const Motion& x, double per_c) {
  std::array<Lanes, 6> sums;
  sums.fill(Lanes::Zero());
  for (const GroundLanes& at : lanes) {
    const FourContacts four(at, x, per_c);
    const Lanes f_1 = -four.part * four.d[1], f_2 = -four.part * four.d[2];
#pragma GCC unroll 6
    for (int j = 0; j < 6; ++j) sums[j] += at.J[0][j] * four.f_n + at.J[1][j] * f_1 + at.J[2][j] * f_2;
  }
  return Motion::NullaryExpr([&](Eigen::Index j) { return sums[j].sum(); });
}

/// x - M (w + J' f) over M, and its scale.
struct Balance {
  Motion missing;  ///< [N, N m]
  double size, scale;
};

Balance balance(const GroundProblem& problem, const Motion& x_free, const Motion& x, GroundWorkspace& work) {
  if (work.known_compliance != problem.compliance || work.x_known != x) {
    work.wrench = wrench_at(work.lanes, x, 1.0 / problem.compliance);
    work.x_known = x;
    work.known_compliance = problem.compliance;
  }
  const Motion free = (x - x_free).cwiseQuotient(problem.mobility);
  const auto norm = [&](const Motion& v) { return std::sqrt(v.dot(problem.mobility.cwiseProduct(v))); };
  const Motion missing = free - work.wrench;
  return {missing, norm(missing), norm(free) + norm(work.wrench) + norm(x_free.cwiseQuotient(problem.mobility))};
}

/// Returns sum J' K J; symmetric: without the coupling of a sliding contact's friction to its normal force.
Matrix6 stiffness(const std::vector<GroundLanes>& lanes, double compliance, const Motion& x, bool symmetric) {
  std::array<Lanes, 36> sums;
  sums.fill(Lanes::Zero());
  const double per_c = 1.0 / compliance;
  for (const GroundLanes& at : lanes) {
    const FourContacts four(at, x, per_c);
    const Eigen::Array<bool, 4, 1> presses = four.d[0] < 0.0;
    const Lanes zero = Lanes::Zero(), part = presses.select(four.part, zero);
    const Lanes k_nn = presses.select(Lanes::Constant(per_c), zero);
    const Lanes c_1 = four.sticks.select(zero, four.d[1] / four.d_t),
                c_2 = four.sticks.select(zero, four.d[2] / four.d_t);
    const Lanes k_11 = part * (1.0 - c_1.square()), k_22 = part * (1.0 - c_2.square()), k_12 = -part * c_1 * c_2;
    const Lanes owes = symmetric ? zero : Lanes(-at.mu * k_nn);
    for (int j = 0; j < 6; ++j) {
      const Lanes by_n = k_nn * at.J[0][j], by_1 = owes * c_1 * at.J[0][j] + k_11 * at.J[1][j] + k_12 * at.J[2][j],
                  by_2 = owes * c_2 * at.J[0][j] + k_12 * at.J[1][j] + k_22 * at.J[2][j];
#pragma GCC unroll 6
      for (int i = 0; i < 6; ++i) sums[6 * j + i] += at.J[0][i] * by_n + at.J[1][i] * by_1 + at.J[2][i] * by_2;
    }
  }
  return Matrix6::NullaryExpr([&](Eigen::Index i, Eigen::Index j) { return sums[6 * j + i].sum(); });
}

/// Applies Newton's method from work.x, with the last slope as long as it reduces the residual to a tenth.
Balance newton(const GroundProblem& problem, const Motion& x_free, double tolerance, GroundWorkspace& work,
               int& steps) {
  constexpr double kStillGood = 0.1;
  Balance at = balance(problem, x_free, work.x, work);
  for (int k = 0; k < kNewtonSteps && at.size > tolerance * at.scale; ++k, ++steps) {
    if (work.has_slope) {
      const Motion step = -work.inverse_slope.lazyProduct(at.missing);
      const Balance trial = balance(problem, x_free, work.x + step, work);
      work.has_slope = trial.size <= kStillGood * at.size;
      if (work.has_slope) {
        work.x += step;
        at = trial;
        continue;
      }
    }
    Matrix6 slope = stiffness(work.lanes, problem.compliance, work.x, false);
    slope.diagonal() += problem.mobility.cwiseInverse();
    work.inverse_slope = slope.partialPivLu().inverse();
    const Motion step = -work.inverse_slope.lazyProduct(at.missing);
    work.has_slope = step.allFinite();
    if (!work.has_slope) break;
    const auto trial_at = [&](double part) { return balance(problem, x_free, work.x + part * step, work); };
    double part = 1.0;
    Balance trial = trial_at(part);
    for (int halving = 0; halving < kHalvings && !(trial.size < at.size); ++halving) trial = trial_at(part *= 0.5);
    // Where no part of the step helps, the whole step leads to another piece of the map.
    if (!(trial.size < at.size)) trial = trial_at(part = 1.0);
    work.x += part * step;
    at = trial;
  }
  return at;
}

bool is_solved(const Balance& at, double tolerance) { return at.size <= tolerance * at.scale; }

/// Solves stages from a soft ground to the actual one, each from the last one's motion. A stage that fails is
/// shortened, one that succeeds is followed by a longer one. Returns the softness of the last one that succeeded, and
/// leaves its motion.
double stiffen(const GroundProblem& problem, const Motion& x_free, double tolerance, GroundWorkspace& work,
               int& steps) {
  Motion good = work.x;
  double good_softness = kSoftest / kFirstStage, factor = kFirstStage;
  while (good_softness > 1.0 && factor <= kShortestStage && steps < kMostSteps) {
    const double softness = std::max(1.0, good_softness * factor);
    GroundProblem softer = problem;
    softer.compliance *= softness;
    work.x = good;
    const double enough = softness == 1.0 ? tolerance : kStageTolerance;
    if (is_solved(newton(softer, x_free, enough, work, steps), enough)) {
      good = work.x;
      good_softness = softness;
      factor = std::max(kLongestStage, factor * factor);
    } else {
      factor = std::sqrt(factor);
    }
  }
  work.x = good;
  return good_softness;
}

}  // namespace

void set_ground(std::span<const GroundContact> contacts, GroundWorkspace& work) noexcept {
  const GroundContact none{GroundContact::Jacobian::Zero(), Vector3d::UnitX(), 0.0};
  work.lanes.resize((contacts.size() + 3) / 4);
  work.known_compliance = 0.0;
  for (std::size_t i = 0; i < 4 * work.lanes.size(); ++i) {
    GroundLanes& at = work.lanes[i / 4];
    const GroundContact& contact = i < contacts.size() ? contacts[i] : none;
    const auto lane = static_cast<Eigen::Index>(i % 4);
    for (int r = 0; r < 3; ++r) {
      for (int j = 0; j < 6; ++j) at.J[r][j][lane] = contact.J(r, j);
      at.delta_free[r][lane] = contact.delta_free[r];
    }
    at.mu[lane] = contact.mu;
  }
}

GroundReport solve_set_ground(const GroundProblem& problem, const Motion& x_free, GroundWorkspace& work,
                              double tolerance) noexcept {
  work.compliance = 0.0;
  GroundReport report{SolveStatus::kNotFinite, 0, std::numeric_limits<double>::infinity()};
  if (!x_free.allFinite()) return report;
  if (!work.x.allFinite()) work.x = x_free;
  const Motion guess = work.x;
  work.compliance = problem.compliance;
  Balance at = newton(problem, x_free, tolerance, work, report.steps);
  if (!is_solved(at, tolerance)) {
    work.x = guess;
    work.compliance *= stiffen(problem, x_free, tolerance, work, report.steps);
    at = balance(problem, x_free, work.x, work);
  }
  report.status = is_solved(at, tolerance) ? SolveStatus::kConverged : SolveStatus::kBudgetSpent;
  if (!work.x.allFinite()) {
    report.status = SolveStatus::kNotFinite;
    work.x = x_free;
    work.compliance = 0.0;
  }
  report.missing = at.scale > 0.0 ? at.size / at.scale : 0.0;
  return report;
}

void write_forces(const GroundProblem& problem, GroundWorkspace& work) noexcept {
  std::ranges::fill(work.f, Vector3d::Zero());
  if (work.compliance == 0.0) return;
  for (std::size_t i = 0; i < problem.contacts.size(); i += 4) {
    const FourContacts four(work.lanes[i / 4], work.x, 1.0 / work.compliance);
    for (std::size_t k = 0; k < 4 && i + k < problem.contacts.size(); ++k) {
      const auto lane = static_cast<Eigen::Index>(k);
      work.f[i + k] = {four.f_n[lane], -four.part[lane] * four.d[1][lane], -four.part[lane] * four.d[2][lane]};
    }
  }
}

GroundReport solve_ground(const GroundProblem& problem, const Motion& x_free, GroundWorkspace& work,
                          double tolerance) noexcept {
  set_ground(problem.contacts, work);
  const GroundReport report = solve_set_ground(problem, x_free, work, tolerance);
  write_forces(problem, work);
  return report;
}

Eigen::Matrix<double, 6, 6> ground_stiffness(const GroundProblem& problem, const GroundWorkspace& work) noexcept {
  return stiffness(work.lanes, problem.compliance, work.x, true);
}

}  // namespace thenar
