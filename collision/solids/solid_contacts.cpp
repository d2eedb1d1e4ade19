#include "collision/solids/solid_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace thenar {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kCircle = 32;             // Places on a circle that are looked at.
constexpr double kConforming_m = 1e-8;  // A circle whose gaps differ by less fits its place all around.
constexpr int kRefinements = 40;

/// What looks for contacts of a feature: solid `base` in its own frame, to which the feature's solid is at X.
struct Look {
  const Solid& base;
  Isometry3d X;      // Of the feature's solid.
  Isometry3d X_out;  // From base's frame to that of the contacts.
  bool reversed;     // The base is A.
  double band_m;
  std::vector<SolidContact>& contacts;

  void add(std::int32_t place, double angle_rad, const Foot& foot, double round_m, const Vector3d& x,
           bool roams = false) const {
    // An edge is met by its own solid, edges over edges by A, and a round over a round by A: each once.
    if (foot.on == Foot::On::kEdge && (reversed || round_m > 0.0)) return;
    if (reversed && round_m > 0.0 && foot.on == Foot::On::kRound) return;
    const double gap_m = foot.gap_m - round_m;
    if (!(gap_m < band_m) || contacts.size() == contacts.capacity()) return;
    const Vector3d n = X_out.linear() * foot.normal, p_m = X_out * (x - round_m * foot.normal);
    contacts.push_back({place, angle_rad, gap_m, p_m, reversed ? Vector3d(-n) : n, roams || round_m > 0.0});
  }
};

/// The root of a slope that rises from below zero at `low` to above at `high`, by the Illinois rule.
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

/// The place of least gap inside of a segment, if there is one: over convex solids, of which the gap is convex.
void meet_segment(const Look& look, std::int32_t place, const Feature& edge) {
  const Vector3d a = look.X * edge.a_m, d = look.X.linear() * (edge.b_m - edge.a_m);
  const auto begin = foot(look.base, 0, a), end = foot(look.base, 0, a + d);
  if (!begin || !end) return;
  const double at_0 = begin->normal.dot(d), at_1 = end->normal.dot(d);
  constexpr double kLevel = 1e-9;  // A segment along a face meets it at its ends, as sines of angles go.
  if (!(at_0 < -kLevel * d.norm()) || !(at_1 > kLevel * d.norm())) return;
  // The gap is convex along the segment, and so above its tangents at both ends.
  const double meet = (end->gap_m - at_1 - begin->gap_m) / (at_0 - at_1);
  if (begin->gap_m + at_0 * meet - edge.round_m >= look.band_m) return;
  const auto slope = [&](double s) {
    const auto at = foot(look.base, 0, a + s * d);
    return at ? at->normal.dot(d) : 0.0;
  };
  const double s = root(0.0, 1.0, at_0, at_1, 1e-12, slope);
  if (const auto at = foot(look.base, 0, a + s * d)) look.add(place, 0.0, *at, edge.round_m, a + s * d, true);
}

/// A circle at the places kCircle of it: those over flat faces, and from the others the places of least gap.
void meet_circle(const Look& look, std::int32_t place, const Feature& circle, int facet) {
  const Vector3d middle = look.X * circle.a_m;
  const Vector3d u = circle.circle_m * look.X.linear().col(0), v = circle.circle_m * look.X.linear().col(1);
  const auto point = [&](double angle) -> Vector3d { return middle + std::cos(angle) * u + std::sin(angle) * v; };
  const auto slope_at = [&](double angle, const Foot& at) {
    return at.normal.dot(std::cos(angle) * v - std::sin(angle) * u);
  };
  constexpr double kStep = 2.0 * std::numbers::pi / kCircle;
  std::array<std::optional<Foot>, kCircle> feet;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool all_round = true;
  for (int i = 0; i < kCircle; ++i) {
    feet[i] = foot(look.base, facet, point(kStep * i));
    all_round = all_round && feet[i] && feet[i]->on != Foot::On::kFlat;
    if (!feet[i]) continue;
    least = std::min(least, feet[i]->gap_m);
    most = std::max(most, feet[i]->gap_m);
  }
  // Between two places a gap is less than at both by no more than the arc.
  if (!(least < look.band_m + circle.circle_m * kStep)) return;
  const bool conforms = all_round && most - least < kConforming_m;
  for (int i = 0; i < kCircle; ++i) {
    if (!feet[i]) continue;
    if (conforms || feet[i]->on == Foot::On::kFlat) {
      look.add(place, kStep * i, *feet[i], 0.0, point(kStep * i));
      continue;
    }
    const int after = (i + 1) % kCircle;
    const auto& next = feet[after];
    if (!next || next->on == Foot::On::kFlat) continue;
    const double at_low = slope_at(kStep * i, *feet[i]), at_high = slope_at(kStep * after, *next);
    if (!(at_low < 0.0 && at_high >= 0.0)) continue;
    const auto slope = [&](double angle) {
      const auto at = foot(look.base, facet, point(angle));
      return at ? slope_at(angle, *at) : 0.0;
    };
    const double angle = root(kStep * i, kStep * (i + 1), at_low, at_high, 1e-9, slope);
    if (const auto at = foot(look.base, facet, point(angle))) look.add(place, angle, *at, 0.0, point(angle), true);
  }
}

