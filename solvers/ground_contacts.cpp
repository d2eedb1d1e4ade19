#include "solvers/ground_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Motion = GroundProblem::Motion;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kNewtonSteps = 25, kMostSteps = 250, kHalvings = 8;
// Over the ground's own compliance; and by how much a stage may be stiffer than the last one.
constexpr double kSoftest = 1e5, kFirstStage = 0.1, kLongestStage = 0.01, kShortestStage = 0.99;
constexpr double kStageTolerance = 1e-6;

/// A contact's force at d, and K = -df/dd where `K` is asked for.
Vector3d force_at(const Vector3d& d, double per_c, double mu, Matrix3d* K = nullptr) {
  if (K != nullptr) K->setZero();
  if (!(d[0] < 0.0)) return Vector3d::Zero();
  const double d_t = std::sqrt(d[1] * d[1] + d[2] * d[2]), bound_N = -mu * per_c * d[0];
  const bool sticks = per_c * d_t <= bound_N;
  const double part = sticks ? per_c : bound_N / d_t;
  const Vector3d f(-per_c * d[0], -part * d[1], -part * d[2]);
  if (K == nullptr) return f;
  K->diagonal() << per_c, part, part;
  if (sticks) return f;
  const double c_1 = d[1] / d_t, c_2 = d[2] / d_t;
  (*K)(1, 1) -= part * c_1 * c_1;
  (*K)(2, 2) -= part * c_2 * c_2;
  (*K)(1, 2) = (*K)(2, 1) = -part * c_1 * c_2;
  (*K)(1, 0) = -mu * c_1 * per_c;
  (*K)(2, 0) = -mu * c_2 * per_c;
  return f;
}

/// x - M (w + J' f) over M, and what it is judged by.
struct Balance {
  Motion missing;  ///< [N, N m]
  double size, scale;
};

Balance balance(const GroundProblem& problem, const Motion& x_free, const Motion& x, std::vector<Vector3d>& f) {
  Motion wrench = Motion::Zero();
  const double per_c = 1.0 / problem.compliance;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const GroundContact& contact = problem.contacts[i];
    const Vector3d d = contact.J.lazyProduct(x) + contact.delta_free;
    f[i] = force_at(d, per_c, contact.mu);
    if (!f[i].isZero(0.0)) wrench += contact.J.transpose().lazyProduct(f[i]);
  }
  const Motion free = (x - x_free).cwiseQuotient(problem.mobility);
  const auto norm = [&](const Motion& v) { return std::sqrt(v.dot(problem.mobility.cwiseProduct(v))); };
  Balance at{free - wrench, 0.0, norm(free) + norm(wrench) + norm(x_free.cwiseQuotient(problem.mobility))};
  at.size = norm(at.missing);
  return at;
}

/// sum J' K J; symmetric: without what a sliding contact's friction owes to its normal force.
Matrix6 stiffness(const GroundProblem& problem, const Motion& x, bool symmetric) {
  Matrix6 sum = Matrix6::Zero();
  const double per_c = 1.0 / problem.compliance;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const GroundContact& contact = problem.contacts[i];
    const Vector3d d = contact.J.lazyProduct(x) + contact.delta_free;
    if (!(d[0] < 0.0)) continue;
    Matrix3d K;
    force_at(d, per_c, contact.mu, &K);
    if (symmetric) K(1, 0) = K(2, 0) = 0.0;
    const GroundContact::Jacobian KJ = K.lazyProduct(contact.J);
    sum += contact.J.transpose().lazyProduct(KJ);
  }
  return sum;
}

/// Newton's method from work.x, with the last slope as long as it leaves a tenth of what is missing.
Balance newton(const GroundProblem& problem, const Motion& x_free, double tolerance, GroundWorkspace& work,
               int& steps) {
  constexpr double kStillGood = 0.1;
  Balance at = balance(problem, x_free, work.x, work.f);
  for (int k = 0; k < kNewtonSteps && at.size > tolerance * at.scale; ++k, ++steps) {
    if (work.has_slope) {
      const Motion step = work.slope.solve(-at.missing);
      const Balance trial = balance(problem, x_free, work.x + step, work.f);
      work.has_slope = trial.size <= kStillGood * at.size;
      if (work.has_slope) {
        work.x += step;
        at = trial;
        continue;
      }
    }
    Matrix6 slope = stiffness(problem, work.x, false);
    slope.diagonal() += problem.mobility.cwiseInverse();
    work.slope.compute(slope);
    work.has_slope = true;
    const Motion step = work.slope.solve(-at.missing);
    if (!step.allFinite()) {
      work.has_slope = false;
      break;
    }
    double part = 1.0;
    Balance trial = balance(problem, x_free, work.x + step, work.f);
    for (int halving = 0; halving < kHalvings && !(trial.size < at.size); ++halving) {
      part *= 0.5;
      trial = balance(problem, x_free, work.x + part * step, work.f);
    }
    // Where no part of the step helps, the whole step leads to another piece of the map.
    if (!(trial.size < at.size)) {
      part = 1.0;
      trial = balance(problem, x_free, work.x + step, work.f);
    }
    work.x += part * step;
    at = trial;
  }
  return at;
}

bool is_solved(const Balance& at, double tolerance) { return at.size <= tolerance * at.scale; }

/// From a soft ground to the ground as it is, every stage from the last one's motion. A stage that Newton's method
/// cannot take is shortened, one that it can is followed by a longer one. Returns how soft the last one was that it
/// could, and leaves its motion.
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

GroundReport solve_ground(const GroundProblem& problem, const Motion& x_free, GroundWorkspace& work,
                          double tolerance) noexcept {
  GroundReport report;
  if (!x_free.allFinite()) {
    for (Vector3d& f : work.f) f.setZero();
    return {SolveStatus::kNotFinite, 0, std::numeric_limits<double>::infinity()};
  }
  if (!work.x.allFinite()) work.x = x_free;
  const Motion guess = work.x;
  Balance at = newton(problem, x_free, tolerance, work, report.steps);
  if (!is_solved(at, tolerance)) {
    work.x = guess;
    GroundProblem softer = problem;
    softer.compliance *= stiffen(problem, x_free, tolerance, work, report.steps);
    at = balance(problem, x_free, work.x, work.f);
    balance(softer, x_free, work.x, work.f);  // Forces that belong to the motion.
  }
  if (!is_solved(at, tolerance)) report.status = SolveStatus::kBudgetSpent;
  if (!work.x.allFinite()) {
    report.status = SolveStatus::kNotFinite;
    work.x = x_free;
    for (Vector3d& f : work.f) f.setZero();
  }
  report.missing = at.scale > 0.0 ? at.size / at.scale : 0.0;
  return report;
}

Eigen::Matrix<double, 6, 6> ground_stiffness(const GroundProblem& problem, const Motion& x) {
  return stiffness(problem, x, true);
}

}  // namespace thenar
