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

// What the planes may leave of a cone's violation, as a share of the forces: from the first Newton ends most problems
// in 2 to 5 steps; where it does not, from a later one.
constexpr std::array kLeft{1e-3, 1e-6, 1e-10};
constexpr int kNewtonSteps = 8;
// Without a multiplier each step gains about half a digit.
constexpr int kBorderSteps = 40;

double dot(const Vector6& a, const Vector6& b) {
  double sum = 0.0;
  for (int k = 0; k < 6; ++k) sum += a[k] * b[k];
  return sum;
}

/// a + t b
Vector6 plus(const Vector6& a, double t, const Vector6& b) {
  Vector6 sum;
  for (int k = 0; k < 6; ++k) sum[k] = a[k] + t * b[k];
  return sum;
}

/// |f_t| <= mu f_n
struct Cone {
  explicit Cone(double friction) : mu(friction), slope(1.0 / (1.0 + friction * friction)) {}
  double mu;
  double slope;  ///< Of f_n along the cone's surface.
};

/// P_K(x) for all contacts at once, and what its derivative needs.
template <int kLanes>
struct Projection {
  LaneForces<kLanes> f;
  Lane<kLanes> e_1, e_2;  ///< x_t / |x_t|
  Lane<kLanes> part;      ///< |f_t| / |x_t|
  Eigen::Array<bool, kLanes, 1> is_inside;
};

template <int kLanes>
Projection<kLanes> project(const LaneForces<kLanes>& x, const Cone& cone) {
  using Lanes = Lane<kLanes>;
  const Lanes length = (x.col(1).square() + x.col(2).square()).sqrt();
  const Lanes inverse = 1.0 / length.max(kTiny);
  // Beside the cone: the nearest point of the generator (1, mu); behind it, or there but for rounding: the apex.
  const Lanes along = x.col(0) + cone.mu * length;
  const Lanes rounding = kRounding * (x.col(0).abs() + cone.mu * length);
  const Lanes normal = (along > rounding).select(cone.slope * along, 0.0);
  Projection<kLanes> to;
  to.is_inside = length < cone.mu * x.col(0);
  to.part = to.is_inside.select(Lanes::Ones(), cone.mu * normal * inverse);
  to.f.col(0) = to.is_inside.select(x.col(0), normal);
  to.f.col(1) = to.part * x.col(1);
  to.f.col(2) = to.part * x.col(2);
  to.e_1 = (length > 0.0).select(x.col(1) * inverse, 1.0);
  to.e_2 = x.col(2) * inverse;
  return to;
}

/// A symmetric 3x3 matrix a contact.
template <int kLanes>
struct Blocks {
  Lane<kLanes> nn, n1, n2, t11, t12, t22;
};

/// The block with `nn` along the normal, `along` and `across` in the tangent plane along the unit vector (e1, e2) and
/// square to it, and `ne` between normal and e.
template <int kLanes>
Blocks<kLanes> blocks_about(const Lane<kLanes>& e1, const Lane<kLanes>& e2, const Lane<kLanes>& nn,
                            const Lane<kLanes>& ne, const Lane<kLanes>& along, const Lane<kLanes>& across) {
  return {nn,
          ne * e1,
          ne * e2,
          along * e1.square() + across * e2.square(),
          (along - across) * e1 * e2,
          along * e2.square() + across * e1.square()};
}

/// The derivative of P_K.
template <int kLanes>
Blocks<kLanes> derivative(const Projection<kLanes>& to, const Cone& cone) {
  using Lanes = Lane<kLanes>;
  // Beside the cone the normal force follows along (1, mu e) and the tangential one turns with x_t; at the apex nothing
  // moves.
  const Lanes slope = (to.f.col(0) > 0.0).select(Lanes::Constant(cone.slope), 0.0);
  const Lanes one = Lanes::Ones();
  return blocks_about<kLanes>(to.e_1, to.e_2, to.is_inside.select(one, slope),
                              to.is_inside.select(Lanes::Zero(), cone.mu * slope),
                              to.is_inside.select(one, cone.mu * cone.mu * slope), to.part);
}

