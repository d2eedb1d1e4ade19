#include "collision/solids/exact_shape.h"

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

constexpr double kFarthest_m = 1e9;  // Squares stay finite.
constexpr double kOff_m = 0.5e-3, kLeastCosine = 0.82;

enum CylinderFace { kSide, kLowerEnd, kUpperEnd };
enum MugFace { kBottom, kOuterWall, kRim, kInnerWall, kFloor, kHandle };

Vector3d bounded(const Vector3d& x) { return x.cwiseMax(-kFarthest_m).cwiseMin(kFarthest_m); }

/// The direction of the first of these that has one.
Vector3d direction(const Vector3d& v, const Vector3d& otherwise, const Vector3d& last) {
  constexpr double kNothing_m2 = 1e-40;
  if (v.squaredNorm() > kNothing_m2) return v.normalized();
  return otherwise.squaredNorm() > kNothing_m2 ? otherwise.normalized() : last;
}

Vector3d flat(const Vector3d& v) { return {v[0], v[1], 0.0}; }

/// A form with the curvatures k along t and k_across along normal x t, in the order of their sizes.
SurfaceForm ordered(double distance_m, const Vector3d& point_m, const Vector3d& n, const Vector3d& t, double k,
                    double k_across) {
  if (std::abs(k) >= std::abs(k_across)) return {distance_m, point_m, n, t, k, k_across};
  return {distance_m, point_m, n, n.cross(t), k_across, k};
}

/// The plane across an axis at `at_m` on it, whose normal is to the side of `side`.
SurfaceForm on_plane(int axis, double at_m, double side, const Vector3d& x) {
  Vector3d foot = x;
  foot[axis] = at_m;
  return {side * (x[axis] - at_m), foot, side * Vector3d::Unit(axis), Vector3d::Unit((axis + 1) % 3), 0.0, 0.0};
}

SurfaceForm on_sphere(double radius_m, const Vector3d& x, const Vector3d& near) {
  const Vector3d n = direction(x, near, Vector3d::UnitZ());
  return {x.dot(n) - radius_m, radius_m * n, n, n.unitOrthogonal(), 1.0 / radius_m, 1.0 / radius_m};
}

/// A cylinder about z. side: 1 if the solid is within, -1 if it is without.
SurfaceForm on_wall(double radius_m, double side, const Vector3d& x, const Vector3d& near) {
  const Vector3d out = direction(flat(x), flat(near), Vector3d::UnitX());
  return {side * (x.dot(out) - radius_m),
          Vector3d(radius_m * out[0], radius_m * out[1], x[2]),
          side * out,
          Vector3d(-out[1], out[0], 0.0),
          side / radius_m,
          0.0};
}

/// The torus that a mug's handle is part of. Around the rod its curvature is 1/r; along the ring, cos / (R + r cos), cos
/// that of the angle between the normal and the way out of the ring: inside the ring it is a saddle.
SurfaceForm on_handle(const Mug& mug, const Vector3d& x, const Vector3d& near) {
  const double R = mug.handle->radius_m, r = 0.5 * mug.handle->thickness_m;
  const Vector3d centre(mug.radius_m, 0.0, 0.0), q = x - centre, q_near = near - centre;
  const Vector3d out = direction({q[0], 0.0, q[2]}, {q_near[0], 0.0, q_near[2]}, Vector3d::UnitX());
  const Vector3d along(-out[2], 0.0, out[0]), rod = R * out, off_near = q_near - rod;
  const Vector3d n = direction(q - rod, off_near - along.dot(off_near) * along, Vector3d::UnitY());
  const double cosine = n.dot(out);
  return ordered((q - rod).dot(n) - r, centre + rod + r * n, n, along, cosine / (R + r * cosine), 1.0 / r);
}

/// A circle about z where two faces meet, seen from x: as a ring whose rod is as thin as the sharpest curvature says.
/// side: 1 from outside, where the edge is convex, -1 from inside. Requires x off the circle.
SurfaceForm on_circle(double radius_m, double z_m, double side, const Vector3d& x) {
  const Vector3d out = direction(flat(x), Vector3d::Zero(), Vector3d::UnitX());
  const Vector3d foot(radius_m * out[0], radius_m * out[1], z_m), off = x - foot;
  const double way_m = off.norm();
  const Vector3d n = side / way_m * off, along(-out[1], out[0], 0.0);
  return ordered(side * way_m, foot, n, along, n.dot(out) / radius_m, side * kSharpest_per_m);
}

