#include "solvers/exact_cone.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {
namespace {

using Vector6 = std::array<double, 6>;

// An optimum is exact at this share of the forces, and trusted up to the second.
constexpr double kExact = 1e-12;
constexpr double kTrusted = 1e-9;
// Forces this many times the least without cones count as none.
constexpr double kOutOfReach = 1e6;
// Q'l and what is made of it lose the last two or three bits.
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 8.0 * kEpsilon;
constexpr double kTiny = std::numeric_limits<double>::min();

// Newton ends most problems in 3 to 6 steps; those that take more than these are the interior point's.
constexpr int kNewtonSteps = 8;
// 4 to 8 steps lead near an optimum that has a multiplier; after 20 rounding has the say.
constexpr int kInteriorSteps = 20;
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

/// Q' l
template <int kLanes>
LaneForces<kLanes> combine(const std::array<LaneForces<kLanes>, 6>& Q, const Vector6& l) {
  LaneForces<kLanes> x = l[0] * Q[0];
  for (int k = 1; k < 6; ++k) x += l[k] * Q[k];
  return x;
}

/// Q f
template <int kLanes>
Vector6 wrench(const std::array<LaneForces<kLanes>, 6>& Q, const LaneForces<kLanes>& f) {
  Vector6 w;
  for (int k = 0; k < 6; ++k) w[k] = (Q[k] * f).sum();
  return w;
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

/// sqrt(s_n^2 - |s_t|^2)
template <int kLanes>
Lane<kLanes> lorentz_norm(const LaneForces<kLanes>& s) {
  const Lane<kLanes> length = (s.col(1).square() + s.col(2).square()).sqrt();
  return ((s.col(0) - length) * (s.col(0) + length)).max(kTiny).sqrt();
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
    Vector6 start = wrench(grasp_.Q, grasp_.bias);
    for (int k = 0; k < 6; ++k) start[k] = grasp_.w[k] - start[k];
    const bool is_decided = newton(start, kNewtonSteps) || interior_point();
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
    point.residual = wrench(grasp_.Q, point.to.f);
    for (int k = 0; k < 6; ++k) point.residual[k] = grasp_.w[k] - point.residual[k];
    point.square = dot(point.residual, point.residual);
    return point;
  }
  Point<kLanes> evaluate(const Vector6& l) const { return evaluate(l, combine(grasp_.Q, l) + grasp_.bias); }

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
      const Forces x = combine(grasp_.Q, c);
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
      c = plus(c, -1.0, V.solve(wrench(grasp_.Q, to.f)));
    }
    return false;
  }

  /// Newton on the dual from l. True if it decided the problem.
  bool newton(const Vector6& start, int steps);

  /// Newton's full steps from l as long as they contract. True if they end in the optimum.
  bool is_near_optimum(const Vector6& l) {
    Point<kLanes> point = evaluate(l);
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kPolishSteps; ++step) {
      if (is_optimal(point)) return true;
      if (point.kkt_error() > std::min(kNearOptimum, kContraction * last)) return false;
      last = point.kkt_error();
      ++iterations_;
      const Factors V(grasp_.Q, derivative(point.to, cone_), kLeastShift);
      point = evaluate(plus(point.l, 1.0, V.solve(point.residual)));
    }
    return is_optimal(point);
  }

  bool interior_point();

  // Each at least a tenth of the bracket.
  static constexpr int kLineSteps = 30;
  // Newton doubles the digits from where it contracts: 1e-2, 1e-4, 1e-8, done.
  static constexpr int kPolishSteps = 4;
  static constexpr double kContraction = 0.3;
  static constexpr double kNearOptimum = 1e-2;
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

