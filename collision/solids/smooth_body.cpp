// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/smooth_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "collision/ellipsoid.h"

namespace thenar {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// The gauge of a convex body: r(s) = 1 on its surface, r(c s) = c r(s). Its gradient and its second derivatives.
struct Gauge {
  double r = 0.0;
  Vector3d gradient = Vector3d::Zero();
  Matrix3d hessian = Matrix3d::Zero();
};

/// A coordinate that is 0 counts as this share of the half size: powers and quotients of it stay finite.
constexpr double kLeastShare = 1e-60;

/// A flag for each of the planes x = 0, y = 0, z = 0.
using Planes = std::array<bool, 3>;

struct EllipsoidGauge {
  Vector3d half_m, E;  // E the inverse squares.
  Planes creased{false, false, false};
  bool has_sharp_poles = false;

  explicit EllipsoidGauge(const EllipsoidShape& shape)
      : half_m(0.5 * shape.size_m), E(half_m.cwiseAbs2().cwiseInverse()) {}

  [[nodiscard]] Gauge at(const Vector3d& s) const {
    const Vector3d Es = E.cwiseProduct(s);
    const double r = std::sqrt(s.dot(Es)), part = 1.0 / r;
    const Vector3d g = part * Es;
    return {r, g, part * (Matrix3d(E.asDiagonal()) - g * g.transpose())};
  }
};

/// r = N1(N2(x/a, y/b), z/c) of two p-norms with p1 = 2/e1, p2 = 2/e2. By the logarithms l of the coordinates,
/// d(log N)/dl_i is the share of coordinate i in the sum of powers, which neither overflows nor cancels.
struct SuperquadricGauge {
  Vector3d half_m;
  double p1, p2;
  Planes creased;        ///< Across them the curvature is infinite, by a power below 2.
  bool has_sharp_poles;  ///< On the axis z, all around.

  explicit SuperquadricGauge(const SuperquadricShape& shape)
      : half_m(0.5 * shape.size_m),
        p1(2.0 / shape.exponents.north_south),
        p2(2.0 / shape.exponents.east_west),
        creased{p2 < 2.0, p2 < 2.0, p1 < 2.0},
        has_sharp_poles(p1 < 2.0) {}

  struct Norm {
    double log, share_a, share_b;
  };
  static Norm norm(double log_a, double log_b, double p) {
    const double lesser = std::exp(-p * std::abs(log_a - log_b)), share = 1.0 / (1.0 + lesser);
    const double log = std::max(log_a, log_b) + std::log(1.0 + lesser) / p;
    return log_a > log_b ? Norm{log, share, lesser * share} : Norm{log, lesser * share, share};
  }

  [[nodiscard]] Gauge at(const Vector3d& s) const {
    Vector3d log, inverse;
    for (int i = 0; i < 3; ++i) {
      const double share = std::max(std::abs(s[i]) / half_m[i], kLeastShare);
      log[i] = std::log(share);
      inverse[i] = std::copysign(1.0 / (share * half_m[i]), s[i]);
    }
    const Norm across = norm(log[0], log[1], p2), whole = norm(across.log, log[2], p1);
    const double u1 = whole.share_a, v1 = whole.share_b, u2 = across.share_a, v2 = across.share_b;
    const double r = std::exp(whole.log);
    const Vector3d g = r * Vector3d(u1 * u2 * inverse[0], u1 * v2 * inverse[1], v1 * inverse[2]);
    const Vector3d a(u2 * inverse[0], v2 * inverse[1], -inverse[2]), b(inverse[0], -inverse[1], 0.0);
    return {r, g, r * (p1 - 1.0) * u1 * v1 * a * a.transpose() + r * (p2 - 1.0) * u1 * u2 * v2 * b * b.transpose()};
  }
};

/// A point of a convex surface relative to x: u and v span its tangent plane, in which the Hessian over the size of the
/// gradient has the components uu, uv, vv.
struct Tangent {
  double distance_m;
  Vector3d point_m, n, u, v;
  double uu, uv, vv;