/// The gauge of a convex body: r(s) = 1 on its surface, r(c s) = c r(s). Its gradient and its second derivatives.
struct Gauge {
  double r = 0.0;
  Vector3d gradient = Vector3d::Zero();
  Matrix3d hessian = Matrix3d::Zero();
};

/// A coordinate that is 0 counts as this share of the half size: powers and quotients of it stay finite.
constexpr double kLeastShare = 1e-60;

struct EllipsoidGauge {
  Vector3d half_m;
  static constexpr std::array<bool, 3> creased{false, false, false};

  explicit EllipsoidGauge(const EllipsoidShape& shape) : half_m(0.5 * shape.size_m) {}

  [[nodiscard]] Gauge at(const Vector3d& s) const {
    const Vector3d E = half_m.cwiseAbs2().cwiseInverse(), Es = E.cwiseProduct(s);
    const double r = std::sqrt(s.dot(Es));
    const Vector3d g = Es / r;
    return {r, g, (Matrix3d(E.asDiagonal()) - g * g.transpose()) / r};
  }
};

/// r = N1(N2(x/a, y/b), z/c) of two p-norms with p1 = 2/e1, p2 = 2/e2. By the logarithms l of the coordinates,
/// d(log N)/dl_i is the share of coordinate i in the sum of powers, which neither overflows nor cancels.
struct SuperquadricGauge {
  Vector3d half_m;
  double p1, p2;
  /// Across x = 0, y = 0, z = 0 a power below 2 makes the curvature infinite.
  std::array<bool, 3> creased;

  explicit SuperquadricGauge(const SuperquadricShape& shape)
      : half_m(0.5 * shape.size_m),
        p1(2.0 / shape.exponents.north_south),
        p2(2.0 / shape.exponents.east_west),
        creased{std::min(p1, p2) < 2.0, std::min(p1, p2) < 2.0, p1 < 2.0} {}

  struct Norm {
    double log, share_a, share_b;
  };
  static Norm norm(double log_a, double log_b, double p) {
    const double lesser = std::exp(-p * std::abs(log_a - log_b)), share = 1.0 / (1.0 + lesser);
    const double log = std::max(log_a, log_b) + std::log1p(lesser) / p;
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
    const double A1 = whole.share_a, B1 = whole.share_b, A2 = across.share_a, B2 = across.share_b;
    const double r = std::exp(whole.log);
    const Vector3d g = r * Vector3d(A1 * A2 * inverse[0], A1 * B2 * inverse[1], B1 * inverse[2]);
    const Vector3d a(A2 * inverse[0], B2 * inverse[1], -inverse[2]), b(inverse[0], -inverse[1], 0.0);
    return {r, g, r * (p1 - 1.0) * A1 * B1 * a * a.transpose() + r * (p2 - 1.0) * A1 * A2 * B2 * b * b.transpose()};
  }
};

/// The form at the place of the surface in the direction of s, seen from x. Its curvatures are those of the Hessian
/// across the gradient, over the gradient's size, as they are; none is negative.
template <typename Shape>
SurfaceForm form_at(const Shape& shape, const Vector3d& s, const Vector3d& x) {
  const Gauge at = shape.at(s);
  const double slope = at.gradient.norm();
  const Vector3d point = s / at.r, n = at.gradient / slope, u = n.unitOrthogonal(), v = n.cross(u);
  const Matrix3d K = at.hessian * (at.r / slope);  // The Hessian is of degree -1.
  const Vector3d Ku = K * u;
  const double uu = u.dot(Ku), uv = v.dot(Ku), vv = v.dot(K * v);
  const double mean = 0.5 * (uu + vv), half = 0.5 * (uu - vv), spread = std::sqrt(half * half + uv * uv);
  const Vector2d first = half >= 0.0 ? Vector2d(half + spread, uv) : Vector2d(uv, spread - half);
  const double length = first.norm();
  const Vector3d t1 = length > 0.0 ? Vector3d((first[0] / length) * u + (first[1] / length) * v) : u;
  return {(x - point).dot(n), point, n, t1, mean + spread, std::max(0.0, mean - spread)};
}

