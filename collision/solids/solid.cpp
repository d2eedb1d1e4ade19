// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace thenar {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A point this far in the corner of a hole's wall and floor is in both.
constexpr double kCorner_m = 1e-4;

/// The foot on a convex solid whose faces are q <= 0: distance from them all, and its part along each.
template <typename Vector>
struct Nearest {
  double gap_m;
  Vector along;
  bool on_edge;
};

template <typename Vector>
Nearest<Vector> nearest(const Vector& q) {
  const Vector outside = q.cwiseMax(0.0);
  const auto faces = (q.array() > 0.0).count();
  if (faces == 0) {
    Eigen::Index most = 0;
    const double depth = q.maxCoeff(&most);
    return {depth, Vector::Unit(most), false};
  }
  const double gap = outside.norm();
  return {gap, outside / gap, faces > 1};
}

/// Returns the foot on a solid of revolution from its half plane (rho, z).
Vector3d turned(const Vector2d& normal, const Vector3d& x, double rho) {
  if (rho == 0.0) return {0.0, 0.0, normal[1]};
  return {normal[0] * x[0] / rho, normal[0] * x[1] / rho, normal[1]};
}

std::optional<Foot> foot_of(const HalfSpace&, int /*facet*/, const Vector3d& x) {
  return Foot{x[2], Vector3d::UnitZ()};
}

std::optional<Foot> foot_of(const BoxShape& box, int /*facet*/, const Vector3d& x) {
  const Nearest<Vector3d> at = nearest<Vector3d>(x.cwiseAbs() - 0.5 * box.size_m);
  Vector3d normal;
  for (int i = 0; i < 3; ++i) normal[i] = std::copysign(at.along[i], x[i]);
  return Foot{at.gap_m, normal, at.on_edge ? Foot::On::kEdge : Foot::On::kFlat};
}

std::optional<Foot> foot_of(const SphereShape& sphere, int /*facet*/, const Vector3d& x) {
  const double r = x.norm();
  if (r == 0.0) return std::nullopt;
  return Foot{r - sphere.radius_m, x / r, Foot::On::kRound};
}

std::optional<Foot> foot_of(const CylinderShape& cylinder, int /*facet*/, const Vector3d& x) {
  const double rho = x.head<2>().norm();
  const Nearest<Vector2d> at = nearest<Vector2d>({rho - cylinder.radius_m, std::abs(x[2]) - 0.5 * cylinder.length_m});
  if (rho == 0.0 && at.along[0] > 0.0) return std::nullopt;
  const Foot::On face = at.along[0] > 0.0 ? Foot::On::kRound : Foot::On::kFlat;
  return Foot{at.gap_m, turned({at.along[0], std::copysign(at.along[1], x[2])}, x, rho),
              at.on_edge ? Foot::On::kEdge : face};
}

enum HoleFacet { kPlate, kWall, kFloor };

/// The nearest part of a hole's plate, chamfer and bore, which bound a convex region of the half plane (rho, z): a
/// through hole.
struct MouthFoot {
  HoleFacet facet;
  double gap_m;
  Vector2d normal;
  Foot::On on;
};

MouthFoot mouth_foot(const HoleShape& hole, const Vector2d& at) {
  const double c = hole.chamfer_m;
  const Vector2d lower = at - Vector2d(hole.radius_m, -c), upper = at - Vector2d(hole.radius_m + c, 0.0);
  const Vector2d up = Vector2d(1.0, 1.0).normalized(), out = Vector2d(-1.0, 1.0).normalized();
  const double over_plate = at[1], over_chamfer = out.dot(lower), over_bore = -lower[0];
  const MouthFoot plate{kPlate, over_plate, {0.0, 1.0}, Foot::On::kFlat},
      chamfer{kWall, over_chamfer, out, Foot::On::kRound}, bore{kWall, over_bore, {-1.0, 0.0}, Foot::On::kRound};
  const auto edge = [](const Vector2d& v, const MouthFoot& face) {
    const double gap = v.norm();
    return gap > 0.0 ? MouthFoot{kWall, gap, v / gap, Foot::On::kEdge} : face;
  };
  if (over_plate <= 0.0 && over_bore <= 0.0 && (c == 0.0 || over_chamfer <= 0.0)) {  // In the solid.
    const MouthFoot& least = over_plate > over_bore ? plate : bore;
    return c > 0.0 && over_chamfer > least.gap_m ? chamfer : least;
  }
  if (upper[0] >= 0.0) return plate;
  if (lower[1] <= 0.0) return bore;
  if (c == 0.0 || upper.dot(up) >= 0.0) return edge(upper, plate);
  return lower.dot(up) <= 0.0 ? edge(lower, bore) : chamfer;
}