template <int kLanes>
LaneForces<kLanes> operator*(const Blocks<kLanes>& B, const LaneForces<kLanes>& x) {
  LaneForces<kLanes> y;
  y.col(0) = B.nn * x.col(0) + B.n1 * x.col(1) + B.n2 * x.col(2);
  y.col(1) = B.n1 * x.col(0) + B.t11 * x.col(1) + B.t12 * x.col(2);
  y.col(2) = B.n2 * x.col(0) + B.t12 * x.col(1) + B.t22 * x.col(2);
  return y;
}

/// L D L' of Q B Q' + shift I.
class Factors {
 public:
  template <int kLanes>
  Factors(const std::array<LaneForces<kLanes>, 6>& Q, const Blocks<kLanes>& B, double shift) {
    // Unrolled, 6x6 numbers stay in registers: half of the time.
#pragma GCC unroll 6
    for (int i = 0; i < 6; ++i) {
      const LaneForces<kLanes> BQ_i = B * Q[i];
#pragma GCC unroll 6
      for (int j = 0; j <= i; ++j) L_[i][j] = (BQ_i * Q[j]).sum();
      L_[i][i] += shift;
    }
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
      // Of a positive semidefinite matrix rounding may make a pivot of any sign.
      inverse_[k] = 1.0 / std::max(L_[k][k], shift);
      Vector6 column;
#pragma GCC unroll 6
      for (int i = k + 1; i < 6; ++i) {
        column[i] = L_[i][k];
        L_[i][k] *= inverse_[k];
#pragma GCC unroll 6
        for (int j = k + 1; j <= i; ++j) L_[i][j] -= L_[i][k] * column[j];
      }
    }
  }

  [[nodiscard]] Vector6 solve(Vector6 y) const {
#pragma GCC unroll 6
    for (int i = 1; i < 6; ++i) {
#pragma GCC unroll 6
      for (int j = 0; j < i; ++j) y[i] -= L_[i][j] * y[j];
    }
#pragma GCC unroll 6
    for (int i = 5; i >= 0; --i) {
      y[i] *= inverse_[i];
#pragma GCC unroll 6
      for (int j = i + 1; j < 6; ++j) y[i] -= L_[j][i] * y[j];
    }
    return y;
  }

 private:
  std::array<Vector6, 6> L_;  ///< Below the diagonal.
  Vector6 inverse_;           ///< Of D.
};

/// A point of the dual.
template <int kLanes>
struct Point {
  Vector6 l;
  LaneForces<kLanes> x;   ///< Q'l + bias
  Projection<kLanes> to;  ///< f = P_K(x)
  Vector6 residual;       ///< w - Q f
  double square;          ///< |w - Q f|^2

  /// |w - Q f| / |f|
  [[nodiscard]] double kkt_error() const {
    return square == 0.0 ? 0.0 : std::sqrt(square / std::max(to.f.square().sum(), kTiny));
  }
  /// The error that the rounding of x leaves.
  [[nodiscard]] double rounding() const {
    return kRounding * std::sqrt(x.square().sum() / std::max(to.f.square().sum(), kTiny));
  }
};

/// The planes that touch Coulomb's cones as constraints. Each is made when it is asked for: of the cone that is
/// violated most the one that faces its force.
template <int kLanes>
class TangentPlanes {
 public:
  static constexpr int kSize = 3 * kLanes;  ///< f_n of all lanes, then f_t1, f_t2.
  using Vector = typename ActiveSet<kSize>::Vector;

