// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/feature_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace thenar {
namespace {

using Eigen::Vector3d;

constexpr double kConforming_m = 1e-8;  // A circle whose gaps differ by less fits all around.
constexpr double kNearlyFits_m = 1e-3;  // A circle whose gaps differ by less nearly fits.
constexpr int kRefinements = 40;
constexpr double kSameArc_rad = std::numbers::pi / 6.0;  // A contact farther along a circle is another one.

/// Finds the root of a slope that rises from below zero at `low` to above at `high`, by the Illinois rule.
template <typename Slope>
double root(double low, double high, double at_low, double at_high, double tolerance, const Slope& slope) {
  double x = low;
  int side = 0;
  for (int k = 0; k < kRefinements && high - low > tolerance; ++k) {
    x = (low * at_high - high * at_low) / (at_high - at_low);
    const double at = slope(x);
    if (at == 0.0) return x;
    if (at < 0.0) {
      low = x, at_low = at;
      if (side < 0) at_high *= 0.5;
      side = -1;
    } else {
      high = x, at_high = at;
      if (side > 0) at_low *= 0.5;
      side = 1;
    }
  }
  return x;
}

/// Finds the point of least gap inside of a part a .. a + d of a segment, if there is one, where the gap is convex.
void meet_part(const Look& look, std::int32_t place, const Feature& edge, const Vector3d& a, const Vector3d& d) {
  const auto begin = look.base.foot(0, a), end = look.base.foot(0, a + d);
  if (!begin || !end) return;
  const double at_0 = begin->normal.dot(d), at_1 = end->normal.dot(d);
  constexpr double kLevel = 1e-9;  // A segment along a face meets it at its ends, as sines of angles go.
  if (!(at_0 < -kLevel * d.norm()) || !(at_1 > kLevel * d.norm())) return;
  // The gap is convex along the segment, and so above its tangents at both ends.
  const double meet = (end->gap_m - at_1 - begin->gap_m) / (at_0 - at_1);
  if (begin->gap_m + at_0 * meet - edge.round_m >= look.band_m) return;
  const auto slope = [&](double s) {
    const auto at = look.base.foot(0, a + s * d);
    return at ? at->normal.dot(d) : 0.0;
  };
  const double s = root(0.0, 1.0, at_0, at_1, 1e-12, slope);
  if (const auto at = look.base.foot(0, a + s * d)) look.add(place, *at, edge.round_m, a + s * d, true);
}

/// Adds the contacts of a segment with a convex solid; over samples, whose gaps rise and fall, part by part.
void meet_segment(const Look& look, std::int32_t place, const Feature& edge) {
  constexpr int kParts = 16;
  const Vector3d a = placed(look.X, edge.a_m), d = look.X.linear() * (edge.b_m - edge.a_m);
  const int parts = look.base.exact != nullptr ? 1 : kParts;
  for (int i = 0; i < parts; ++i) meet_part(look, place, edge, a + d * i / parts, d / parts);
}

/// Returns the angle from u, 0 to 2 pi, of the lowest point of a circle of the radii u, v that is tilted over a face
/// with the foot of one of its points. -1 where it lies on the face, so that two points are equally low to 10 nm.
double lowest_angle(const Vector3d& u, const Vector3d& v, const Foot& foot) {
  if (foot.on != Foot::On::kFlat) return -1.0;
  const double along_u = u.dot(foot.normal), along_v = v.dot(foot.normal);
  const double between = 1.0 - std::cos(std::numbers::pi / kCirclePlaces);
  if (!(between * std::hypot(along_u, along_v) > kConforming_m)) return -1.0;
  // The height over a plane is a cosine of the angle.
  const double angle = std::atan2(-along_v, -along_u);
  return angle < 0.0 ? angle + 2.0 * std::numbers::pi : angle;
}

/// Adds the contacts of a circle at its kCirclePlaces points: those over flat faces, and from the others the points of
/// least gap. Where it is tilted over a face, its lowest point replaces the two beside it, which rolling passes one by
/// one. Where it nearly fits, as a peg's end in its hole, a small motion takes the place of least gap far around. There
/// the points themselves are contacts, too: each of them moves straight, whichever becomes the nearest.
void meet_circle(const Look& look, std::int32_t place, const Feature& circle, int facet) {
  const Vector3d middle = placed(look.X, circle.a_m);
  const Vector3d u = circle.circle_m * look.X.linear().col(0), v = circle.circle_m * look.X.linear().col(1);
  const auto point = [&](double angle) -> Vector3d { return middle + std::cos(angle) * u + std::sin(angle) * v; };
  const auto slope_at = [&](double angle, const Foot& at) {
    return at.normal.dot(std::cos(angle) * v - std::sin(angle) * u);
  };
  constexpr double kStep = 2.0 * std::numbers::pi / kCirclePlaces;
  const double same_m = kSameArc_rad * circle.circle_m;
  std::array<std::optional<Foot>, kCirclePlaces> feet;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool all_round = true;
  int lowest = -1;
  for (int i = 0; i < kCirclePlaces; ++i) {
    feet[i] = look.base.foot(facet, point(kStep * i));
    all_round = all_round && feet[i] && feet[i]->on != Foot::On::kFlat;
    if (!feet[i]) continue;
    if (feet[i]->gap_m < least) lowest = i;
    least = std::min(least, feet[i]->gap_m);
    most = std::max(most, feet[i]->gap_m);
  }
  // Between two places a gap is less than at both by no more than the arc.
  if (!(least < look.band_m + circle.circle_m * kStep)) return;
  const bool conforms = all_round && most - least < kConforming_m;
  const bool nearly_fits = all_round && most - least < kNearlyFits_m;
  std::array<bool, kCirclePlaces> is_by_least{};
  const double low_angle = lowest >= 0 ? lowest_angle(u, v, *feet[lowest]) : -1.0;
  std::optional<Foot> low = low_angle >= 0.0 ? look.base.foot(facet, point(low_angle)) : std::nullopt;
  if (low && (low->on != Foot::On::kFlat || low->normal != feet[lowest]->normal)) low.reset();
  if (low) {
    const int before = static_cast<int>(low_angle / kStep) % kCirclePlaces;
    is_by_least[before] = is_by_least[(before + 1) % kCirclePlaces] = true;
  }
  for (int i = 0; i < kCirclePlaces; ++i) {
    if (!feet[i]) continue;
    if (conforms || feet[i]->on == Foot::On::kFlat) {
      if (is_by_least[i]) continue;
      look.add(place, *feet[i], 0.0, point(kStep * i), false, same_m);
      continue;
    }
    const int after = (i + 1) % kCirclePlaces;
    const auto& next = feet[after];
    if (!next || next->on == Foot::On::kFlat) continue;
    const double at_low = slope_at(kStep * i, *feet[i]), at_high = slope_at(kStep * after, *next);
    if (!(at_low < 0.0 && at_high >= 0.0)) continue;
    const auto slope = [&](double angle) {
      const auto at = look.base.foot(facet, point(angle));
      return at ? slope_at(angle, *at) : 0.0;
    };
    is_by_least[i] = is_by_least[after] = true;
    const double angle = root(kStep * i, kStep * (i + 1), at_low, at_high, 1e-9, slope);
    if (const auto at = look.base.foot(facet, point(angle))) look.add(place, *at, 0.0, point(angle), true, same_m);
  }
  // In the order of places, as forces are kept.
  if (low) look.add(place + 1, *low, 0.0, point(low_angle), true, same_m);
  if (conforms || !nearly_fits) return;
  for (int i = 0; i < kCirclePlaces; ++i) {
    if (!is_by_least[i]) look.add(place + 1, *feet[i], 0.0, point(kStep * i), false, same_m);
  }
}

}  // namespace

