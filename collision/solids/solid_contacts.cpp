// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/solid_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collision/solids/feature_contacts.h"
#include "collision/solids/sampled_contacts.h"

namespace thenar {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Tests whether n points out of a box at its edge along `axis` through `at`: between the normals of both faces.
bool is_out_of_edge(const Vector3d& at, int axis, const Vector3d& n) {
  constexpr double kAlong = 1e-9;
  for (int i = 0; i < 3; ++i) {
    if (i != axis && n[i] * std::copysign(1.0, at[i]) < -kAlong) return false;
  }
  return true;
}

int axis_of(const Feature& edge) {
  Eigen::Index axis = 0;
  (edge.b_m - edge.a_m).cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

/// A face of a box.
struct BoxFace {
  int axis = 0;
  double side = 1.0;

  /// Tests whether an edge is one of its four.
  [[nodiscard]] bool has(const Feature& edge) const {
    return axis_of(edge) != axis && std::copysign(1.0, edge.a_m[axis]) == side;
  }
};

/// Faces of two boxes that face one another, up to a small angle.
struct FacingFaces {
  BoxFace of_a, of_b;
  Vector3d n;  ///< Out of B.
  double gap_m = -std::numeric_limits<double>::infinity();
};

/// Finds, among the faces of A at X that face one of B, those that are farthest apart: the boxes may touch there, while
/// the others overlap. None if the boxes are tilted.
std::optional<FacingFaces> facing_faces(const BoxShape& a, const BoxShape& b, const Isometry3d& X_BA) {
  // Where faces lean more, only their lowest crossing is within a band.
  constexpr double kFacing = 0.9999;
  std::optional<FacingFaces> farthest;
  for (int of_a = 0; of_a < 3; ++of_a) {
    for (int of_b = 0; of_b < 3; ++of_b) {
      const double cosine = X_BA.linear()(of_b, of_a);
      if (!(std::abs(cosine) >= kFacing)) continue;
      for (const double side : {-1.0, 1.0}) {
        const double side_a = -std::copysign(side, side * cosine);
        const Vector3d middle = placed(X_BA, 0.5 * side_a * a.size_m[of_a] * Vector3d::Unit(of_a));
        const double gap_m = side * middle[of_b] - 0.5 * b.size_m[of_b];
        if (farthest && !(gap_m > farthest->gap_m)) continue;
        farthest = {{of_a, side_a}, {of_b, side}, side * Vector3d::Unit(of_b), gap_m};
      }
    }
  }
  return farthest;
}

/// Returns the common normal of two crossing edges, of any length, from their cross product. Where faces lean on an
/// edge, as a peg's on the mouth of a slot, it is between the faces' normals; edges that are more nearly parallel than
/// the faces have any, and B's face gives it.
Vector3d normal_of(const Vector3d& across, const FacingFaces* facing, const Isometry3d& X_BA) {
  if (facing == nullptr) return across;
  constexpr double kRounding = 1e-12;
  const double cosine = std::abs(X_BA.linear()(facing->of_b.axis, facing->of_a.axis)), along = across.dot(facing->n);
  if (std::abs(along) >= (1.0 - kRounding) * cosine * across.norm()) return across;
  return along * facing->n;
}

/// Adds crossing edges of two boxes, each inside of the other's ends. Those of opposite faces are, with its corners
/// over the other's, the corners of the area that two faces share. Edges elsewhere touch along their common normal,
/// where that is out of both boxes.
void cross_edges(const SolidPair& pair, const Isometry3d& X_BA, double band_m, std::int32_t first_place,
                 std::vector<SolidContact>& contacts) {
  std::int32_t place = first_place;
  const BoxShape &box_a = std::get<BoxShape>(std::get<Solid>(pair.a)), &box_b = std::get<BoxShape>(pair.b);
  const double least_m = std::min(box_a.size_m.minCoeff(), box_b.size_m.minCoeff());
  const std::optional<FacingFaces> faces = facing_faces(box_a, box_b, X_BA);
  for (const Feature& of_a : pair.of_a) {
    if (of_a.kind != Feature::Kind::kSegment) continue;
    const Vector3d a = placed(X_BA, of_a.a_m), d_a = X_BA.linear() * (of_a.b_m - of_a.a_m);
    for (const Feature& of_b : pair.of_b) {
      if (of_b.kind != Feature::Kind::kSegment) continue;
      ++place;
      const Vector3d d_b = of_b.b_m - of_b.a_m, across = d_a.cross(d_b), between = of_b.a_m - a;
      const bool facing = faces && faces->of_a.has(of_a) && faces->of_b.has(of_b);
      const Vector3d seen = normal_of(across, facing ? &*faces : nullptr, X_BA);
      const double squared = seen.squaredNorm();
      constexpr double kParallel = 1e-12;  // Of sines squared: such edges meet at their ends, which are corners.
      if (squared < kParallel * d_a.squaredNorm() * d_b.squaredNorm()) continue;
      const double s = between.cross(d_b).dot(seen) / squared, t = between.cross(d_a).dot(seen) / squared;
      if (!(s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0)) continue;
      const Vector3d p_a = a + s * d_a, p_b = of_b.a_m + t * d_b;
      Vector3d n = seen / std::sqrt(squared);
      if (n.dot(p_b) < 0.0) n = -n;  // Out of B, whose middle is the origin.
      const double gap_m = n.dot(p_a - p_b);
      // Far edges seem to cross, too, a box's thickness deep; and those of faces that overlap more than others.
      if (!(gap_m < band_m && gap_m > -0.5 * least_m) || contacts.size() == contacts.capacity()) continue;
      if (!facing && faces && gap_m < faces->gap_m) continue;
      const Vector3d n_A = X_BA.linear().transpose() * n;
      const bool touch = is_out_of_edge(p_b, axis_of(of_b), n) && is_out_of_edge(of_a.a_m, axis_of(of_a), -n_A);
      if (facing || touch) contacts.push_back({place, kEverywhere, gap_m, p_a, n, true, kEverywhere, 0.0});
    }
  }
}

/// Adds the point where a ball, A or B, is nearest to a convex solid. False if the pair is another one.
bool meet_ball(const Solid& a, const Solid& b, const Isometry3d& X_BA, double band_m,
               std::vector<SolidContact>& contacts) {
  const bool reversed = std::holds_alternative<SphereShape>(b);
  const auto* const ball = std::get_if<SphereShape>(reversed ? &b : &a);
  if (ball == nullptr || facets(b) > 1) return false;
  const Vector3d middle_m =
      reversed ? Vector3d(X_BA.linear().transpose() * -X_BA.translation()) : Vector3d(X_BA.translation());
  const auto at = foot(reversed ? a : b, 0, middle_m);
  if (!at) return true;
  const double gap_m = at->gap_m - ball->radius_m;
  if (!(gap_m < band_m) || contacts.size() == contacts.capacity()) return true;
  const Vector3d n = reversed ? Vector3d(-(X_BA.linear() * at->normal)) : at->normal;
  const Vector3d p_m = reversed ? Vector3d(ball->radius_m * n) : Vector3d(middle_m - ball->radius_m * n);
  // No convex surface is bent more around the middle than a point, which is as far.
  const double bend_per_m = at->on == Foot::On::kFlat ? 0.0 : 1.0 / std::max(0.0, at->gap_m);
  contacts.push_back({0, kEverywhere, gap_m, p_m, n, true, bend_per_m, ball->radius_m});
  return true;
}

void meet(const Look& look, const std::vector<Feature>& features, std::int32_t& place) {
  const Solid& base = *look.base.exact;
  const bool is_box = std::holds_alternative<BoxShape>(base);
  for (const Feature& feature : features) {
    for (int facet = 0; facet < facets(base); ++facet, place += 2) {
      // Edges of two boxes cross: see cross_edges. Over a plane a segment's ends are nearest.
      const bool is_segment = feature.kind == Feature::Kind::kSegment;
      if (is_segment && (facets(base) > 1 || (is_box && feature.round_m == 0.0))) continue;
      meet_feature(look, feature, facet, place);
    }
  }
}

}  // namespace

std::size_t most_contacts(const TouchingSolid& a, const Solid& b) {
  const auto of = [](const Solid& solid, int base_facets) {
    // A point of least gap on a circle replaces the two beside it.
    std::size_t most = 0;
    for (const Feature& feature : features(solid)) most += feature.kind == Feature::Kind::kCircle ? kCirclePlaces : 1;
    return most * static_cast<std::size_t>(base_facets);
  };
  const Solid* const exact = std::get_if<Solid>(&a);
  if (exact == nullptr) return kMostSharp + kMostRound * static_cast<std::size_t>(facets(b)) + of(b, 1);
  std::size_t most = of(*exact, facets(b)) + of(b, facets(*exact));
  if (std::holds_alternative<BoxShape>(*exact) && std::holds_alternative<BoxShape>(b)) most += 16;
  return most;
}

void find_contacts(const SolidPair& pair, const Isometry3d& X_BA, double band_m, std::vector<SolidContact>& contacts) {
  // Nothing of A is nearer to B than the ball around it.
  const double reach_of_a_m = reach_m(pair.a);
  if (std::holds_alternative<HalfSpace>(pair.b) || std::holds_alternative<HoleShape>(pair.b)) {
    if (X_BA.translation()[2] - reach_of_a_m > band_m) return;
  } else if (X_BA.translation().norm() > reach_of_a_m + reach_m(pair.b) + band_m) {
    return;
  }
  if (const auto* sampled = std::get_if<std::shared_ptr<const SampledSolid>>(&pair.a)) {
    find_sampled_contacts(**sampled, pair, X_BA, band_m, contacts);
    return;
  }
  const Solid& a = std::get<Solid>(pair.a);
  if (meet_ball(a, pair.b, X_BA, band_m, contacts)) return;
  const Isometry3d X_AB = X_BA.inverse();
  std::int32_t place = 0;
  meet({{&pair.b}, X_BA, Isometry3d::Identity(), false, band_m, contacts}, pair.of_a, place);
  meet({{&a}, X_AB, X_BA, true, band_m, contacts}, pair.of_b, place);
  if (std::holds_alternative<BoxShape>(a) && std::holds_alternative<BoxShape>(pair.b))
    cross_edges(pair, X_BA, band_m, place, contacts);
}

}  // namespace thenar
