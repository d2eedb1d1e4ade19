// SPDX-License-Identifier: Apache-2.0
#include "solvers/exact_cone.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/dual_active_set.h"

namespace thenar {
namespace {

using Vector6 = std::array<double, 6>;

// An optimum is exact at this share of the forces, and trusted up to the second.
constexpr double kExact = 1e-12;
constexpr double kTrusted = 1e-9;
// Q'l and what is made of it lose the last two or three bits.
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 8.0 * kEpsilon;
constexpr double kTiny = std::numeric_limits<double>::min();

// Violations of cones that the planes tolerate, relative to the forces: from the first Newton ends most problems in 2
// to 5 steps; where it does not, from a later one.
constexpr std::array kLeft{1e-3, 1e-6, 1e-10};
constexpr int kNewtonSteps = 8;
// From where no cone was looked at Newton ends nine problems of ten in 3 to 6 steps. Where it does not go straight, a
// step going back to a tenth or its residual's square by half in so many steps, planes find the way sooner.
constexpr int kFirstSteps = 12, kStraightSteps = 6;
constexpr double kStraightStep = 0.1, kStraightSquare = 0.5;
// Without a multiplier each step gains about half a digit.
constexpr int kBorderSteps = 40;

double dot(const Vector6& a, const Vector6& b) {
  double sum = 0.0;
  for (int k = 0; k < 6; ++k) sum += a[k] * b[k];
  return sum;
}

/// Returns a + t b.
Vector6 plus(const Vector6& a, double t, const Vector6& b) {
  Vector6 sum;
  for (int k = 0; k < 6; ++k) sum[k] = a[k] + t * b[k];
  return sum;
}

/// P_K(x) for all contacts at once, with the terms of its derivative.
template <int kLanes>
struct Projection {
  LaneForces<kLanes> f;
  Lane<kLanes> e_1, e_2;  ///< x_t / |x_t|
  Lane<kLanes> part;      ///< |f_t| / |x_t|
  Eigen::Array<bool, kLanes, 1> is_inside;
};

template <int kLanes>
Projection<kLanes> project(const LaneForces<kLanes>& x, const Cones<kLanes>& cones) {
  using Lanes = Lane<kLanes>;
  const Lanes length = (x.col(1).square() + x.col(2).square()).sqrt();
  const Lanes inverse = 1.0 / length.max(kTiny);
  // Beside the cone: the nearest point of the generator (1, mu); behind it, or there but for rounding: the apex.
  const Lanes along = x.col(0) + cones.mu * length;
  const Lanes rounding = kRounding * (x.col(0).abs() + cones.mu * length);
  const Lanes normal = (along > rounding).select(cones.one_cut * along, 0.0);
  Projection<kLanes> to;
  to.is_inside = length < cones.mu * x.col(0);
  to.part = to.is_inside.select(Lanes::Ones(), cones.mu * normal * inverse);
  to.f.col(0) = to.is_inside.select(x.col(0), normal);
  to.f.col(1) = to.part * x.col(1);
  to.f.col(2) = to.part * x.col(2);
  to.e_1 = (length > 0.0).select(x.col(1) * inverse, 1.0);
  to.e_2 = x.col(2) * inverse;
  return to;
}

/// Numbers of the six equations, padded to whole registers.
using Padded = Eigen::Array<double, 8, 1>;

/// Wrenches of unit forces, Q by columns: n, t1, t2 of each contact.
template <int kLanes>
struct ForceColumns {
  void fill(const ReducedGrasp<kLanes>& grasp) {
    contacts = static_cast<int>(grasp.contacts);
    for (int i = 0; i < contacts; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        columns[3 * i + axis].setZero();
        for (int k = 0; k < 6; ++k) columns[3 * i + axis][k] = grasp.Q[k](i, axis);
      }
    }
  }
  int contacts = 0;
  std::array<Padded, 3 * kLanes> columns;
};

/// Newton's equations (Q B Q' + shift I) x = y, B the derivative of P_K, a row of each with its y.
class NewtonStep {
 public:
  explicit NewtonStep(const Vector6& y) {
    for (int k = 0; k < 6; ++k) rows_[k] << 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, y[k], 0.0;
  }

  template <int kLanes>
  void add(const ForceColumns<kLanes>& Q, const Projection<kLanes>& to, const Cones<kLanes>& cones) {
    for (int i = 0; i < Q.contacts; ++i) {
      const Padded &n = Q.columns[3 * i], &t1 = Q.columns[3 * i + 1], &t2 = Q.columns[3 * i + 2];
      if (to.is_inside[i]) {
        for (const Padded* column : {&n, &t1, &t2}) add(1.0, *column);
      } else if (to.f(i, 0) > 0.0) {
        // Beside the cone the normal force follows along (1, mu e) and the tangential one turns with x_t.
        add(cones.one_cut[i], n + cones.mu[i] * (to.e_1[i] * t1 + to.e_2[i] * t2));
        add(to.part[i], to.e_1[i] * t2 - to.e_2[i] * t1);
      }
      // At the apex nothing moves.
    }
  }