  /// Its eigenvalues are mean + spread and mean - spread, none of which is negative.
  [[nodiscard]] double mean() const { return 0.5 * (uu + vv); }
  [[nodiscard]] double spread() const { return std::sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv); }
};

/// Returns the surface point in the direction of s.
template <typename Shape>
Tangent tangent_at(const Shape& shape, const Vector3d& s, const Vector3d& x) {
  const Gauge at = shape.at(s);
  const double per_slope = 1.0 / at.gradient.norm();
  const Vector3d point = s / at.r, n = per_slope * at.gradient;
  // Two unit vectors across n without a root [Duff et al. 2017].
  const double side = std::copysign(1.0, n[2]), a = -1.0 / (side + n[2]), b = a * n[0] * n[1];
  const Vector3d u(1.0 + side * a * n[0] * n[0], side * b, -side * n[0]), v(b, side + a * n[1] * n[1], -n[1]);
  const double size = at.r * per_slope;  // The Hessian is of degree -1.
  const Vector3d Hu = at.hessian * u, Hv = at.hessian * v;
  return {(x - point).dot(n), point, n, u, v, size * u.dot(Hu), size * v.dot(Hu), size * v.dot(Hv)};
}

SurfaceForm principal(const Tangent& at) {
  const double half = 0.5 * (at.uu - at.vv), spread = at.spread();
  const Vector2d first = half >= 0.0 ? Vector2d(half + spread, at.uv) : Vector2d(at.uv, spread - half);
  constexpr double kFlat_per_m = 1e-100;  // Squares of less are no numbers.
  const double length = first.norm();
  const Vector3d t1 = length > kFlat_per_m ? Vector3d((first[0] / length) * at.u + (first[1] / length) * at.v) : at.u;
  return {at.distance_m, at.point_m, at.n, t1, at.mean() + spread, std::max(0.0, at.mean() - spread)};
}

/// From beyond the centre of curvature the distance has a maximum below x. Newton's step is then that of a point before
/// it, which leads away from there.
constexpr double kMostDepth = 0.9;

/// Computes Newton's step along the surface to the foot of x: (1 + d K) step = x - s.
Vector3d newton_step(const Tangent& at, const Vector3d& x) {
  const Vector3d off = x - at.point_m;
  double d = at.distance_m;
  if (d < 0.0) d = std::max(d, -kMostDepth / (at.mean() + at.spread()));
  const double a = 1.0 + d * at.uu, b = d * at.uv, c = 1.0 + d * at.vv, off_u = off.dot(at.u), off_v = off.dot(at.v);
  // The determinant of 1 + d K, without the difference of large numbers where K is large in one direction alone.
  const double part = 1.0 / (1.0 + d * (at.uu + at.vv) + d * d * std::max(0.0, at.uu * at.vv - at.uv * at.uv));
  return part * (c * off_u - b * off_v) * at.u + part * (a * off_v - b * off_u) * at.v;
}

/// Returns the point after a step whose square is negligible for the form, but not for the point.
SurfaceForm moved(const SurfaceForm& form, const Vector3d& step, const Vector3d& x) {
  constexpr double kMostTurn = 1e-3;
  const Vector3d t2 = form.normal.cross(form.t1);
  const double s1 = step.dot(form.t1), s2 = step.dot(t2), k1 = form.k1_per_m, k2 = form.k2_per_m;
  if (k1 * step.norm() > kMostTurn) return form;  // At a crease; see finished().
  SurfaceForm to = form;
  to.point_m += step - 0.5 * (k1 * s1 * s1 + k2 * s2 * s2) * form.normal;
  to.normal = (form.normal + k1 * s1 * form.t1 + k2 * s2 * t2).normalized();
  to.t1 = (form.t1 - form.t1.dot(to.normal) * to.normal).normalized();
  to.distance_m = (x - to.point_m).dot(to.normal);
  return to;
}

struct NewtonFoot {
  SurfaceForm form;
  bool converged = false;
};

/// Tests whether a point is in a plane of symmetry, to a fraction of the half size across it.
bool is_at(const Tangent& at, const Vector3d& half_m, int k) {
  constexpr double kShare = 1e-12;
  return std::abs(at.point_m[k]) <= kShare * half_m[k];
}

