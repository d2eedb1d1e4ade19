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
constexpr double kSameArc_rad = std::numbers::pi / 6.0;  // A contact that has gone farther along a circle is another.
constexpr double kEverywhere = std::numeric_limits<double>::infinity();

/// What looks for contacts of a feature: solid `base` in its own frame, to which the feature's solid is at X.
struct Look {
  const Solid& base;
  Isometry3d X;      // Of the feature's solid.
  Isometry3d X_out;  // From base's frame to that of the contacts.
  bool reversed;     // The base is A.
  double band_m;
  std::vector<SolidContact>& contacts;

  void add(std::int32_t place, const Foot& foot, double round_m, const Vector3d& x, bool roams = false,
           double same_m = kEverywhere) const {
    // An edge is met by its own solid, edges over edges by A, and a round over a round by A: each once.
    if (foot.on == Foot::On::kEdge && (reversed || round_m > 0.0)) return;
    if (reversed && round_m > 0.0 && foot.on == Foot::On::kRound) return;
    const double gap_m = foot.gap_m - round_m;
    if (!(gap_m < band_m) || contacts.size() == contacts.capacity()) return;
    const Vector3d n = X_out.linear() * foot.normal, p_m = X_out * (x - round_m * foot.normal);
    roams = roams || round_m > 0.0;
    contacts.push_back(
        {place, same_m, gap_m, p_m, reversed ? Vector3d(-n) : n, roams, roams ? kEverywhere : 0.0, round_m});
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
  if (const auto at = foot(look.base, 0, a + s * d)) look.add(place, *at, edge.round_m, a + s * d, true);
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
  const double same_m = kSameArc_rad * circle.circle_m;
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
      look.add(place, *feet[i], 0.0, point(kStep * i), false, same_m);
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
    if (const auto at = foot(look.base, facet, point(angle))) look.add(place, *at, 0.0, point(angle), true, same_m);
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
  const auto thickness_m = [](const Solid& box) { return std::get<BoxShape>(box).size_m.minCoeff(); };
  const double least_m = std::min(thickness_m(std::get<Solid>(pair.a)), thickness_m(pair.b));
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
      contacts.push_back({place, kEverywhere, gap_m, p_a, n, true, kEverywhere, 0.0});
    }
  }
}

/// The one place where a ball, A or B, is nearest to a convex solid. False if the pair is another one.
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
  const bool convex = facets(look.base) == 1;
  const bool is_box = std::holds_alternative<BoxShape>(look.base);
  for (const Feature& feature : features) {
    for (int facet = 0; facet < facets(look.base); ++facet, ++place) {
      switch (feature.kind) {
        case Feature::Kind::kPoint:
          if (const auto at = foot(look.base, facet, look.X * feature.a_m))
            look.add(place, *at, feature.round_m, look.X * feature.a_m);
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

SolidPair::SolidPair(const TouchingSolid& one, const Solid& other) : a(one), b(other), of_b(features(b)) {
  if (const Solid* exact = std::get_if<Solid>(&a)) of_a = features(*exact);
}

double reach_m(const TouchingSolid& solid) { return reach_m(std::get<Solid>(solid)); }

std::size_t most_contacts(const TouchingSolid& a, const Solid& b) {
  const auto of = [](const Solid& solid, const Solid& base) {
    std::size_t most = 0;
    for (const Feature& feature : features(solid)) most += feature.kind == Feature::Kind::kCircle ? kCircle : 1;
    return most * static_cast<std::size_t>(facets(base));
  };
  const Solid& exact = std::get<Solid>(a);
  std::size_t most = of(exact, b) + of(b, exact);
  if (std::holds_alternative<BoxShape>(exact) && std::holds_alternative<BoxShape>(b)) most += 16;
  return most;
}

void find_contacts(const SolidPair& pair, const Isometry3d& X_BA, double band_m, std::vector<SolidContact>& contacts) {
  const Solid& a = std::get<Solid>(pair.a);
  // Nothing of A is nearer to B than the ball around it.
  if (std::holds_alternative<HalfSpace>(pair.b) || std::holds_alternative<HoleShape>(pair.b)) {
    if (X_BA.translation()[2] - reach_m(a) > band_m) return;
  } else if (X_BA.translation().norm() > reach_m(a) + reach_m(pair.b) + band_m) {
    return;
  }
  if (meet_ball(a, pair.b, X_BA, band_m, contacts)) return;
  const Isometry3d X_AB = X_BA.inverse();
  std::int32_t place = 0;
  meet({pair.b, X_BA, Isometry3d::Identity(), false, band_m, contacts}, pair.of_a, place);
  meet({a, X_AB, X_BA, true, band_m, contacts}, pair.of_b, place);
  if (std::holds_alternative<BoxShape>(a) && std::holds_alternative<BoxShape>(pair.b))
    cross_edges(pair, X_BA, band_m, place, contacts);
}

}  // namespace thenar