  /// Solves for x by elimination. Unrolled, rows stay in registers.
  [[nodiscard]] Vector6 solve(double shift) {
    Vector6 inverse, x;
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
      // Rounding may give a pivot of a positive semidefinite matrix any sign.
      inverse[k] = 1.0 / std::max(rows_[k][k] + shift, shift);
#pragma GCC unroll 6
      for (int i = k + 1; i < 6; ++i) rows_[i] -= (rows_[k][i] * inverse[k]) * rows_[k];
      x[k] = rows_[k][6] * inverse[k];
    }
#pragma GCC unroll 6
    for (int k = 5; k > 0; --k) {
#pragma GCC unroll 6
      for (int i = 0; i < k; ++i) x[i] -= rows_[i][k] * inverse[i] * x[k];
    }
    return x;
  }

 private:
  void add(double weight, const Padded& column) {
    const Padded weighted = weight * column;
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) rows_[k] += weighted[k] * column;
  }

  std::array<Padded, 6> rows_;
};

/// A point of the dual.
template <int kLanes>
struct Point {
  Vector6 l;
  LaneForces<kLanes> x;   ///< Q'l + bias
  Projection<kLanes> to;  ///< f = P_K(x)
  Vector6 residual;       ///< w - Q f
  double square;          ///< |w - Q f|^2

  /// Returns |w - Q f| / |f|.
  [[nodiscard]] double kkt_error() const {
    return square == 0.0 ? 0.0 : std::sqrt(square / std::max(to.f.square().sum(), kTiny));
  }
  /// Returns the error by the rounding of x.
  [[nodiscard]] double rounding() const {
    return kRounding * std::sqrt(x.square().sum() / std::max(to.f.square().sum(), kTiny));
  }
};

/// The planes tangent to Coulomb's cones as constraints. Each is made on demand: for the most violated cone, the plane
/// that faces its force.
template <int kLanes>
class TangentPlanes {
 public:
  static constexpr int kSize = 3 * kLanes;  ///< f_n of all lanes, then f_t1, f_t2.
  using Vector = typename ActiveSet<kSize>::Vector;

  /// Violations up to `left` N are tolerated.
  TangentPlanes(const Lane<kLanes>& mu, double left) : mu_(mu), left_(left) {}

  [[nodiscard]] Constraint<3> most_violated(const Vector& f, double tolerance) {
    const auto f_t1 = f.template segment<kLanes>(kLanes);
    const auto f_t2 = f.template segment<kLanes>(2 * kLanes);
    const Lane<kLanes> f_t = (f_t1.square() + f_t2.square()).sqrt();
    const Lane<kLanes> slack = mu_ * f.template segment<kLanes>(0) - f_t;
    const double least = slack.minCoeff();
    if (!(least < -std::max(tolerance, left_)) || count_ == kMost) return {};
    int i = 0;
    while (slack[i] != least) ++i;
    const bool has_direction = f_t[i] > 0.0;
    const Plane plane{i, has_direction ? f_t1[i] / f_t[i] : 1.0, has_direction ? f_t2[i] / f_t[i] : 0.0};
    planes_[count_] = plane;
    return {count_++, least, {i, i + kLanes, i + 2 * kLanes}, {mu_[i], -plane.e_1, -plane.e_2}};
  }

  /// Returns A'u of the planes in the set.
  [[nodiscard]] LaneForces<kLanes> push(const ActiveSet<kSize>& set) const {
    LaneForces<kLanes> push = LaneForces<kLanes>::Zero();
    for (int j = 0; j < set.active; ++j) {
      const Plane& plane = planes_[set.id[j]];
      push(plane.lane, 0) += set.multiplier[j] * mu_[plane.lane];
      push(plane.lane, 1) -= set.multiplier[j] * plane.e_1;
      push(plane.lane, 2) -= set.multiplier[j] * plane.e_2;
    }
    return push;
  }

 private:
  struct Plane {
    int lane;
    double e_1, e_2;
  };
  // More only gain digits that Newton finds sooner.
  static constexpr int kMost = 100;

  const Lane<kLanes>& mu_;
  double left_;
  int count_ = 0;
  std::array<Plane, kMost> planes_;
};