/// Returns a step that stays on this side of the walls. At a wall a step that would cross it goes along it.
Vector3d within_walls(const Planes& walls, const Vector3d& half_m, const Tangent& at, const Vector3d& x,
                      Vector3d step) {
  constexpr double kUpTo = 0.99;
  const auto crosses = [&](int k) { return walls[k] && (at.point_m[k] + step[k]) * at.point_m[k] <= 0.0; };
  int crossed = 0;
  for (const int k : {0, 1, 2, 0, 1}) {  // Along one wall the step may cross another one.
    if (!crosses(k) || !is_at(at, half_m, k) || step[k] == 0.0) continue;
    if (++crossed > 1) return Vector3d::Zero();
    const Vector3d along = at.n.cross(Vector3d::Unit(k)).normalized();
    const double c = along.dot(at.u), s = along.dot(at.v), K = c * c * at.uu + 2.0 * c * s * at.uv + s * s * at.vv;
    step = (x - at.point_m).dot(along) / std::max(1.0 - kMostDepth, 1.0 + at.distance_m * K) * along;
    step[k] = 0.0;
  }
  double part = 1.0;
  for (int k = 0; k < 3; ++k) {
    if (crosses(k) && !is_at(at, half_m, k)) part = std::min(part, kUpTo * std::abs(at.point_m[k]) / std::abs(step[k]));
  }
  return part * step;
}

/// Iterates from a start; a step that does not come nearer to x is halved. At a sharp pole many are: a step begins with
/// the last one's factor, or slightly more.
template <typename Shape>
NewtonFoot newton_foot(const Shape& shape, const Vector3d& x, const Vector3d& start) {
  const double size_m = shape.half_m.maxCoeff();
  constexpr int kMostTrials = 120;
  constexpr double kSmall = 1e-8, kEven = 1e-3, kRounding = 4e-16, kMore = 8.0;
  Tangent best = tangent_at(shape, start, x);
  double part = 1.0;
  int trial = 0;
  while (true) {
    Vector3d step = newton_step(best, x);
    if (step.squaredNorm() > size_m * size_m) step *= size_m / step.norm();
    step = within_walls(shape.creased, shape.half_m, best, x, step);
    bool settled = step.squaredNorm() < kSmall * kSmall * size_m * size_m;
    // Powers near a crease are followed by Newton's method only in steps that are small beside the way to it.
    for (int k = 0; k < 3; ++k) {
      if (shape.creased[k] && !is_at(best, shape.half_m, k))
        settled = settled && std::abs(step[k]) <= kEven * std::abs(best.point_m[k]);
    }
    if (settled) return {moved(principal(best), step, x), true};
    for (part = std::min(1.0, kMore * part);; part *= 0.5) {
      if (++trial > kMostTrials) return {principal(best), false};
      const Tangent next = tangent_at(shape, best.point_m + part * step, x);
      // |x - next|^2 - |x - best|^2, without the difference of large numbers.
      const Vector3d way = best.point_m - next.point_m, sum = 2.0 * x - best.point_m - next.point_m;
      if (way.dot(sum) > kRounding * size_m * sum.lpNorm<1>()) continue;
      best = next;
      break;
    }
  }
}

/// Returns the final foot: curvatures are bounded. The gradient at a crease is one of all the normals there; from
/// outside the one towards x counts. Also tells whether the method got stuck there.
template <typename Shape>
NewtonFoot finished(const Shape& shape, NewtonFoot foot, const Vector3d& x) {
  constexpr double kOver = 1e-11;
  SurfaceForm& form = foot.form;
  form.k1_per_m = std::min(form.k1_per_m, kSharpest_per_m);
  form.k2_per_m = std::min(form.k2_per_m, kSharpest_per_m);
  const Vector3d off = x - form.point_m, beside = off - form.distance_m * form.normal, gradient = form.normal;
  const double least_m2 = kOver * kOver * std::max(shape.half_m.squaredNorm(), off.squaredNorm());
  if (beside.squaredNorm() <= least_m2 || shape.at(x).r <= 1.0) return foot;
  form.distance_m = off.norm();
  form.normal = off / form.distance_m;
  form.t1 = form.normal.cross(gradient).cross(form.normal).normalized();
  form.k1_per_m = kSharpest_per_m;
  return {form, false};
}

