// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/exact_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "collision/solids/smooth_body.h"

namespace thenar {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFarthest_m = 1e9;  // Squares stay finite.
constexpr double kOff_m = 0.5e-3, kLeastCosine = 0.82;

enum CylinderFace { kRoundSide, kLowerEnd, kUpperEnd };
enum MugFace { kUnderside, kOuterWall, kRim, kInnerWall, kInnerFloor, kHandle };

Vector3d bounded(const Vector3d& x) { return x.cwiseMax(-kFarthest_m).cwiseMin(kFarthest_m); }

/// Returns the direction of the first of these that has one.
Vector3d direction(const Vector3d& v, const Vector3d& otherwise, const Vector3d& last) {
  constexpr double kNothing_m2 = 1e-40;
  if (v.squaredNorm() > kNothing_m2) return v.normalized();
  return otherwise.squaredNorm() > kNothing_m2 ? otherwise.normalized() : last;
}

Vector3d flat(const Vector3d& v) { return {v[0], v[1], 0.0}; }

/// Returns a form with the curvatures k along t and k_across along normal x t, in the order of their sizes.
SurfaceForm ordered(double distance_m, const Vector3d& point_m, const Vector3d& n, const Vector3d& t, double k,
                    double k_across) {
  if (std::abs(k) >= std::abs(k_across)) return {distance_m, point_m, n, t, k, k_across};
  return {distance_m, point_m, n, n.cross(t), k_across, k};
}

/// Returns the foot on the plane across an axis at `at_m`, with a normal to the side of `side`.
SurfaceForm on_plane(int axis, double at_m, double side, const Vector3d& x) {
  Vector3d foot = x;
  foot[axis] = at_m;
  return {side * (x[axis] - at_m), foot, side * Vector3d::Unit(axis), Vector3d::Unit((axis + 1) % 3), 0.0, 0.0};
}

SurfaceForm on_sphere(double radius_m, const Vector3d& x, const Vector3d& near) {
  const Vector3d n = direction(x, near, Vector3d::UnitZ());
  return {x.dot(n) - radius_m, radius_m * n, n, n.unitOrthogonal(), 1.0 / radius_m, 1.0 / radius_m};
}

/// Returns the foot on a cylinder about z. side: 1 if the solid is inside, -1 if it is outside.
SurfaceForm on_wall(double radius_m, double side, const Vector3d& x, const Vector3d& near) {
  const Vector3d out = direction(flat(x), flat(near), Vector3d::UnitX());
  return {side * (x.dot(out) - radius_m),
          Vector3d(radius_m * out[0], radius_m * out[1], x[2]),
          side * out,
          Vector3d(-out[1], out[0], 0.0),
          side / radius_m,
          0.0};
}

/// Returns the foot on the torus of a mug's handle. Around the rod its curvature is 1/r; along the ring, cos / (R + r
/// cos), cos that of the angle between the normal and the ring's outward direction: inside the ring it is a saddle.
SurfaceForm on_handle(const Mug& mug, const Vector3d& x, const Vector3d& near) {
  const double R = mug.handle->radius_m, r = 0.5 * mug.handle->thickness_m;
  const Vector3d centre(mug.radius_m, 0.0, 0.0), q = x - centre, q_near = near - centre;
  const Vector3d out = direction({q[0], 0.0, q[2]}, {q_near[0], 0.0, q_near[2]}, Vector3d::UnitX());
  const Vector3d along(-out[2], 0.0, out[0]), rod = R * out, off_near = q_near - rod;
  const Vector3d n = direction(q - rod, off_near - along.dot(off_near) * along, Vector3d::UnitY());
  const double cosine = n.dot(out);
  return ordered((q - rod).dot(n) - r, centre + rod + r * n, n, along, cosine / (R + r * cosine), 1.0 / r);
}

/// Returns the foot of x on a circle about z where two faces meet: a ring whose rod has the sharpest curvature. side: 1
/// from outside, where the edge is convex, -1 from inside. Requires x off the circle.
SurfaceForm on_circle(double radius_m, double z_m, double side, const Vector3d& x) {
  const Vector3d out = direction(flat(x), Vector3d::Zero(), Vector3d::UnitX());
  const Vector3d foot(radius_m * out[0], radius_m * out[1], z_m), off = x - foot;
  const double way_m = off.norm();
  const Vector3d n = side / way_m * off, along(-out[1], out[0], 0.0);
  return ordered(side * way_m, foot, n, along, n.dot(out) / radius_m, side * kSharpest_per_m);
}

// Faces. place(shape, face, x, near) is its foot, belongs(shape, face, s, margin) tests whether s is within its edges,
// faces() is their number.

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
  return foot_on(shape, x, near);
}

SurfaceForm place(const SuperquadricShape& shape, int /*face*/, const Vector3d& x, const Vector3d& near) {
  return foot_on(shape, x, near);
}

