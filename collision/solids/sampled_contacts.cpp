// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/sampled_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "collision/solids/feature_contacts.h"

namespace thenar {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCell = 1.3;  // Spacings around a sample that its surface counts in: no place is farther from all.
constexpr double kLeastFacing = 0.5;  // A place whose normal is 60 degrees off the body's is not the one that touches.
constexpr double kDeeper_m = 1e-8;
constexpr int kSteps = 4;

/// Returns a lower bound of the distance of x from the solid.
double least_gap_m(const Solid& solid, const Vector3d& x) {
  if (std::holds_alternative<HalfSpace>(solid)) return x[2];
  double least_m = kEverywhere;
  for (int facet = 0; facet < facets(solid); ++facet) {
    if (const auto at = foot(solid, facet, x)) least_m = std::min(least_m, at->gap_m);
  }
  if (const auto* hole = std::get_if<HoleShape>(&solid)) least_m = std::min(least_m, x[2] + hole->depth_m);
  return std::isfinite(least_m) ? least_m : 0.0;
}

/// Returns the second derivative of a body's distance at x across its normal, for faces.
Eigen::Matrix3d bend_of(const Solid& solid, const Foot& at, const Vector3d& x) {
  if (at.on == Foot::On::kFlat) return Eigen::Matrix3d::Zero();
  if (std::holds_alternative<SphereShape>(solid))
    return (Eigen::Matrix3d::Identity() - at.normal * at.normal.transpose()) / x.norm();
  // For solids of revolution the curvature around the axis is proportional to the normal's radial part.
  const double rho = x.head<2>().norm();
  const Vector3d out(x[0] / rho, x[1] / rho, 0.0), around(-out[1], out[0], 0.0);
  return at.normal.dot(out) / rho * around * around.transpose();
}

/// A point of the surface around a sample, u along its tangents: see BentSample. To the fourth order on balls and
/// cylinders.
struct Place {
  Place(const BentSample& sample, const Vector2d& u) {
    const Vector3d t2 = sample.t2();
    const double a = sample.k1_per_m * u[0], b = sample.k2_per_m * u[1];
    const double bent = a * u[0] + b * u[1], more = 1.0 + 0.25 * (a * a + b * b);
    p_m = sample.p_m + u[0] * sample.t1 + u[1] * t2 - 0.5 * bent * more * sample.n;
    d1 = sample.t1 - (a * more + 0.25 * bent * sample.k1_per_m * a) * sample.n;
    d2 = t2 - (b * more + 0.25 * bent * sample.k2_per_m * b) * sample.n;
  }