/// Newton's step along the surface to where x is over it: (1 + d k_i) step_i = x_i - s_i. Beyond the centre of
/// curvature the distance has a maximum there, from which the step leads away.
Vector3d newton_step(const SurfaceForm& form, const Vector3d& x) {
  const Vector3d t2 = form.normal.cross(form.t1), off = x - form.point_m;
  const double d = form.distance_m;
  return (off.dot(form.t1) / std::max(0.1, 1.0 + d * form.k1_per_m)) * form.t1 +
         (off.dot(t2) / std::max(0.1, 1.0 + d * form.k2_per_m)) * t2;
}

/// The place after a step that is so small that its square is nothing to the form, but not to the place.
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

/// A coordinate is on a crease when it is this share of the half size.
constexpr double kOnCrease = 1e-12;

struct NewtonFoot {
  SurfaceForm form;
  bool converged = false;
};

/// How much of a step stays on this side of the creases. A place on a crease goes along it instead, where the step
/// would cross it.
template <typename Shape>
double part_to_crease(const Shape& shape, const SurfaceForm& at, const Vector3d& x, Vector3d& step) {
  constexpr double kUpTo = 0.99;
  double part = 1.0;
  bool on_crease = false;
  for (int k = 0; k < 3; ++k) {
    if (!shape.creased[k] || (at.point_m[k] + step[k]) * at.point_m[k] > 0.0) continue;
    if (std::abs(at.point_m[k]) > kOnCrease * shape.half_m[k]) continue;
    const Vector3d along = direction(at.normal.cross(Vector3d::Unit(k)), Vector3d::Zero(), Vector3d::Zero());
    const double c = along.dot(at.t1), k_along = c * c * at.k1_per_m + (1.0 - c * c) * at.k2_per_m;
    step = on_crease ? Vector3d(Vector3d::Zero())
                     : Vector3d((x - at.point_m).dot(along) / std::max(0.1, 1.0 + at.distance_m * k_along) * along);
    on_crease = true;
  }
  for (int k = 0; k < 3; ++k) {
    const double to_crease = std::abs(at.point_m[k]);
    if (!shape.creased[k] || (at.point_m[k] + step[k]) * at.point_m[k] > 0.0) continue;
    if (to_crease > kOnCrease * shape.half_m[k]) part = std::min(part, kUpTo * to_crease / std::abs(step[k]));
  }
  return part;
}

/// Steps on from a start; a step that does not come nearer to x is halved.
template <typename Shape>
NewtonFoot newton_foot(const Shape& shape, const Vector3d& x, const Vector3d& start) {
  const double size_m = shape.half_m.maxCoeff();
  constexpr int kMostSteps = 100;
  constexpr double kSmall = 1e-8, kEven = 1e-3, kLeastHalf = 1e-9, kRounding = 4e-16;
  SurfaceForm best = form_at(shape, start, x);
  for (int i = 0; i < kMostSteps;) {
    Vector3d step = newton_step(best, x);
    step *= std::min(1.0, size_m / std::max(step.norm(), kSmall * size_m));
    double part = part_to_crease(shape, best, x, step);
    bool settled = step.squaredNorm() < kSmall * kSmall * size_m * size_m;
    // Powers near a crease are followed by Newton's method only in steps that are small beside the way to it.
    for (int k = 0; k < 3; ++k) {
      const double to_crease = std::abs(best.point_m[k]);
      if (shape.creased[k] && to_crease > kOnCrease * size_m) settled &= std::abs(step[k]) <= kEven * to_crease;
    }
    if (settled) return {moved(best, step, x), true};
    for (;; part *= 0.5, ++i) {
      if (part < kLeastHalf || i >= kMostSteps) return {best, false};
      const SurfaceForm next = form_at(shape, best.point_m + part * step, x);
      // |x - next|^2 - |x - best|^2, without the difference of large numbers.
      const Vector3d way = best.point_m - next.point_m, sum = 2.0 * x - best.point_m - next.point_m;
      if (way.dot(sum) > kRounding * size_m * sum.norm()) continue;
      best = next;
      break;
    }
    ++i;
  }
  return {best, false};
}

/// The foot as it is handed out: with curvatures that are not too sharp. On a crease the gradient does not say which of
/// all the normals there is that towards x outside.
SurfaceForm finished(SurfaceForm form, double size_m, const Vector3d& x) {
  constexpr double kOver = 1e-9;
  const Vector3d off = x - form.point_m, beside = off - form.distance_m * form.normal;
  form.k1_per_m = std::min(form.k1_per_m, kSharpest_per_m);
  form.k2_per_m = std::min(form.k2_per_m, kSharpest_per_m);
  if (form.distance_m <= 0.0 || beside.norm() <= kOver * std::max(size_m, form.distance_m)) return form;
  form.distance_m = off.norm();
  form.normal = off / form.distance_m;
  form.t1 = direction(beside - form.normal.dot(beside) * form.normal, form.t1, form.t1);
  form.k1_per_m = kSharpest_per_m;
  return form;
}