  /// Violations up to `left` N are left.
  TangentPlanes(double mu, double left) : mu_(mu), left_(left) {}

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
    return {count_++, least, {i, i + kLanes, i + 2 * kLanes}, {mu_, -plane.e_1, -plane.e_2}};
  }

  /// A'u of the planes in the set.
  [[nodiscard]] LaneForces<kLanes> push(const ActiveSet<kSize>& set) const {
    LaneForces<kLanes> push = LaneForces<kLanes>::Zero();
    for (int j = 0; j < set.active; ++j) {
      const Plane& plane = planes_[set.id[j]];
      push(plane.lane, 0) += set.multiplier[j] * mu_;
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

  double mu_, left_;
  int count_ = 0;
  std::array<Plane, kMost> planes_;
};

template <int kLanes>
class Solver {
 public:
  using Lanes = Lane<kLanes>;
  using Forces = LaneForces<kLanes>;

  explicit Solver(const ReducedGrasp<kLanes>& grasp) : grasp_(grasp), cone_(grasp.friction) {
    least_ = std::sqrt(dot(grasp.w, grasp.w));
    scale_ = least_ + std::sqrt(grasp.bias.square().sum());
  }

  ConeResult solve(Forces& f, Vector6& multiplier) {
    Vector6 start = reduced_wrench(grasp_, grasp_.bias);
    for (int k = 0; k < 6; ++k) start[k] = grasp_.w[k] - start[k];
    // Without the cones: often they have no part in it.
    const Forces f_start = combine(grasp_, start) + grasp_.bias;
    bool is_decided = is_optimal(evaluate(start, f_start));
    for (const double left : kLeft) is_decided = is_decided || planes_and_newton(f_start, left);
    if (!is_decided && std::isfinite(residual_)) newton(best_.l, kBorderSteps);

    if (status_ == GraspStatus::kBudgetSpent && residual_ <= kTrusted) status_ = GraspStatus::kOptimal;
    if (status_ == GraspStatus::kOptimal) {
      f = best_.to.f;
      multiplier = best_.l;
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
    point.to = project<kLanes>(x, cone_);
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
    best_ = point;
    if (error > kTrusted || (error > kExact && error > point.rounding())) return false;
    status_ = GraspStatus::kOptimal;
    return true;
  }

  /// Whether the direction proves that there are no forces, after a few Newton steps towards P_K(Q'c) = 0.
  bool is_certificate(Vector6 c) {
    double last = kNearCertificate / kContraction;
    for (int step = 0; step < kPolishSteps; ++step) {
      const double work = dot(grasp_.w, c);
      if (!(work > 0.0)) return false;
      const Forces x = combine(grasp_, c);
      const Projection<kLanes> to = project<kLanes>(x, cone_);
      // What rounding hides of P_K(Q'c) counts, too: at the border the work is no more than that.
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
      const Factors V(grasp_.Q, derivative(to, cone_), kLeastShift);
      c = plus(c, -1.0, V.solve(reduced_wrench(grasp_, to.f)));
    }
    return false;
  }

  /// Newton on the dual from l. True if it decided the problem.
  bool newton(const Vector6& start, int steps);

  /// Newton from the optimum between planes that touch the cones, of which violations up to a share `left` of the
  /// forces remain. True if it decided the problem; where the planes leave no forces, the cones do not.
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
  const Cone cone_;
  double least_;  ///< |w|: the least forces without cones.
  double scale_;
  GraspStatus status_ = GraspStatus::kBudgetSpent;
  int iterations_ = 0;
  double residual_ = std::numeric_limits<double>::infinity();
  Point<kLanes> best_;
  Vector6 certificate_;
};

// Inlined as a whole, as are the planes below: a tenth of the time.
template <int kLanes>
[[gnu::flatten]] bool Solver<kLanes>::newton(const Vector6& start, int steps) {
  Point<kLanes> point = evaluate(start);
  double damping = 1e-3;
  double last = 0.0;
  for (int step = 0;; ++step) {
    if (is_optimal(point)) return true;
    // Of infeasible problems the residual stays: it becomes the part of w that is out of reach.
    if (step > 0 && point.square > 0.1 * last && is_certificate(point.residual)) return true;
    last = point.square;
    if (step == steps) return false;
    ++iterations_;

    const double shift = kLeastShift + damping * std::min(1.0, std::sqrt(point.square) / scale_);
    const Factors V(grasp_.Q, derivative(point.to, cone_), shift);
    const Vector6 direction = V.solve(point.residual);
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
  TangentPlanes<kLanes> planes(cone_.mu, left * std::sqrt(start.square().sum()));
  ActiveSet<3 * kLanes> set;
  for (int k = 0; k < grasp_.rank; ++k) set.basis[set.equalities++] = grasp_.Q[k].reshaped();
  typename TangentPlanes<kLanes>::Vector x = start.reshaped();
  const ActiveSetReport report = thenar::project(planes, set, x);
  iterations_ += report.changes;
  if (report.status == ActiveSetStatus::kBudgetSpent) return false;
  const Forces push = planes.push(set);
  if (report.status == ActiveSetStatus::kInfeasible) return is_certificate(reduced_wrench<kLanes>(grasp_, -push));
  const Forces f = x.reshaped(kLanes, 3);
  return newton(reduced_wrench<kLanes>(grasp_, f - grasp_.bias - push), kNewtonSteps);
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