  Vector3d p_m, d1, d2;  // And its derivatives.
};

/// The contact of a sample's surface with a facet, in the body's frame.
struct Touch {
  Vector3d p_m, n;
  double gap_m, weight;
  double round_m;  // Radius of the flattest rounding.
  bool on_round;   // The facet's.
};

/// Tests whether all faces of a body are flat.
bool is_flat(const Solid& b) { return std::holds_alternative<HalfSpace>(b) || std::holds_alternative<BoxShape>(b); }

/// Returns how much nearer to a body than a sample a point of its curved cell may be.
double nearer_by_m(const SampledSolid& a, double bent_per_m, const Solid& b) {
  const double cell_m = kCell * a.spacing_m();
  return is_flat(b) ? std::min(cell_m, std::max(0.0, bent_per_m) * cell_m * cell_m) : cell_m;
}

/// Finds the point of least gap around a sample over a facet; nothing if it is not near the sample. Newton's method in
/// the directions in which the two diverge; where they are flat the sample itself is the point.
std::optional<Touch> touch(const SampledSolid& a, const BentSample& sample, const Solid& b, int facet,
                           const Isometry3d& X_BA, double band_m) {
  const double cell_m = kCell * a.spacing_m(), nearer_m = nearer_by_m(a, sample.k1_per_m, b);
  Vector2d u = Vector2d::Zero();
  Touch best{};
  for (int k = 0;; ++k) {
    const Place place(sample, u);
    const Vector3d x = placed(X_BA, place.p_m);
    const auto at = foot(b, facet, x);
    // Where B has an edge or a corner, that finds the place.
    if (!at || at->on == Foot::On::kEdge || at->gap_m > band_m + nearer_m) return std::nullopt;
    const Vector3d n_A = X_BA.linear().transpose() * at->normal;
    const double facing = -n_A.dot(sample.n);
    if (facing < kLeastFacing) return std::nullopt;
    const double squared = u.squaredNorm() / (cell_m * cell_m);
    best = {x, at->normal, at->gap_m, (1.0 - squared) * (1.0 - squared), 0.0, at->on == Foot::On::kRound};
    Matrix2d K = Vector2d(facing * sample.k1_per_m, facing * sample.k2_per_m).asDiagonal();
    if (best.on_round) {
      Eigen::Matrix<double, 3, 2> T;
      T << X_BA.linear() * sample.t1, X_BA.linear() * sample.t2();
      K += T.transpose().lazyProduct(bend_of(b, *at, x).lazyProduct(T).eval());
    }
    Vector2d e = Vector2d::UnitX();
    std::array<double, 2> bends{K(0, 0), K(1, 1)};
    if (best.on_round) {
      const double mean = 0.5 * (K(0, 0) + K(1, 1)), half = 0.5 * (K(0, 0) - K(1, 1));
      const double spread = std::hypot(half, K(0, 1)), angle = 0.5 * std::atan2(K(0, 1), half);
      e << std::cos(angle), std::sin(angle);
      bends = {mean + spread, mean - spread};
    }
    const Vector2d slope(n_A.dot(place.d1), n_A.dot(place.d2));
    if (bends[1] < -a.flat_per_m()) return std::nullopt;  // Both sides of it are nearer.
    const std::array<Vector2d, 2> along{e, Vector2d(-e[1], e[0])};
    Vector2d step = Vector2d::Zero();
    for (int i = 0; i < 2; ++i) {
      if (bends[i] <= a.flat_per_m()) continue;
      step -= along[i].dot(slope) / bends[i] * along[i];
      best.round_m = 1.0 / bends[i];
    }
    if (step.norm() < 1e-4 * a.spacing_m() || k == kSteps) return best;
    u += step;
    if (!(u.norm() < cell_m)) return std::nullopt;
  }
}

/// The places shared by touches, with their weighted means.
class Gathered {
 public:
  Gathered(double apart_m, double band_m) : apart_m_(apart_m), band_m_(band_m) {}

  void add(const Touch& touch) {
    const auto is_same = [&](const Part& part) {
      return (part.first_m - touch.p_m).squaredNorm() < apart_m_ * apart_m_ && part.n.dot(touch.n) > 0.0;
    };
    auto part = std::find_if(parts_.begin(), parts_.begin() + count_, is_same);
    if (part == parts_.begin() + count_) {
      if (count_ < parts_.size()) {
        ++count_;
      } else {
        part = std::max_element(parts_.begin(), parts_.end(),
                                [](const Part& a, const Part& b) { return a.gap_m / a.weight < b.gap_m / b.weight; });
        if (touch.gap_m > part->gap_m / part->weight) return;  // All contacts with room are deeper.
      }
      *part = {touch.p_m, Vector3d::Zero(), Vector3d::Zero(), 0.0, 0.0, 0.0, touch.on_round};
    }
    part->p_m += touch.weight * touch.p_m;
    part->n += touch.weight * touch.n;
    part->gap_m += touch.weight * touch.gap_m;
    part->weight += touch.weight;
    part->round_m = std::max(part->round_m, touch.round_m);
  }

  /// Keeps those farthest from one another if there are too many, as along a line.
  void give(std::int32_t place, std::vector<SolidContact>& contacts) {
    for (std::size_t given = 0; given < count_ && given < kMostRound; ++given) {
      if (count_ > kMostRound && given > 0) {
        for (std::size_t i = given; i < count_; ++i)
          parts_[i].far_m2 = std::min(parts_[i].far_m2, (parts_[i].first_m - parts_[given - 1].first_m).squaredNorm());
        const auto farthest = std::max_element(parts_.begin() + given, parts_.begin() + count_,
                                               [](const Part& a, const Part& b) { return a.far_m2 < b.far_m2; });
        std::swap(parts_[given], *farthest);
      }
      const Part& part = parts_[given];
      const double gap_m = part.gap_m / part.weight;
      if (!(gap_m < band_m_) || contacts.size() == contacts.capacity()) continue;
      const double bend_per_m = part.on_round ? kEverywhere : 0.0;
      contacts.push_back(
          {place, 2.0 * apart_m_, gap_m, part.p_m / part.weight, part.n.normalized(), true, bend_per_m, part.round_m});
    }
  }

