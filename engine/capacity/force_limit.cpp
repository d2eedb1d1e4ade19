// SPDX-License-Identifier: Apache-2.0
#include "engine/capacity/force_limit.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "solvers/dual_active_set.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kSize = kMaxLimitSize;
using Set = ActiveSet<kSize>;

// Tolerated violation of a cone, relative to the largest bound: planes are then some 1e-3 rad apart. With less, their
// nearly coincident rows cost the gained digits.
constexpr double kLeft = 1e-7;
// A program between planes is proved at this residual.
constexpr double kProved = 1e-9;
// A value beyond this multiple of the largest bound is unbounded.
constexpr double kFar = 1e4;
// Planes that each cone begins with, and how often those that are left get one more: each halves the angle.
constexpr int kFirstPlanes = 8, kRounds = 40;
// Steps from point to point, and how long they become.
constexpr int kSteps = 30;
constexpr double kLongest = 1e9;
// An equation whose row is in the span of those before it, up to this part of its length, is redundant.
constexpr double kDependent = 1e-10;

/// A plane tangent to a cone along (1, mu e): a.x >= 0 with a = (mu, -e).
struct Plane {
  Index cone = 0;
  double mu = 0.0, e_1 = 0.0, e_2 = 0.0;
};

/// The bounds as constraints, in units of the largest one, and planes tangent to the cones.
class Limits {
 public:
  explicit Limits(const ForceProgram& program) : program_(program), unit_(program.most.maxCoeff()) {
    if (!(program.friction > 0.0)) return;
    for (const Index n : program.cones) {
      for (int i = 0; i < kFirstPlanes; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kFirstPlanes;
        planes_.push_back({n, program.friction, std::cos(angle), std::sin(angle)});
      }
    }
  }

  [[nodiscard]] Constraint<3> most_violated(const Set::Vector& x, double tolerance) const {
    const auto [id, slack] = least_slack(x);
    return slack < -tolerance ? constraint(id, slack) : Constraint<3>{};
  }

  /// Returns the violation of bounds and planes by x.
  [[nodiscard]] double violation(const VectorXd& x) const { return std::max(0.0, -least_slack(x).second); }

  /// Adds planes for the forces outside their cones, each the one that faces it. False if all are inside.
  [[nodiscard]] bool touch(const VectorXd& x) {
    if (!(program_.friction > 0.0)) return false;
    bool is_left = false;
    for (const Index n : program_.cones) {
      const double across = std::hypot(x[n + 1], x[n + 2]);
      if (across <= program_.friction * x[n] + kLeft * std::max(1.0, x.norm())) continue;
      planes_.push_back({n, program_.friction, x[n + 1] / across, x[n + 2] / across});
      is_left = true;
    }
    return is_left;
  }

  /// Returns the constraint of this name, a.x >= b, as a row.
  [[nodiscard]] VectorXd row(int id) const {
    VectorXd a = VectorXd::Zero(program_.c.size());
    const Constraint<3> one = constraint(id, 0.0);
    for (int k = 0; k < 3; ++k) a[one.index[k]] += one.value[k];
    return a;
  }
  [[nodiscard]] double offset(int id) const { return is_upper(id) ? -most(id / 2) : 0.0; }
  [[nodiscard]] bool is_upper(int id) const { return id < first_normal() && id % 2 == 1; }
  [[nodiscard]] double unit() const { return unit_; }
  [[nodiscard]] double most(Index j) const { return program_.most[j] / unit_; }
  [[nodiscard]] Index bounded() const { return program_.most.size(); }

 private:
  // Names of constraints: two for each bounded variable, one for the normal of each cone, and then planes.
  [[nodiscard]] int first_normal() const { return static_cast<int>(2 * bounded()); }
  [[nodiscard]] int first_plane() const { return first_normal() + static_cast<int>(program_.cones.size()); }

  template <typename Vector>
  [[nodiscard]] std::pair<int, double> least_slack(const Vector& x) const {
    std::pair<int, double> least{-1, 0.0};
    const auto take = [&](Index id, double slack) {
      if (slack < least.second) least = {static_cast<int>(id), slack};
    };
    for (Index j = 0; j < bounded(); ++j) {
      take(2 * j, x[j]);
      take(2 * j + 1, most(j) - x[j]);
    }
    for (Index i = 0; i < std::ssize(program_.cones); ++i) take(first_normal() + i, x[program_.cones[i]]);
    for (Index p = 0; p < std::ssize(planes_); ++p) {
      const Plane& plane = planes_[p];
      take(first_plane() + p, plane.mu * x[plane.cone] - plane.e_1 * x[plane.cone + 1] - plane.e_2 * x[plane.cone + 2]);
    }
    return least;
  }

  [[nodiscard]] Constraint<3> constraint(int id, double slack) const {
    if (id < first_plane()) {
      const int j = id < first_normal() ? id / 2 : static_cast<int>(program_.cones[id - first_normal()]);
      return {id, slack, {j, j, j}, {is_upper(id) ? -1.0 : 1.0, 0.0, 0.0}};
    }
    const Plane& plane = planes_[id - first_plane()];
    const int n = static_cast<int>(plane.cone);
    return {id, slack, {n, n + 1, n + 2}, {plane.mu, -plane.e_1, -plane.e_2}};
  }

