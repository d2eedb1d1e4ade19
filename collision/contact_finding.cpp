// SPDX-License-Identifier: Apache-2.0
#include "collision/contact_finding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// More than rounding does to a length below a metre [m].
constexpr double kRounding_m = 1e-12;

// Extent of the search past a nearest sample, in supports: half a spacing. More makes one search more expensive and its
// result valid for longer.
constexpr double kBeyond = 0.2;

// Points sleep for a band wider than requested, as that changes with the speed of the hand.
constexpr double kWider = 1.25;

bool less_gap(const ContactCandidate& a, const ContactCandidate& b) {
  return std::tie(a.gap_m, a.control_point) < std::tie(b.gap_m, b.control_point);
}

bool less_control_point(const ContactCandidate& a, const ContactCandidate& b) {
  return a.control_point < b.control_point;
}

/// Keeps the `most` candidates of least gap, sorted by control point.
void keep_least_gaps(Index most, std::vector<ContactCandidate>& candidates) {
  if (std::ssize(candidates) <= most) return;
  const auto end = candidates.begin() + most;
  std::nth_element(candidates.begin(), end, candidates.end(), less_gap);
  candidates.erase(end, candidates.end());
  std::sort(candidates.begin(), candidates.end(), less_control_point);
}

void set_up(const Eigen::Matrix3Xd& control_points_m, FindingMemory& memory) {
  memory.known.assign(control_points_m.cols(), KnownSample{});
  memory.wakes_m.assign(control_points_m.cols(), 0.0);
  memory.wider_m.clear();
  memory.wider_m.reserve(control_points_m.cols());
  memory.widest_m = 0.0;
  memory.centre_m = control_points_m.rowwise().mean();
  memory.radius_m = (control_points_m.colwise() - memory.centre_m).colwise().norm().maxCoeff();
}

/// Adds the motion from the last pose to this one: |X c - X' c| + |R - R'| r for the sphere (c, r) around the points.
void travel(const Eigen::Isometry3d& X_SB, const ContactFindingSettings& settings, FindingMemory& memory) {
  const double shift_m = (X_SB * memory.centre_m - memory.X_SB * memory.centre_m).norm();
  const double turn = (X_SB.linear() - memory.X_SB.linear()).norm();
  // A pose that is not finite wakes all.
  if (!(shift_m <= 0.0 && turn <= 0.0)) memory.travelled_m += shift_m + turn * memory.radius_m + 1e-3 * kRounding_m;
  memory.X_SB = X_SB;
  // Asleep for a band is asleep for a narrower one. After a metre sums begin to lose what a step adds.
  const bool holds = settings.band_m <= memory.band_m && settings.reach_m <= memory.reach_m;
  if (holds && settings.band_m > memory.band_m / (kWider * kWider) && memory.travelled_m < 1.0) return;
  memory.band_m = kWider * settings.band_m;
  memory.reach_m = kWider * settings.reach_m;
  memory.travelled_m = 0.0;
  std::fill(memory.wakes_m.begin(), memory.wakes_m.end(), 0.0);
}

}  // namespace

NearestSample find_nearest(const ImplicitSurface& surface, const Vector3d& x_m, double reach_m, Index hint,
                           KnownSample& known) {
  const double moved_m = (x_m - known.at_m).norm();
  if (known.sample >= 0) {
    // At the reach itself the search decides.
    const bool within = (surface.cloud().points_m.col(known.sample) - x_m).norm() < reach_m - kRounding_m;
    if (moved_m < known.free_m && within) return {known.sample, known.free_m - moved_m};
    hint = known.sample;
  } else if (known.free_m - moved_m > reach_m) {
    return {-1, known.free_m - moved_m - reach_m};
  }
  const SampleBlocks::Nearest found = surface.nearest(x_m, reach_m, kBeyond * surface.support_m(), hint);
  known = {x_m, (found.sample < 0 ? found.distance_m : found.free_m) - kRounding_m, found.sample};
  return {found.sample, found.sample < 0 ? known.free_m - reach_m : known.free_m};
}

void widen(std::span<const double> wider_m, FindingMemory& memory) {
  if (wider_m.empty() && memory.wider_m.empty()) return;
  memory.wider_m.resize(memory.known.size(), 0.0);
  const auto count = static_cast<Index>(memory.wider_m.size());
  Eigen::Map<Eigen::ArrayXd> now(memory.wider_m.data(), count), wakes(memory.wakes_m.data(), count);
  if (wider_m.empty()) {
    now.setZero();
    memory.widest_m = 0.0;
    return;
  }
  const Eigen::Map<const Eigen::ArrayXd> wider(wider_m.data(), count);
  // A sleeper wakes by so much earlier; by how much later, where its band is narrower, nobody knows.
  wakes -= (wider - now).max(0.0);
  now = wider;
  memory.widest_m = wider.maxCoeff();
}

void find_contacts(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings, FindingMemory& memory,
                   std::vector<ContactCandidate>& found) {
  assert(settings.band_m > 0.0 && settings.max_contacts >= 0);
  found.clear();
  found.reserve(control_points_m.cols());
  if (static_cast<Index>(memory.known.size()) != control_points_m.cols()) set_up(control_points_m, memory);
  if (settings.max_contacts == 0) return;

  travel(X_SB, settings, memory);
  const Eigen::AlignedBox3d& bounds = surface.bounds();
  // No point is nearer to the surface than to its bounds.
  const double around_m = memory.radius_m + settings.band_m + memory.widest_m + kRounding_m;
  if (bounds.exteriorDistance(X_SB * memory.centre_m) > around_m) return;
  const Vector3d middle_m = bounds.center(), half_m = 0.5 * bounds.sizes();
  Index hint = -1;
  for (Index i = 0; i < control_points_m.cols(); ++i) {
    if (memory.travelled_m < memory.wakes_m[i]) continue;
    const double wider_m = memory.wider_m.empty() ? 0.0 : memory.wider_m[i], band_m = settings.band_m + wider_m;
    const auto sleep = [&](double way_m) { memory.wakes_m[i] = memory.travelled_m + way_m - wider_m - kRounding_m; };
    const Vector3d p_S = X_SB * control_points_m.col(i);
    if (((p_S - middle_m).array().abs() > half_m.array()).any()) {
      const double way_m = bounds.exteriorDistance(p_S);
      if (way_m >= band_m) {
        sleep(way_m - memory.band_m);
        continue;
      }
    }
    const NearestSample start = find_nearest(surface, p_S, settings.reach_m, hint, memory.known[i]);
    if (start.sample < 0) {
      sleep(start.free_m - (memory.reach_m - settings.reach_m));
      continue;
    }
    hint = start.sample;
    const SurfaceDistance to = surface.distance_from(p_S, start.sample);
    if (to.distance_m < band_m) {
      found.push_back({i, to.distance_m, to.point_m, to.normal, start.sample, to.is_smooth});
      continue;
    }
    const ImplicitSurface::Estimate estimate = surface.estimate(p_S, start.sample);
    sleep(std::min({start.free_m, estimate.least_m - memory.band_m, estimate.firm_m}));
  }
  keep_least_gaps(settings.max_contacts, found);
}

}  // namespace thenar