/// Where Newton's method may start: near, or x, or anywhere on the surface, if the body's middle is all that they name.
/// It starts off the creases and on the same side of them as x; or as near, if x is deeper in the body than it is
/// beyond the plane between the sides.
template <typename Shape>
Vector3d start_at(const Shape& shape, const Vector3d& x, const Vector3d& near) {
  constexpr double kMiddle = 1e-3, kOffCrease = 1e-3;
  const auto has_direction = [&](const Vector3d& s) { return s.cwiseQuotient(shape.half_m).norm() > kMiddle; };
  Vector3d s = has_direction(near) ? near : has_direction(x) ? x : Vector3d(0.0, 0.0, shape.half_m[2]);
  if (!shape.creased[0] && !shape.creased[2]) return s;
  const Gauge at = shape.at(x);
  const double depth_m = (1.0 - at.r) / at.gradient.norm();
  for (int k = 0; k < 3; ++k) {
    if (!shape.creased[k]) continue;
    const double side = depth_m > std::abs(x[k]) ? s[k] : x[k];
    s[k] = std::copysign(std::max(std::abs(s[k]), kOffCrease * shape.half_m[k]), side);
  }
  return s;
}

template <typename Shape>
NewtonFoot foot_from(const Shape& shape, const Vector3d& x, const Vector3d& near) {
  NewtonFoot foot = newton_foot(shape, x, start_at(shape, x, near));
  foot.form = finished(foot.form, shape.half_m.maxCoeff(), x);
  return foot;
}

SurfaceForm nearest_on(const EllipsoidShape& shape, const Vector3d& x) {
  const EllipsoidGauge gauge(shape);
  return finished(form_at(gauge, nearest_on_ellipsoid(gauge.half_m, x), x), gauge.half_m.maxCoeff(), x);
}

// Faces. place(shape, face, x, near) is its foot, belongs(shape, face, s, margin) whether s is within its edges, faces()
// how many there are.

int faces(const BoxShape&) { return 6; }
int faces(const CylinderShape&) { return 3; }
int faces(const Mug& mug) { return mug.handle ? 6 : 5; }

SurfaceForm place(const BoxShape& box, int face, const Vector3d& x, const Vector3d& /*near*/) {
  const int axis = face / 2;
  const double side = face % 2 == 0 ? -1.0 : 1.0;
  return on_plane(axis, 0.5 * side * box.size_m[axis], side, x);
}

SurfaceForm place(const SphereShape& sphere, int /*face*/, const Vector3d& x, const Vector3d& near) {
  return on_sphere(sphere.radius_m, x, near);
}

SurfaceForm place(const EllipsoidShape& shape, int /*face*/, const Vector3d& x, const Vector3d& near) {
  const NewtonFoot foot = foot_from(EllipsoidGauge(shape), x, near);
  return foot.converged ? foot.form : nearest_on(shape, x);
}

SurfaceForm place(const CylinderShape& cylinder, int face, const Vector3d& x, const Vector3d& near) {
  if (face == kSide) return on_wall(cylinder.radius_m, 1.0, x, near);
  const double side = face == kLowerEnd ? -1.0 : 1.0;
  return on_plane(2, 0.5 * side * cylinder.length_m, side, x);
}

SurfaceForm place(const SuperquadricShape& shape, int /*face*/, const Vector3d& x, const Vector3d& near) {
  return foot_from(SuperquadricGauge(shape), x, near).form;
}

SurfaceForm place(const Mug& mug, int face, const Vector3d& x, const Vector3d& near) {
  const double half_m = 0.5 * mug.height_m;
  switch (face) {
    case kBottom:
      return on_plane(2, -half_m, -1.0, x);
    case kOuterWall:
      return on_wall(mug.radius_m, 1.0, x, near);
    case kRim:
      return on_plane(2, half_m, 1.0, x);
    case kInnerWall:
      return on_wall(mug.radius_m - mug.wall_m, -1.0, x, near);
    case kFloor:
      return on_plane(2, mug.wall_m - half_m, 1.0, x);
    default:
      return on_handle(mug, x, near);
  }
}