/// Returns the start of Newton's method: at near, or x, or anywhere on the surface if both are the body's middle.
///
/// The start is off creases and sharp poles, on the same side as x; or as near, if x is deeper in the body than it is
/// beyond the plane between the sides.
template <typename Shape>
Vector3d start_at(const Shape& shape, const Vector3d& x, const Vector3d& near) {
  constexpr double kMiddle = 1e-3, kOff = 1e-3;
  const auto share = [&](const Vector3d& s) { return Vector3d(s.cwiseAbs().cwiseQuotient(shape.half_m)); };
  Vector3d s = share(near).norm() > kMiddle ? near
               : share(x).norm() > kMiddle  ? x
                                            : shape.half_m[2] * Vector3d::UnitZ();
  if (!shape.creased[0] && !shape.has_sharp_poles) return s;
  const Gauge at = shape.at(x);
  const double depth_m = (1.0 - at.r) / at.gradient.norm();
  const bool at_pole = shape.has_sharp_poles && share(s).template head<2>().maxCoeff() < kOff;
  for (int k = 0; k < 3; ++k) {
    if (!shape.creased[k] && !at_pole) continue;
    const double side = depth_m > std::abs(x[k]) ? s[k] : x[k];
    s[k] = std::copysign(std::max(std::abs(s[k]), kOff * shape.half_m[k]), side);
  }
  return s;
}

template <typename Shape>
NewtonFoot foot_from(const Shape& shape, const Vector3d& x, const Vector3d& near) {
  return finished(shape, newton_foot(shape, x, start_at(shape, x, near)), x);
}

template <typename Shape>
double first_order_m(const Shape& shape, const Vector3d& x) {
  return tangent_at(shape, start_at(shape, x, x), x).distance_m;
}

}  // namespace

SurfaceForm foot_on(const EllipsoidShape& shape, const Vector3d& x, const Vector3d& near) noexcept {
  const NewtonFoot foot = foot_from(EllipsoidGauge(shape), x, near);
  return foot.converged ? foot.form : nearest_on(shape, x);
}

SurfaceForm foot_on(const SuperquadricShape& shape, const Vector3d& x, const Vector3d& near) noexcept {
  return foot_from(SuperquadricGauge(shape), x, near).form;
}

SurfaceForm nearest_on(const EllipsoidShape& shape, const Vector3d& x) noexcept {
  const EllipsoidGauge gauge(shape);
  return finished(gauge, {principal(tangent_at(gauge, nearest_on_ellipsoid(gauge.half_m, x), x)), true}, x).form;
}

// Outside of a convex body a foot that x is over is the nearest one. There are others on the far side.
SurfaceForm nearest_on(const SuperquadricShape& shape, const Vector3d& x,
                       const std::optional<Vector3d>& near) noexcept {
  const SuperquadricGauge gauge(shape);
  NewtonFoot best = foot_from(gauge, x, near.value_or(x));
  if (best.converged && (best.form.distance_m > 0.0 || (near && gauge.at(x).r <= 1.0))) return best.form;
  // The nearest place has no coordinate of another sign than x.
  for (int corner = 1; corner < 8; ++corner) {
    Vector3d start;
    for (int k = 0; k < 3; ++k) start[k] = (corner >> k & 1) != 0 ? std::copysign(gauge.half_m[k], x[k]) : 0.0;
    const NewtonFoot other = foot_from(gauge, x, start);
    if (std::abs(other.form.distance_m) < std::abs(best.form.distance_m)) best = other;
  }
  return best.form;
}

double distance_estimate_m(const EllipsoidShape& shape, const Vector3d& x) noexcept {
  return first_order_m(EllipsoidGauge(shape), x);
}

double distance_estimate_m(const SuperquadricShape& shape, const Vector3d& x) noexcept {
  return first_order_m(SuperquadricGauge(shape), x);
}

}  // namespace thenar