  const ForceProgram& program_;
  double unit_;
  std::vector<Plane> planes_;
};

/// Returns E's rows made orthonormal, without those that depend on others.
void set_equations(const MatrixXd& E, Set& set) {
  set.equalities = 0;
  for (Index i = 0; i < E.rows(); ++i) {
    Set::Vector row = Set::Vector::Zero();
    row.head(E.cols()) = E.row(i).transpose();
    const double length = std::sqrt(row.square().sum());
    if (!(length > 0.0)) continue;
    row /= length;
    for (int pass = 0; pass < 2; ++pass) {
      for (int k = 0; k < set.equalities; ++k) row -= (row * set.basis[k]).sum() * set.basis[k];
    }
    const double rest = std::sqrt(row.square().sum());
    if (rest > kDependent) set.basis[set.equalities++] = row / rest;
  }
}

/// The active rows of a projection: the equations, then the constraints of its set.
struct Stop {
  MatrixXd rows;  ///< By columns.
  VectorXd offsets;
};

Stop rows_of(const Set& set, const Limits& limits, Index size) {
  Stop stop{MatrixXd(size, set.working()), VectorXd::Zero(set.working())};
  for (int k = 0; k < set.equalities; ++k) stop.rows.col(k) = set.basis[k].head(size).matrix();
  for (int j = 0; j < set.active; ++j) {
    stop.rows.col(set.equalities + j) = limits.row(set.id[j]);
    stop.offsets[set.equalities + j] = limits.offset(set.id[j]);
  }
  return stop;
}

/// Returns the violation of bounds, planes and equations by x, in units of the largest bound.
double violation(const Limits& limits, const Set& set, const VectorXd& x) {
  double most = limits.violation(x);
  for (int k = 0; k < set.equalities; ++k) most = std::max(most, std::abs(set.basis[k].head(x.size()).matrix().dot(x)));
  return most;
}

/// Finds the point nearest to from + t c, and the prices that prove it optimal, if they do.
ForceLimit step(const ForceProgram& program, const VectorXd& from, double t, const Limits& limits, Set& set) {
  const Index size = program.c.size();
  const VectorXd c = program.c / program.c.norm();
  Set::Vector x = Set::Vector::Zero();
  x.head(size) = from + t * c;
  for (int k = 0; k < set.equalities; ++k) x -= (x * set.basis[k]).sum() * set.basis[k];
  ForceLimit found;
  if (project(limits, set, x, t).status != ActiveSetStatus::kOptimal) return found;

  const Stop stop = rows_of(set, limits, size);
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> rows(stop.rows);
  // x = from + t c + .. has the rounding of t: once more to where the rows hold.
  found.x = x.head(size).matrix();
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> columns(stop.rows.transpose());
  found.x += columns.solve(stop.offsets - stop.rows.transpose() * found.x);
  const VectorXd y = -rows.solve(c);
  double error = (c + stop.rows * y).norm();
  const bool is_free = error > 1e-6;  // A part of c is unbounded.
  found.price = VectorXd::Zero(limits.bounded());
  for (int j = 0; j < set.active; ++j) {
    const double price = y[set.equalities + j];
    error = std::max(error, -price);
    if (limits.is_upper(set.id[j])) found.price[set.id[j] / 2] = std::max(0.0, price);
  }
  const double dual = found.price.dot(program.most) / limits.unit();
  error = std::max({error, violation(limits, set, found.x), std::abs(c.dot(found.x) - dual)});
  found.residual = error;
  found.price *= program.c.norm();
  found.x *= limits.unit();
  found.value = program.c.dot(found.x);
  if (error <= kProved) found.status = LimitStatus::kOptimal;
  if (is_free && c.dot(found.x) > kFar * limits.unit()) found.status = LimitStatus::kUnbounded;
  return found;
}

/// Solves the program with planes in place of cones, from a point near its solution, which becomes it.
ForceLimit between_planes(const ForceProgram& program, const Limits& limits, Set& set, VectorXd& x) {
  ForceLimit best;
  double t = 10.0;
  for (int k = 0; k < kSteps; ++k) {
    ForceLimit found = step(program, x, t, limits, set);
    if (found.x.size() == 0) break;
    x = found.x / limits.unit();
    if (found.residual < best.residual || found.status == LimitStatus::kUnbounded) best = std::move(found);
    if (best.status != LimitStatus::kUnproved) break;
    t = std::min(kLongest, 3.0 * t);
  }
  if (best.status == LimitStatus::kUnproved && best.value > kFar * limits.unit() * program.c.norm()) {
    best.status = LimitStatus::kUnbounded;
  }
  return best;
}

}  // namespace

ForceLimit find_force_limit(const ForceProgram& program) {
  const auto set = std::make_unique<Set>();
  for (Set::Vector& row : set->basis) row.setZero();
  set_equations(program.E, *set);
  Limits limits(program);
  ForceLimit found;
  VectorXd x = VectorXd::Zero(program.c.size());
  for (int round = 0; round < kRounds; ++round) {
    found = between_planes(program, limits, *set, x);
    // Large or unproved values, too, may be an effect of the planes alone.
    if (!limits.touch(x)) return found;
  }
  if (found.status == LimitStatus::kOptimal) found.status = LimitStatus::kUnproved;
  return found;
}

}  // namespace thenar