bool belongs(const BoxShape& box, int face, const Vector3d& s, double margin_m) {
  Vector3d room = 0.5 * box.size_m - s.cwiseAbs();
  room[face / 2] = margin_m;
  return room.minCoeff() >= margin_m;
}

bool belongs(const CylinderShape& cylinder, int face, const Vector3d& s, double margin_m) {
  if (face == kSide) return std::abs(s[2]) <= 0.5 * cylinder.length_m - margin_m;
  return s.head<2>().norm() <= cylinder.radius_m - margin_m;
}

bool belongs(const Mug& mug, int face, const Vector3d& s, double margin_m) {
  const double rho = s.head<2>().norm(), half_m = 0.5 * mug.height_m, inner_m = mug.radius_m - mug.wall_m;
  switch (face) {
    case kBottom:
      return rho <= mug.radius_m - margin_m;
    case kOuterWall:
      return std::abs(s[2]) <= half_m - margin_m && (!mug.handle || on_handle(mug, s, s).distance_m >= margin_m);
    case kRim:
      return rho >= inner_m + margin_m && rho <= mug.radius_m - margin_m;
    case kInnerWall:
      return s[2] >= mug.wall_m - half_m + margin_m && s[2] <= half_m - margin_m;
    case kFloor:
      return rho <= inner_m - margin_m;
    default:
      return rho >= mug.radius_m + margin_m;
  }
}

template <typename Shape>
int face_of(const Shape& shape, const Vector3d& s, const Vector3d& n, double margin_m) {
  for (int face = 0; face < faces(shape); ++face) {
    const SurfaceForm at = place(shape, face, s, s);
    if (std::abs(at.distance_m) > kOff_m || n.dot(at.normal) < kLeastCosine) continue;
    return belongs(shape, face, s, margin_m) ? face : -1;
  }
  return -1;
}

// Smooth bodies are one face, whatever the normal of the sample.
int face_of(const SphereShape& sphere, const Vector3d& s, const Vector3d& /*n*/, double /*margin_m*/) {
  return std::abs(s.norm() - sphere.radius_m) <= kOff_m ? 0 : -1;
}
template <typename Gauge>
int face_of_gauge(const Gauge& gauge, const Vector3d& s) {
  return std::abs(form_at(gauge, start_at(gauge, s, s), s).distance_m) <= kOff_m ? 0 : -1;
}
int face_of(const EllipsoidShape& shape, const Vector3d& s, const Vector3d& /*n*/, double /*margin_m*/) {
  return face_of_gauge(EllipsoidGauge(shape), s);
}
int face_of(const SuperquadricShape& shape, const Vector3d& s, const Vector3d& /*n*/, double /*margin_m*/) {
  return face_of_gauge(SuperquadricGauge(shape), s);
}

// nearest(shape, x, near) is the nearest place of the whole solid.

using Near = std::optional<Vector3d>;

SurfaceForm nearest(const BoxShape& box, const Vector3d& x, const Near& /*near*/) {
  const Foot at = *foot(Solid(box), 0, x);
  int axis = 0;
  if (at.normal.cwiseAbs().maxCoeff(&axis) == 1.0) return place(box, 2 * axis + (at.normal[axis] > 0.0 ? 1 : 0), x, x);
  // An edge is along the axis that the normal has no part of; a corner is sharp both ways.
  const Vector3d point = x.cwiseMax(-0.5 * box.size_m).cwiseMin(0.5 * box.size_m);
  int along = 0;
  const bool is_edge = at.normal.cwiseAbs().minCoeff(&along) == 0.0;
  const Vector3d t1 = is_edge ? Vector3d(at.normal.cross(Vector3d::Unit(along))) : at.normal.unitOrthogonal();
  return {at.gap_m, point, at.normal, t1, kSharpest_per_m, is_edge ? 0.0 : kSharpest_per_m};
}

SurfaceForm nearest(const SphereShape& sphere, const Vector3d& x, const Near& near) {
  return on_sphere(sphere.radius_m, x, near.value_or(x));
}

SurfaceForm nearest(const EllipsoidShape& shape, const Vector3d& x, const Near& /*near*/) {
  return nearest_on(shape, x);
}

SurfaceForm nearest(const CylinderShape& cylinder, const Vector3d& x, const Near& near) {
  const double half_m = 0.5 * cylinder.length_m;
  const auto at = foot(Solid(cylinder), 0, x);
  if (at && at->on == Foot::On::kEdge) return on_circle(cylinder.radius_m, std::copysign(half_m, x[2]), 1.0, x);
  if (at && at->on == Foot::On::kFlat) return place(cylinder, at->normal[2] < 0.0 ? kLowerEnd : kUpperEnd, x, x);
  return on_wall(cylinder.radius_m, 1.0, x, near.value_or(x));
}