template <int kLanes>
class Solver {
 public:
  using Lanes = Lane<kLanes>;
  using Forces = LaneForces<kLanes>;

  explicit Solver(const ReducedGrasp<kLanes>& grasp) : grasp_(grasp) {
    least_ = std::sqrt(dot(grasp.w, grasp.w));
    scale_ = least_ + std::sqrt(grasp.bias.square().sum());
  }

  ConeResult solve(Forces& f, Vector6& multiplier) {
    Vector6 start = reduced_wrench(grasp_, grasp_.bias);
    for (int k = 0; k < 6; ++k) start[k] = grasp_.w[k] - start[k];
    // Without the cones: often they have no part in it.
    const Forces f_start = combine(grasp_, start) + grasp_.bias;
    const Point<kLanes> first = evaluate(start, f_start);
    bool is_decided = is_optimal(first);
    if (!is_decided) {
      columns_.fill(grasp_);
      is_decided = newton(first, kFirstSteps, true);
    }
    for (const double left : kLeft) is_decided = is_decided || planes_and_newton(f_start, left);
    if (!is_decided && std::isfinite(residual_)) newton(evaluate(best_l_), kBorderSteps);

    if (status_ == GraspStatus::kBudgetSpent && residual_ <= kTrusted) status_ = GraspStatus::kOptimal;
    if (status_ == GraspStatus::kOptimal) {
      f = best_f_, multiplier = best_l_;
    } else if (status_ == GraspStatus::kInfeasible) {
      multiplier = certificate_;
    }
    return {status_, iterations_, residual_};
  }

 private:
  Point<kLanes> evaluate(const Vector6& l, const Forces& x) const {
    Point<kLanes> point;
    point.l = l;
    point.x = x;
    point.to = project<kLanes>(x, grasp_.cones);
    point.residual = reduced_wrench(grasp_, point.to.f);
    for (int k = 0; k < 6; ++k) point.residual[k] = grasp_.w[k] - point.residual[k];
    point.square = dot(point.residual, point.residual);
    return point;
  }
  Point<kLanes> evaluate(const Vector6& l) const { return evaluate(l, combine(grasp_, l) + grasp_.bias); }

  /// Keeps the point if it is the best so far; true if it is the optimum.
  bool is_optimal(const Point<kLanes>& point) {
    const double error = point.kkt_error();
    if (!(error < residual_)) return false;
    residual_ = error;
    best_l_ = point.l, best_f_ = point.to.f;
    if (error > kTrusted || (error > kExact && error > point.rounding())) return false;
    status_ = GraspStatus::kOptimal;
    return true;
  }

  /// Tests whether the direction proves that there are no forces, after a few Newton steps towards P_K(Q'c) = 0.
  bool is_certificate(Vector6 c) {
    double last = kNearCertificate / kContraction;
    for (int step = 0; step < kPolishSteps; ++step) {
      const double work = dot(grasp_.w, c);
      if (!(work > 0.0)) return false;
      const Forces x = combine(grasp_, c);
      const Projection<kLanes> to = project<kLanes>(x, grasp_.cones);
      // Rounding of P_K(Q'c) counts, too: at the border the work is no larger than that.
      const double hidden = kEpsilon * std::sqrt(x.square().sum());
      const double gap = least_ * (std::sqrt(to.f.square().sum()) + hidden) / work;
      if (gap * kOutOfReach <= 1.0) {
        status_ = GraspStatus::kInfeasible;
        residual_ = gap;
        certificate_ = c;
        return true;
      }
      if (gap > kContraction * last) return false;
      last = gap;
      ++iterations_;
      NewtonStep newton(reduced_wrench(grasp_, to.f));
      newton.add(columns_, to, grasp_.cones);
      c = plus(c, -1.0, newton.solve(kLeastShift));
    }
    return false;
  }

  /// Applies Newton's method to the dual from a point. True if it decided the problem. straight: it gives up where it
  /// does not converge directly.
  bool newton(Point<kLanes> point, int steps, bool straight = false);

  /// Applies Newton's method from the optimum between planes tangent to the cones, with relative violations up to
  /// `left`. True if it decided the problem; where the planes are infeasible, so are the cones.
  bool planes_and_newton(const Forces& start, double left);

  // Each at least a tenth of the bracket.
  static constexpr int kLineSteps = 30;
  // Newton doubles the digits from where it contracts: 1e-2, 1e-4, 1e-8, done.
  static constexpr int kPolishSteps = 4;
  static constexpr double kContraction = 0.3;
  static constexpr double kNearCertificate = 0.03;
  // The eigenvalues of Q DP Q' are 0 to 1.
  static constexpr double kLeastShift = 1e-14;