std::optional<Foot> foot_of(const HoleShape& hole, int facet, const Vector3d& x) {
  const double rho = x.head<2>().norm();
  if (facet == kFloor) {
    if (rho > hole.radius_m + kCorner_m || x[2] > -hole.chamfer_m) return std::nullopt;
    return Foot{x[2] + hole.depth_m, Vector3d::UnitZ()};
  }
  const MouthFoot at = mouth_foot(hole, {rho, x[2]});
  if (at.facet != facet || x[2] < -hole.depth_m - kCorner_m) return std::nullopt;
  if (rho == 0.0 && at.normal[0] != 0.0) return std::nullopt;
  return Foot{at.gap_m, turned(at.normal, x, rho), at.on};
}

Feature point(const Vector3d& at, double round_m = 0.0) { return {.a_m = at, .round_m = round_m}; }

Feature segment(const Vector3d& from, const Vector3d& to, double round_m = 0.0) {
  return {Feature::Kind::kSegment, from, to, 0.0, round_m};
}

Feature circle(double z, double radius_m) {
  return {Feature::Kind::kCircle, {0.0, 0.0, z}, Vector3d::Zero(), radius_m, 0.0};
}

std::vector<Feature> features_of(const HalfSpace&) { return {}; }

std::vector<Feature> features_of(const SphereShape& sphere) { return {point(Vector3d::Zero(), sphere.radius_m)}; }

std::vector<Feature> features_of(const CylinderShape& cylinder) {
  const double half = 0.5 * cylinder.length_m;
  return {circle(-half, cylinder.radius_m), circle(half, cylinder.radius_m),
          segment({0.0, 0.0, -half}, {0.0, 0.0, half}, cylinder.radius_m)};
}

std::vector<Feature> features_of(const BoxShape& box) {
  const auto corner = [&](int i) {
    return Vector3d(0.5 * box.size_m.cwiseProduct(Vector3d((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0,
                                                           (i & 4) != 0 ? 1.0 : -1.0)));
  };
  std::vector<Feature> all;
  for (int i = 0; i < 8; ++i) all.push_back(point(corner(i)));
  for (int axis = 1; axis <= 4; axis *= 2) {
    for (int i = 0; i < 8; ++i) {
      if ((i & axis) == 0) all.push_back(segment(corner(i), corner(i | axis)));
    }
  }
  return all;
}

std::vector<Feature> features_of(const HoleShape& hole) {
  std::vector<Feature> all{circle(0.0, hole.radius_m + hole.chamfer_m)};
  if (hole.chamfer_m > 0.0) all.push_back(circle(-hole.chamfer_m, hole.radius_m));
  return all;
}

}  // namespace

int facets(const Solid& solid) { return std::holds_alternative<HoleShape>(solid) ? 3 : 1; }

std::optional<Foot> foot(const Solid& solid, int facet, const Vector3d& x) {
  return std::visit([&](const auto& shape) { return foot_of(shape, facet, x); }, solid);
}

std::vector<Feature> features(const Solid& solid) {
  return std::visit([](const auto& shape) { return features_of(shape); }, solid);
}

double reach_m(const Solid& solid) {
  if (const auto* box = std::get_if<BoxShape>(&solid)) return 0.5 * box->size_m.norm();
  if (const auto* sphere = std::get_if<SphereShape>(&solid)) return sphere->radius_m;
  if (const auto* cylinder = std::get_if<CylinderShape>(&solid))
    return std::hypot(cylinder->radius_m, 0.5 * cylinder->length_m);
  return std::numeric_limits<double>::infinity();
}

}  // namespace thenar