/// Whether n is out of a box at its edge along `axis` through `at`: between the normals of the two faces there.
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

/// Edges of two boxes that cross, each inside of the other's ends.
void cross_edges(const SolidPair& pair, const Isometry3d& X_BA, double band_m, std::int32_t first_place,
                 std::vector<SolidContact>& contacts) {
  std::int32_t place = first_place;
  const double least_m =
      std::min(std::get<BoxShape>(pair.a).size_m.minCoeff(), std::get<BoxShape>(pair.b).size_m.minCoeff());
  for (const Feature& of_a : pair.of_a) {
    if (of_a.kind != Feature::Kind::kSegment) continue;
    const Vector3d a = X_BA * of_a.a_m, d_a = X_BA.linear() * (of_a.b_m - of_a.a_m);
    for (const Feature& of_b : pair.of_b) {
      if (of_b.kind != Feature::Kind::kSegment) continue;
      ++place;
      const Vector3d d_b = of_b.b_m - of_b.a_m, across = d_a.cross(d_b), between = of_b.a_m - a;
      const double squared = across.squaredNorm();
      constexpr double kParallel = 1e-12;  // Of sines squared: such edges meet at their ends, which are corners.
      if (squared < kParallel * d_a.squaredNorm() * d_b.squaredNorm()) continue;
      const double s = between.cross(d_b).dot(across) / squared, t = between.cross(d_a).dot(across) / squared;
      if (!(s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0)) continue;
      const Vector3d p_a = a + s * d_a, p_b = of_b.a_m + t * d_b;
      Vector3d n = across / std::sqrt(squared);
      if (n.dot(p_b) < 0.0) n = -n;  // Out of B, whose middle is the origin.
      const double gap_m = n.dot(p_a - p_b);
      // Far edges seem to cross, too, a box's thickness deep.
      if (!(gap_m < band_m && gap_m > -0.5 * least_m) || contacts.size() == contacts.capacity()) continue;
      const Vector3d n_A = X_BA.linear().transpose() * n;
      if (!is_out_of_edge(p_b, axis_of(of_b), n) || !is_out_of_edge(of_a.a_m, axis_of(of_a), -n_A)) {
        continue;
      }
      contacts.push_back({place, 0.0, gap_m, p_a, n, true});
    }
  }
}

void meet(const Look& look, const std::vector<Feature>& features, std::int32_t& place) {
  const bool convex = facets(look.base) == 1;
  const bool is_box = std::holds_alternative<BoxShape>(look.base);
  for (const Feature& feature : features) {
    for (int facet = 0; facet < facets(look.base); ++facet, ++place) {
      switch (feature.kind) {
        case Feature::Kind::kPoint:
          if (const auto at = foot(look.base, facet, look.X * feature.a_m))
            look.add(place, 0.0, *at, feature.round_m, look.X * feature.a_m);
          break;
        case Feature::Kind::kSegment:
          // Edges of two boxes cross: see cross_edges. Over a plane a segment's ends are nearest.
          if (convex && !(is_box && feature.round_m == 0.0)) meet_segment(look, place, feature);
          break;
        case Feature::Kind::kCircle:
          meet_circle(look, place, feature, facet);
          break;
      }
    }
  }
}

}  // namespace

SolidPair::SolidPair(const Solid& one, const Solid& other) : a(one), b(other), of_a(features(a)), of_b(features(b)) {}

std::size_t most_contacts(const SolidPair& pair) {
  const auto of = [](const std::vector<Feature>& features, const Solid& base) {
    std::size_t most = 0;
    for (const Feature& feature : features) most += feature.kind == Feature::Kind::kCircle ? kCircle : 1;
    return most * static_cast<std::size_t>(facets(base));
  };
  std::size_t most = of(pair.of_a, pair.b) + of(pair.of_b, pair.a);
  if (std::holds_alternative<BoxShape>(pair.a) && std::holds_alternative<BoxShape>(pair.b)) most += 16;
  return most;
}

void find_contacts(const SolidPair& pair, const Isometry3d& X_BA, double band_m, std::vector<SolidContact>& contacts) {
  // Nothing of A is nearer to B than the ball around it.
  if (const auto* half_space = std::get_if<HalfSpace>(&pair.b);
      half_space || std::holds_alternative<HoleShape>(pair.b)) {
    if (X_BA.translation()[2] - reach_m(pair.a) > band_m) return;
  } else if (X_BA.translation().norm() > reach_m(pair.a) + reach_m(pair.b) + band_m) {
    return;
  }
  const Isometry3d X_AB = X_BA.inverse();
  std::int32_t place = 0;
  meet({pair.b, X_BA, Isometry3d::Identity(), false, band_m, contacts}, pair.of_a, place);
  meet({pair.a, X_AB, X_BA, true, band_m, contacts}, pair.of_b, place);
  if (std::holds_alternative<BoxShape>(pair.a) && std::holds_alternative<BoxShape>(pair.b))
    cross_edges(pair, X_BA, band_m, place, contacts);
}

}  // namespace thenar