  const ReducedGrasp<kLanes>& grasp_;
  ForceColumns<kLanes> columns_;
  double least_;  ///< |w|: the least forces without cones.
  double scale_;
  GraspStatus status_ = GraspStatus::kBudgetSpent;
  int iterations_ = 0;
  double residual_ = std::numeric_limits<double>::infinity();
  Vector6 best_l_;
  Forces best_f_;
  Vector6 certificate_;
};

// Inlined as a whole, as are the planes below: a tenth of the time.
template <int kLanes>
[[gnu::flatten]] bool Solver<kLanes>::newton(Point<kLanes> point, int steps, bool straight) {
  const double first = point.square;
  double damping = 1e-3;
  double last = 0.0;
  for (int step = 0;; ++step) {
    if (is_optimal(point)) return true;
    // In infeasible problems the residual stays: it becomes the infeasible part of w.
    if (step > 0 && point.square > 0.1 * last && is_certificate(point.residual)) return true;
    last = point.square;
    if (step == steps) return false;
    ++iterations_;

    const double shift = kLeastShift + damping * std::min(1.0, std::sqrt(point.square) / scale_);
    NewtonStep newton(point.residual);
    newton.add(columns_, point.to, grasp_.cones);
    const Vector6 direction = newton.solve(shift);
    const Forces dx = combine(grasp_, direction);
    const double slope = dot(point.residual, direction);
    const double work = dot(grasp_.w, direction);

    // The slope of the dual along the step falls from `slope`. Where the full step went far past its zero, go back.
    double t = 1.0;
    Point<kLanes> next = evaluate(plus(point.l, t, direction), point.x + t * dx);
    double low = 0.0, slope_low = slope, high = 1.0, slope_high = 0.0;
    for (int k = 0; k < kLineSteps && next.square > 0.25 * point.square; ++k) {
      const double slope_t = work - (next.to.f * dx).sum();
      if (std::abs(slope_t) <= 0.5 * slope || (t == 1.0 && slope_t > 0.0)) break;
      if (slope_t > 0.0) {
        low = t;
        slope_low = slope_t;
      } else {
        high = t;
        slope_high = slope_t;
      }
      t = low + (high - low) * std::clamp(slope_low / (slope_low - slope_high), 0.1, 0.9);
      next = evaluate(plus(point.l, t, direction), point.x + t * dx);
    }

    if (straight && (t < kStraightStep || (step >= kStraightSteps && next.square > kStraightSquare * first))) {
      return false;
    }

    // Trust the quadratic model as far as it told the new residual.
    Vector6 miss;
    for (int k = 0; k < 6; ++k) {
      miss[k] = next.residual[k] - (1.0 - t) * point.residual[k] - t * shift * direction[k];
    }
    const double ratio = dot(miss, miss) / point.square;
    if (t < 1.0 || ratio > 0.64) {
      damping = std::min(1.0, 4.0 * damping);
    } else if (ratio < 0.25) {
      damping = std::max(1e-12, 0.1 * damping);
    }
    point = next;
  }
}

template <int kLanes>
[[gnu::flatten]] bool Solver<kLanes>::planes_and_newton(const Forces& start, double left) {
  TangentPlanes<kLanes> planes(grasp_.cones.mu, left * std::sqrt(start.square().sum()));
  ActiveSet<3 * kLanes> set;
  for (int k = 0; k < grasp_.rank; ++k) set.basis[set.equalities++] = grasp_.Q[k].reshaped();
  typename TangentPlanes<kLanes>::Vector x = start.reshaped();
  const ActiveSetReport report = thenar::project(planes, set, x);
  iterations_ += report.changes;
  if (report.status == ActiveSetStatus::kBudgetSpent) return false;
  const Forces push = planes.push(set);
  if (report.status == ActiveSetStatus::kInfeasible) return is_certificate(reduced_wrench<kLanes>(grasp_, -push));
  const Forces f = x.reshaped(kLanes, 3);
  return newton(evaluate(reduced_wrench<kLanes>(grasp_, f - grasp_.bias - push)), kNewtonSteps);
}

}  // namespace

template <int kLanes>
ConeResult solve_exact_cone(const ReducedGrasp<kLanes>& grasp, LaneForces<kLanes>& f,
                            std::array<double, 6>& multiplier) noexcept {
  return Solver<kLanes>(grasp).solve(f, multiplier);
}

template ConeResult solve_exact_cone<4>(const ReducedGrasp<4>&, LaneForces<4>&, std::array<double, 6>&) noexcept;
template ConeResult solve_exact_cone<8>(const ReducedGrasp<8>&, LaneForces<8>&, std::array<double, 6>&) noexcept;

}  // namespace thenar