template <int kLanes>
bool Solver<kLanes>::newton(const Vector6& start, int steps) {
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
    const Forces dx = combine(grasp_.Q, direction);
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

/// The largest t for which s + t d is in the cone |s_t| <= s_n for all contacts is the inverse of this, if positive.
/// `size` is the Lorentz norm of s.
template <int kLanes>
double inverse_reach(const LaneForces<kLanes>& s, const Lane<kLanes>& size, const LaneForces<kLanes>& d) {
  using Lanes = Lane<kLanes>;
  // In the frame where s is the axis [Vandenberghe, The CVXOPT linear and quadratic cone program solvers, 2010].
  const Lanes r_n = (s.col(0) * d.col(0) - s.col(1) * d.col(1) - s.col(2) * d.col(2)) / size;
  const Lanes k = (r_n + d.col(0)) / (s.col(0) + size);
  const Lanes r_t = ((d.col(1) - k * s.col(1)).square() + (d.col(2) - k * s.col(2)).square()).sqrt();
  return ((r_t - r_n) / size).maxCoeff();
}

/// x in the frame that moves with v, of Lorentz norm one; with sign -1 back again.
template <int kLanes>
LaneForces<kLanes> boost(const LaneForces<kLanes>& v, const LaneForces<kLanes>& x, double sign) {
  const Lane<kLanes> along = v.col(1) * x.col(1) + v.col(2) * x.col(2);
  const Lane<kLanes> k = sign * x.col(0) + along / (1.0 + v.col(0));
  LaneForces<kLanes> y;
  y.col(0) = v.col(0) * x.col(0) + sign * along;
  y.col(1) = x.col(1) + k * v.col(1);
  y.col(2) = x.col(2) + k * v.col(2);
  return y;
}

/// The product of Lorentz's cones: a o b = (a.b, a_n b_t + b_n a_t).
template <int kLanes>
LaneForces<kLanes> jordan(const LaneForces<kLanes>& a, const LaneForces<kLanes>& b) {
  LaneForces<kLanes> c;
  c.col(0) = (a * b).rowwise().sum();
  c.col(1) = a.col(0) * b.col(1) + b.col(0) * a.col(1);
  c.col(2) = a.col(0) * b.col(2) + b.col(0) * a.col(2);
  return c;
}

/// The x of a o x = c, for a of the given Lorentz norm.
template <int kLanes>
LaneForces<kLanes> jordan_quotient(const LaneForces<kLanes>& c, const LaneForces<kLanes>& a, const Lane<kLanes>& norm) {
  LaneForces<kLanes> x;
  x.col(0) = (a.col(0) * c.col(0) - a.col(1) * c.col(1) - a.col(2) * c.col(2)) / norm.square();
  x.col(1) = (c.col(1) - x.col(0) * a.col(1)) / a.col(0);
  x.col(2) = (c.col(2) - x.col(0) * a.col(2)) / a.col(0);
  return x;
}

/// The homogeneous embedding: with s in Lorentz's cones, s = f / (size of the columns), and the forces s / tau,
///     P s - Q'l - z - tau bias = 0,  Q s - tau w = 0,  kappa + s'P s / tau - bias's - w'l = 0,  s, z in K, tau, kappa >= 0
/// has solutions with s'z + tau kappa = 0; if tau > 0 it is an optimum, if kappa > 0 then l is a certificate.
/// P = diag of the columns' squared sizes. Steps follow Nesterov and Todd's scaling.
template <int kLanes>
bool Solver<kLanes>::interior_point() {
  // The cone is Lorentz's for s = (f_n, f_t / mu), or (mu f_n, f_t) where mu > 1. Without friction s_t is there, and does
  // nothing.
  const double mu = grasp_.friction;
  const double part_n = mu > 1.0 ? 1.0 / mu : 1.0;
  const double part_t = mu > 1.0 ? 1.0 : mu;
  Lanes is_used;
  for (int i = 0; i < kLanes; ++i) is_used[i] = i < grasp_.contacts ? 1.0 : 0.0;
  std::array<Forces, 6> Q = grasp_.Q;
  for (Forces& row : Q) {
    row.col(0) *= part_n;
    row.template rightCols<2>() *= part_t;
  }
  Forces bias = grasp_.bias / scale_;
  bias.col(0) *= part_n;
  bias.template rightCols<2>() *= part_t;
  Vector6 w;
  for (int k = 0; k < 6; ++k) w[k] = grasp_.w[k] / scale_;
  const Lanes P_n = is_used * (part_n * part_n);
  const Lanes P_t = is_used * (part_t * part_t);
  const double degree = static_cast<double>(grasp_.contacts) + 1.0;

  Forces s = Forces::Zero();
  s.col(0).setOnes();
  Forces z = s;
  Vector6 l{};
  double tau = 1.0, kappa = 1.0;

  for (int step = 0; step < kInteriorSteps; ++step) {
    ++iterations_;
    Forces Ps;
    Ps.col(0) = P_n * s.col(0);
    Ps.col(1) = P_t * s.col(1);
    Ps.col(2) = P_t * s.col(2);
    const double sPs = (s * Ps).sum();
    const double centre = (((s * z).rowwise().sum() * is_used).sum() + tau * kappa) / degree;
    const Forces rest_s = Ps - combine(Q, l) - z - tau * bias;
    Vector6 rest_l = wrench(Q, s);
    rest_l = plus(rest_l, -tau, w);
    const double rest_tau = kappa + sPs / tau - (bias * s).sum() - dot(w, l);

    // z = H s with H = (2 v v' - J) h, v = (v_n, v_t e) of Lorentz norm one. M = (P + H)^-1 has no difference in it.
    const Lanes s_size = lorentz_norm<kLanes>(s);
    const Lanes z_size = lorentz_norm<kLanes>(z);
    const Lanes h = z_size / s_size;
    const Lanes cosine = (s * z).rowwise().sum() / (s_size * z_size);
    const Lanes half = 0.5 / (0.5 * (1.0 + cosine)).sqrt();
    Forces v;
    v.col(1) = half * (s.col(1) / s_size - z.col(1) / z_size);
    v.col(2) = half * (s.col(2) / s_size - z.col(2) / z_size);
    const Lanes v_t = (v.col(1).square() + v.col(2).square()).sqrt();
    v.col(0) = (1.0 + v_t.square()).sqrt();
    const Lanes e_1 = (v_t > 0.0).select(v.col(1) / v_t, 1.0);
    const Lanes e_2 = (v_t > 0.0).select(v.col(2) / v_t, 0.0);
    const Lanes both = h * (1.0 + 2.0 * v_t.square());
    const Lanes mixed = 2.0 * h * v_t * v.col(0);
    const Blocks<kLanes> H = blocks_about<kLanes>(e_1, e_2, both, -mixed, both, h);
    const Lanes part = is_used / (P_n * P_t + both * (P_n + P_t) + h.square());
    const Blocks<kLanes> M =
        blocks_about<kLanes>(e_1, e_2, part * (P_t + both), part * mixed, part * (P_n + both), is_used / (P_t + h));
    const Factors K(Q, M, kLeastShift);
    const Vector6 l_tau = K.solve(plus(w, -1.0, wrench<kLanes>(Q, M * bias)));
    const Forces s_tau = M * Forces(combine(Q, l_tau) + bias);
    const Forces slope = 2.0 / tau * Ps - bias;
    const double pivot = -kappa / tau + (slope * s_tau).sum() - sPs / (tau * tau) - dot(w, l_tau);

    struct Direction {
      Forces s, z;
      Vector6 l;
      double tau, kappa;
    };
    // Towards s'z = tau kappa = `target`, the other equations' rests times target / centre.
    const auto towards = [&](double target, const Forces& z_bend, double tau_bend) {
      const double share = 1.0 - target / centre;
      Forces z_rest = -z - z_bend;
      const Lanes inverse = target / s_size.square();
      z_rest.col(0) += inverse * s.col(0);
      z_rest.col(1) -= inverse * s.col(1);
      z_rest.col(2) -= inverse * s.col(2);
      for (int column = 0; column < 3; ++column) z_rest.col(column) *= is_used;
      const double tau_rest = target - tau * kappa - tau_bend;
      const Forces rest = z_rest - share * rest_s;
      Vector6 l_0 = wrench<kLanes>(Q, M * rest);
      for (int k = 0; k < 6; ++k) l_0[k] = -share * rest_l[k] - l_0[k];
      l_0 = K.solve(l_0);
      const Forces s_0 = M * Forces(combine(Q, l_0) + rest);
      Direction d;
      d.tau = (-share * rest_tau - tau_rest / tau - (slope * s_0).sum() + dot(w, l_0)) / pivot;
      d.l = plus(l_0, d.tau, l_tau);
      d.s = s_0 + d.tau * s_tau;
      d.z = z_rest - H * d.s;
      d.kappa = (tau_rest - kappa * d.tau) / tau;
      return d;
    };
    const auto reach = [&](const Direction& d) {
      return 1.0 / std::max({kTiny, inverse_reach<kLanes>(s, s_size, d.s), inverse_reach<kLanes>(z, z_size, d.z),
                             -d.tau / tau, -d.kappa / kappa});
    };
    const Direction predicted = towards(0.0, Forces::Zero(), 0.0);
    const double left = 1.0 - std::min(1.0, reach(predicted));
    // What the products of the predicted changes would add [Mehrotra 1992].
    const Forces bend = jordan<kLanes>(boost<kLanes>(v, predicted.s, -1.0), boost<kLanes>(v, predicted.z, 1.0));
    Forces z_bend = boost<kLanes>(v, jordan_quotient<kLanes>(bend, boost<kLanes>(v, z, 1.0), z_size), -1.0);
    for (int column = 0; column < 3; ++column) z_bend.col(column) *= h;
    const Direction d = towards(std::max(1e-6, left * left * left) * centre, z_bend, predicted.tau * predicted.kappa);
    const double length = std::min(1.0, 0.99 * reach(d));
    if (!(length > 1e-10)) return false;
    s += length * d.s;
    z += length * d.z;
    l = plus(l, length, d.l);
    tau += length * d.tau;
    kappa += length * d.kappa;
    const double unit = 1.0 / std::max({tau, kappa, std::sqrt(dot(l, l))});
    s *= unit;
    z *= unit;
    for (double& l_k : l) l_k *= unit;
    tau *= unit;
    kappa *= unit;

    Vector6 l_N;
    for (int k = 0; k < 6; ++k) l_N[k] = l[k] * scale_ / tau;
    if (is_near_optimum(l_N) || is_certificate(l)) return true;
  }
  return false;
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