/// Outside of a convex body a place where Newton's method comes to is the nearest one. Inside it may be one of several:
/// that near where it starts, or the nearest that is found from starts all over the surface.
SurfaceForm nearest(const SuperquadricShape& shape, const Vector3d& x, const Near& near) {
  const SuperquadricGauge gauge(shape);
  NewtonFoot best = foot_from(gauge, x, near.value_or(x));
  if (best.converged && (near || best.form.distance_m > 0.0)) return best.form;
  // The nearest place has no coordinate of another sign than x.
  for (int corner = 1; corner < 8; ++corner) {
    Vector3d start;
    for (int k = 0; k < 3; ++k) start[k] = (corner >> k & 1) != 0 ? std::copysign(gauge.half_m[k], x[k]) : 0.0;
    const NewtonFoot other = foot_from(gauge, x, start);
    if (std::abs(other.form.distance_m) < std::abs(best.form.distance_m)) best = other;
  }
  return best.form;
}

/// The mug without its handle. Its half plane (rho, z) has five lines; from one of their ends the place is on a circle.
SurfaceForm nearest_on_cup(const Mug& mug, const Vector3d& x, const Vector3d& near) {
  const double R = mug.radius_m, inner_m = R - mug.wall_m, top_m = 0.5 * mug.height_m, floor_m = mug.wall_m - top_m;
  const std::array<Vector2d, 6> outline{Vector2d(0.0, -top_m),    Vector2d(R, -top_m),        Vector2d(R, top_m),
                                        Vector2d(inner_m, top_m), Vector2d(inner_m, floor_m), Vector2d(0.0, floor_m)};
  const Vector2d at(x.head<2>().norm(), x[2]);
  double least_m2 = 0.0, part = 0.0;
  int line = -1;
  for (int i = 0; i < 5; ++i) {
    const Vector2d along = outline[i + 1] - outline[i];
    const double here = (at - outline[i]).dot(along) / along.squaredNorm();
    const double off_m2 = (at - outline[i] - std::clamp(here, 0.0, 1.0) * along).squaredNorm();
    if (line >= 0 && off_m2 >= least_m2) continue;
    least_m2 = off_m2;
    line = i;
    part = here;
  }
  // The outline is in the order of the faces. Its ends on the axis are no edges: beyond them there is no rho.
  const Vector2d& corner = outline[part < 0.5 ? line : line + 1];
  if ((part >= 0.0 && part <= 1.0) || at == corner) return place(mug, line, x, near);
  const bool inside = at[0] < R && std::abs(at[1]) < top_m && (at[0] > inner_m || at[1] < floor_m);
  return on_circle(corner[0], corner[1], inside ? -1.0 : 1.0, x);
}

/// Places of the handle's torus that are in the mug are none; from outside of the wall the wall is nearer then.
SurfaceForm nearest(const Mug& mug, const Vector3d& x, const Near& near) {
  const SurfaceForm cup = nearest_on_cup(mug, x, near.value_or(x));
  if (!mug.handle || x.head<2>().norm() < mug.radius_m) return cup;
  const SurfaceForm handle = on_handle(mug, x, near.value_or(x));
  const bool is_surface = handle.distance_m < 0.0 || handle.point_m.head<2>().norm() >= mug.radius_m;
  return is_surface && handle.distance_m < cup.distance_m ? handle : cup;
}

}  // namespace

int face_at(const ExactShape& shape, const Vector3d& s_m, const Vector3d& n, double margin_m) noexcept {
  return std::visit([&](const auto& body) { return face_of(body, bounded(s_m), n, margin_m); }, shape);
}

SurfaceForm foot_on_face(const ExactShape& shape, int face, const Vector3d& x_m, const Vector3d& near_m) noexcept {
  return std::visit([&](const auto& body) { return place(body, face, bounded(x_m), bounded(near_m)); }, shape);
}

SurfaceForm nearest_place(const ExactShape& shape, const Vector3d& x_m, const Near& near_m) noexcept {
  const Near near = near_m ? Near(bounded(*near_m)) : Near();
  return std::visit([&](const auto& body) { return nearest(body, bounded(x_m), near); }, shape);
}

}  // namespace thenar