std::optional<Foot> FeatureBase::foot(int facet, const Vector3d& x) const {
  if (exact != nullptr) return thenar::foot(*exact, facet, x);
  const auto at = sampled->surface().distance(x, kEverywhere);
  return at ? std::optional(Foot{at->distance_m, at->normal, Foot::On::kRound}) : std::nullopt;
}

void Look::add(std::int32_t place, const Foot& foot, double round_m, const Vector3d& x, bool roams,
               double same_m) const {
  // An edge is met by its own solid, edges over edges by A, and a round over a round by A: each once.
  if (foot.on == Foot::On::kEdge && (reversed || round_m > 0.0)) return;
  if (reversed && round_m > 0.0 && foot.on == Foot::On::kRound) return;
  const double gap_m = foot.gap_m - round_m;
  if (!(gap_m < band_m) || contacts.size() == contacts.capacity()) return;
  const Vector3d n = X_out.linear() * foot.normal, p_m = placed(X_out, x - round_m * foot.normal);
  roams = roams || round_m > 0.0;
  contacts.push_back(
      {place, same_m, gap_m, p_m, reversed ? Vector3d(-n) : n, roams, roams ? kEverywhere : 0.0, round_m});
}

void meet_feature(const Look& look, const Feature& feature, int facet, std::int32_t place) {
  switch (feature.kind) {
    case Feature::Kind::kPoint:
      if (const auto at = look.base.foot(facet, placed(look.X, feature.a_m)))
        look.add(place, *at, feature.round_m, placed(look.X, feature.a_m));
      break;
    case Feature::Kind::kSegment:
      meet_segment(look, place, feature);
      break;
    case Feature::Kind::kCircle:
      meet_circle(look, place, feature, facet);
      break;
  }
}

}  // namespace thenar
