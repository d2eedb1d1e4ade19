#include "engine/studies/force_limit.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "solvers/dual_active_set.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kSize = kMaxLimitSize;
using Set = ActiveSet<kSize>;

// What the planes leave of a cone, as a share of the largest bound.
constexpr double kLeft = 1e-9;
// An answer is proved at this residual.
constexpr double kProved = 1e-8;
// A cone is touched by so many planes at most: each halves the angle to where the next one will be.
constexpr int kMostPlanes = 60;
// An equation whose row is, but for this part of its length, in the span of those before it adds nothing.
constexpr double kDependent = 1e-10;

/// A plane that touches a cone along (1, mu e): a.x >= 0 with a = (mu, -e).
struct Plane {
  Index cone = 0;
  double mu = 0.0, e_1 = 0.0, e_2 = 0.0;
};

/// The bounds and cones as constraints, in units of the largest bound. Planes are made where they are asked for, and
/// kept.
class Limits {
 public:
  explicit Limits(const ForceProgram& program)
      : program_(program), unit_(program.most.maxCoeff()), planes_left_(kMostPlanes * std::ssize(program.cones)) {}

  [[nodiscard]] Constraint<3> most_violated(const Set::Vector& x, double tolerance) {
    Constraint<3> worst{.slack = 0.0};
    const auto take = [&](int id, double slack) {
      if (slack < worst.slack) worst.id = id, worst.slack = slack;
    };
    for (Index j = 0; j < bounded(); ++j) {
      take(static_cast<int>(2 * j), x[j]);
      take(static_cast<int>(2 * j + 1), most(j) - x[j]);
    }
    for (std::size_t i = 0; i < program_.cones.size(); ++i) {
      take(first_normal() + static_cast<int>(i), x[program_.cones[i]]);
    }
    for (std::size_t p = 0; p < planes_.size(); ++p) {
      const Plane& plane = planes_[p];
      take(first_plane() + static_cast<int>(p),
           plane.mu * x[plane.cone] - plane.e_1 * x[plane.cone + 1] - plane.e_2 * x[plane.cone + 2]);
    }
    if (worst.slack < -tolerance) return constraint(worst.id, worst.slack);
    return touch(x, std::max(tolerance, kLeft));
  }

  /// The constraint of this name, a.x >= b, as a row.
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

  [[nodiscard]] Constraint<3> constraint(int id, double slack) const {
    if (id < first_plane()) {
      const int j = id < first_normal() ? id / 2 : static_cast<int>(program_.cones[id - first_normal()]);
      return {id, slack, {j, j, j}, {is_upper(id) ? -1.0 : 1.0, 0.0, 0.0}};
    }
    const Plane& plane = planes_[id - first_plane()];
    const int n = static_cast<int>(plane.cone);
    return {id, slack, {n, n + 1, n + 2}, {plane.mu, -plane.e_1, -plane.e_2}};
  }

  /// The plane that faces the force which is farthest out of its cone; no constraint if all are in.
  [[nodiscard]] Constraint<3> touch(const Set::Vector& x, double tolerance) {
    if (!(program_.friction > 0.0)) return {};
    double least = -tolerance;
    Plane plane;
    for (const Index n : program_.cones) {
      const double across = std::hypot(x[n + 1], x[n + 2]), slack = program_.friction * x[n] - across;
      if (!(slack < least)) continue;
      least = slack;
      plane = {n, program_.friction, across > 0.0 ? x[n + 1] / across : 1.0, across > 0.0 ? x[n + 2] / across : 0.0};
    }
    if (!(least < -tolerance) || planes_left_ == 0) return {};
    --planes_left_;
    planes_.push_back(plane);
    return constraint(first_plane() + static_cast<int>(planes_.size()) - 1, least);
  }

  const ForceProgram& program_;
  double unit_;
  std::ptrdiff_t planes_left_;
  std::vector<Plane> planes_;
};

/// E's rows made orthonormal, without those that depend on others.
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

/// The rows that a projection stopped at: the equations, then the constraints of its set.
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

/// How far x, in units of the largest bound, is outside.
double violation(const ForceProgram& program, const Limits& limits, const Set& set, const VectorXd& x) {
  double most = 0.0;
  for (Index j = 0; j < limits.bounded(); ++j) most = std::max({most, -x[j], x[j] - limits.most(j)});
  for (const Index n : program.cones) {
    most = std::max(most, -x[n]);
    if (program.friction > 0.0) most = std::max(most, std::hypot(x[n + 1], x[n + 2]) - program.friction * x[n]);
  }
  for (int k = 0; k < set.equalities; ++k)
    most = std::max(most, std::abs(set.basis[k].head(x.size()).matrix().dot(x)));
  return most;
}

/// The point nearest to t c, and the prices that prove it optimal, if they do.
ForceLimit nearest_to(const ForceProgram& program, double t, Limits& limits, Set& set) {
  const Index size = program.c.size();
  const VectorXd c = program.c / program.c.norm();
  Set::Vector x = Set::Vector::Zero();
  x.head(size) = t * c;
  for (int k = 0; k < set.equalities; ++k) x -= (x * set.basis[k]).sum() * set.basis[k];
  ForceLimit found;
  if (project(limits, set, x, t).status != ActiveSetStatus::kOptimal) return found;

  const Stop stop = rows_of(set, limits, size);
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> rows(stop.rows);
  // x = t c + .. has the rounding of t: once more to where the rows hold.
  found.x = x.head(size).matrix();
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> columns(stop.rows.transpose());
  found.x += columns.solve(stop.offsets - stop.rows.transpose() * found.x);
  const VectorXd y = -rows.solve(c);
  double error = (c + stop.rows * y).norm();
  const bool is_free = error > 1e-6;  // c points, in part, to where nothing stops it.
  found.price = VectorXd::Zero(limits.bounded());
  for (int j = 0; j < set.active; ++j) {
    const double price = y[set.equalities + j];
    error = std::max(error, -price);
    if (limits.is_upper(set.id[j])) found.price[set.id[j] / 2] = std::max(0.0, price);
  }
  const double dual = found.price.dot(program.most) / limits.unit();
  error = std::max({error, violation(program, limits, set, found.x), std::abs(c.dot(found.x) - dual)});
  found.residual = error;
  found.price *= program.c.norm();
  found.x *= limits.unit();
  found.value = program.c.dot(found.x);
  if (error <= kProved) found.status = LimitStatus::kOptimal;
  if (is_free && c.dot(found.x) > 1e-3 * t * limits.unit()) found.status = LimitStatus::kUnbounded;
  return found;
}

}  // namespace

ForceLimit find_force_limit(const ForceProgram& program) {
  const auto set = std::make_unique<Set>();
  for (Set::Vector& row : set->basis) row.setZero();
  set_equations(program.E, *set);
  Limits limits(program);
  ForceLimit found;
  for (const double t : {1e1, 1e2, 1e3, 1e4, 1e5, 1e6}) {
    found = nearest_to(program, t, limits, *set);
    if (found.status == LimitStatus::kOptimal) break;
  }
  return found;
}

}  // namespace thenar