 private:
  struct Part {
    Vector3d first_m, p_m, n;
    double gap_m, weight, round_m;
    bool on_round;
    double far_m2 = kEverywhere;
  };
  std::array<Part, 5 * kMostRound> parts_;
  std::size_t count_ = 0;
  double apart_m_, band_m_;
};

/// Adds contacts of edges and corners of A with the facets of B; places begin with `first_place`.
void meet_sharp(const SampledSolid& a, const Solid& b, const Isometry3d& X_BA, double band_m, std::int32_t first_place,
                std::vector<SolidContact>& contacts) {
  const std::size_t first = contacts.size();
  const bool is_plane = std::holds_alternative<HalfSpace>(b);
  SolidContact deepest;
  deepest.gap_m = band_m;
  double deepest_chosen_m = band_m;
  for (std::size_t i = 0; i < a.sharp().size(); ++i) {
    if (is_plane && a.sharp()[i].is_straight) break;  // Those are the last ones.
    const Vector3d x = placed(X_BA, a.sharp()[i].p_m);
    if (is_plane && x[2] >= band_m) continue;
    for (int facet = 0; facet < facets(b); ++facet) {
      const auto at = foot(b, facet, x);
      if (!at || !(at->gap_m < band_m)) continue;
      SolidContact contact;
      contact.place = first_place + static_cast<std::int32_t>(i) * facets(b) + facet;
      contact.gap_m = at->gap_m;
      contact.p_m = x;
      contact.n = at->normal;
      if (contact.gap_m < deepest.gap_m) deepest = contact;
      if (contacts.size() - first == kMostSharp - 1 || contacts.size() == contacts.capacity()) continue;
      contacts.push_back(contact);
      deepest_chosen_m = std::min(deepest_chosen_m, contact.gap_m);
    }
  }
  if (deepest.gap_m < deepest_chosen_m - kDeeper_m && contacts.size() < contacts.capacity())
    contacts.push_back(deepest);
}

/// Adds contacts of curved places of A with the facets of B.
void meet_round(const SampledSolid& a, const Solid& b, const Isometry3d& X_BA, double band_m,
                std::vector<SolidContact>& contacts) {
  const double nearer_m = nearer_by_m(a, a.most_bent_per_m(), b);
  const auto near = [&](const Vector3d& middle_m, double radius_m) {
    return least_gap_m(b, placed(X_BA, middle_m)) - radius_m < band_m + nearer_m;
  };
  for (int facet = 0; facet < facets(b); ++facet) {
    Gathered places(kCell * a.spacing_m(), band_m);
    const auto look = [&](const BentSample& sample) {
      if (const auto found = touch(a, sample, b, facet, X_BA, band_m)) places.add(*found);
    };
    a.bent_balls().for_each(near, [&](std::size_t i) { look(a.bent()[i]); });
    // Flat on flat is a matter of edges.
    if (!is_flat(b)) {
      a.flat_balls().for_each(near, [&](std::size_t i) { look(a.flat()[i]); });
    }
    places.give(facet, contacts);
  }
}

}  // namespace

void find_sampled_contacts(const SampledSolid& a, const SolidPair& pair, const Isometry3d& X_BA, double band_m,
                           std::vector<SolidContact>& contacts) {
  const std::size_t first = contacts.size();
  meet_round(a, pair.b, X_BA, band_m, contacts);
  std::int32_t place = facets(pair.b);
  const Look look{{nullptr, &a}, X_BA.inverse(), X_BA, true, band_m, contacts};
  for (const Feature& feature : pair.of_b) {
    if (feature.round_m > 0.0) continue;  // Whose face A's samples have met.
    meet_feature(look, feature, 0, place);
    place += 2;  // A circle has two.
  }
  meet_sharp(a, pair.b, X_BA, band_m, place, contacts);
  std::sort(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
            [](const SolidContact& one, const SolidContact& other) { return one.place < other.place; });
}

}  // namespace thenar