SurfaceForm place(const CylinderShape& cylinder, int face, const Vector3d& x, const Vector3d& near) {
  if (face == kRoundSide) return on_wall(cylinder.radius_m, 1.0, x, near);
  const double side = face == kLowerEnd ? -1.0 : 1.0;
  return on_plane(2, 0.5 * side * cylinder.length_m, side, x);
}

SurfaceForm place(const Mug& mug, int face, const Vector3d& x, const Vector3d& near) {
  const double half_m = 0.5 * mug.height_m;
  switch (face) {
    case kUnderside:
      return on_plane(2, -half_m, -1.0, x);
    case kOuterWall:
      return on_wall(mug.radius_m, 1.0, x, near);
    case kRim:
      return on_plane(2, half_m, 1.0, x);
    case kInnerWall:
      return on_wall(mug.radius_m - mug.wall_m, -1.0, x, near);
    case kInnerFloor:
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
  if (face == kRoundSide) return std::abs(s[2]) <= 0.5 * cylinder.length_m - margin_m;
  return s.head<2>().norm() <= cylinder.radius_m - margin_m;
}

bool belongs(const Mug& mug, int face, const Vector3d& s, double margin_m) {
  const double rho = s.head<2>().norm(), half_m = 0.5 * mug.height_m, inner_m = mug.radius_m - mug.wall_m;
  switch (face) {
    case kUnderside:
      return rho <= mug.radius_m - margin_m;
    case kOuterWall:
      return std::abs(s[2]) <= half_m - margin_m && (!mug.handle || on_handle(mug, s, s).distance_m >= margin_m);
    case kRim:
      return rho >= inner_m + margin_m && rho <= mug.radius_m - margin_m;
    case kInnerWall:
      return s[2] >= mug.wall_m - half_m + margin_m && s[2] <= half_m - margin_m;
    case kInnerFloor:
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

// A smooth body is one face, whatever the normal of the sample.
int face_of(const SphereShape& sphere, const Vector3d& s, const Vector3d& /*n*/, double /*margin_m*/) {
  return std::abs(s.norm() - sphere.radius_m) <= kOff_m ? 0 : -1;
}

int face_of(const EllipsoidShape& shape, const Vector3d& s, const Vector3d& /*n*/, double /*margin_m*/) {
  return std::abs(distance_estimate_m(shape, s)) <= kOff_m ? 0 : -1;
}

int face_of(const SuperquadricShape& shape, const Vector3d& s, const Vector3d& /*n*/, double /*margin_m*/) {
  return std::abs(distance_estimate_m(shape, s)) <= kOff_m ? 0 : -1;
}

// nearest(shape, x, near) is the nearest point of the whole solid.

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

SurfaceForm nearest(const SuperquadricShape& shape, const Vector3d& x, const Near& near) {
  return nearest_on(shape, x, near);
}

/// Finds the nearest point of the mug without its handle. Its half plane (rho, z) has five lines; at their ends the
/// point is on a circle.
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

/// Finds the nearest point of a mug. Points of the handle's torus inside the mug do not count; from outside of the wall
/// the wall is nearer then.
SurfaceForm nearest(const Mug& mug, const Vector3d& x, const Near& near) {
  SurfaceForm cup = nearest_on_cup(mug, x, near.value_or(x));
  if (!mug.handle || x.head<2>().norm() < mug.radius_m) return cup;
  const SurfaceForm handle = on_handle(mug, x, near.value_or(x));
  const bool is_surface = handle.distance_m < 0.0 || handle.point_m.head<2>().norm() >= mug.radius_m;
  return is_surface && handle.distance_m < cup.distance_m ? handle : cup;
}

/// Visits as std::visit does, which may throw.
template <typename Use>
auto with_body(const ExactShape& shape, const Use& use) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return use(*box);
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return use(*sphere);
  if (const auto* ellipsoid = std::get_if<EllipsoidShape>(&shape)) return use(*ellipsoid);
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) return use(*cylinder);
  if (const auto* superquadric = std::get_if<SuperquadricShape>(&shape)) return use(*superquadric);
  return use(*std::get_if<Mug>(&shape));
}

}  // namespace

int face_at(const ExactShape& shape, const Vector3d& s_m, const Vector3d& n, double margin_m) noexcept {
  return with_body(shape, [&](const auto& body) { return face_of(body, bounded(s_m), n, margin_m); });
}

SurfaceForm foot_on_face(const ExactShape& shape, int face, const Vector3d& x_m, const Vector3d& near_m) noexcept {
  return with_body(shape, [&](const auto& body) { return place(body, face, bounded(x_m), bounded(near_m)); });
}

SurfaceForm nearest_place(const ExactShape& shape, const Vector3d& x_m, const Near& near_m) noexcept {
  const Near near = near_m ? Near(bounded(*near_m)) : Near();
  return with_body(shape, [&](const auto& body) { return nearest(body, bounded(x_m), near); });
}

}  // namespace thenar
