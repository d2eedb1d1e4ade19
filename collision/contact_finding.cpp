#include "collision/contact_finding.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Known = FindingMemory::Known;
using Prospect = FindingMemory::Prospect;

// More than rounding does to a length below a metre [m].
constexpr double kRounding_m = 1e-12;

// How far a search for a nearest sample looks past it, in supports: a quarter of a spacing. More makes one search
// dearer and lets its result hold for longer.
constexpr double kBeyond = 0.1;

bool less_gap(const ContactCandidate& a, const ContactCandidate& b) {
  return std::tie(a.gap_m, a.control_point) < std::tie(b.gap_m, b.control_point);
}

bool less_control_point(const ContactCandidate& a, const ContactCandidate& b) {
  return a.control_point < b.control_point;
}

/// For a heap with the least estimate on top.
bool later(const Prospect& a, const Prospect& b) { return a.estimate_m > b.estimate_m; }

void set_up(const Eigen::Matrix3Xd& control_points_m, FindingMemory& memory) {
  memory.known.assign(control_points_m.cols(), Known{});
  memory.prospects.reserve(control_points_m.cols());
  memory.wakes_m.assign(control_points_m.cols(), 0.0);
  memory.centre_m = control_points_m.rowwise().mean();
  memory.radius_m = (control_points_m.colwise() - memory.centre_m).colwise().norm().maxCoeff();
}

/// Adds the way from the last pose to this one: |X c - X' c| + |R - R'| r for the sphere (c, r) around the points.
void travel(const Eigen::Isometry3d& X_SB, const ContactFindingSettings& settings, FindingMemory& memory) {
  const double shift_m = (X_SB * memory.centre_m - memory.X_SB * memory.centre_m).norm();
  const double turn = (X_SB.linear() - memory.X_SB.linear()).norm();
  // A pose that is not finite wakes all.
  if (!(shift_m <= 0.0 && turn <= 0.0)) memory.travelled_m += shift_m + turn * memory.radius_m + 1e-3 * kRounding_m;
  memory.X_SB = X_SB;
  // After a metre sums begin to lose what a step adds.
  if (settings.band_m == memory.band_m && settings.reach_m == memory.reach_m && memory.travelled_m < 1.0) return;
  memory.band_m = settings.band_m;
  memory.reach_m = settings.reach_m;
  memory.travelled_m = 0.0;
  std::fill(memory.wakes_m.begin(), memory.wakes_m.end(), 0.0);
}

/// What is known of the sample nearest to x, after a search if it was not known.
struct Start {
  Index sample;   // -1: none in reach
  double free_m;  // it stays so while x moves less
};

Start find_start(const ImplicitSurface& surface, const Vector3d& x_m, double reach_m, Index hint, Known& known) {
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
  // At x + d the sample is at most |d| farther, and all others are at most |d| nearer.
  const double free_m = found.sample < 0 ? found.others_m : 0.5 * (found.others_m - found.distance_m);
  known = {x_m, free_m - kRounding_m, found.sample};
  return {found.sample, found.sample < 0 ? known.free_m - reach_m : known.free_m};
}

/// Fills memory.prospects with the control points inside the surface's bounds grown by the band and near a sample, but
/// for those whose gap is surely not below the band.
void find_prospects(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                    const ImplicitSurface& surface, const ContactFindingSettings& settings, FindingMemory& memory) {
  memory.prospects.clear();
  const double band_m = settings.band_m;
  // No point is nearer to the surface than to its bounds.
  const auto beyond_bounds_m = [&](const Vector3d& p_S) {
    return std::sqrt(surface.bounds().squaredExteriorDistance(p_S)) - band_m;
  };
  if (beyond_bounds_m(X_SB * memory.centre_m) > memory.radius_m + kRounding_m) return;

  Index hint = -1;
  for (Index i = 0; i < control_points_m.cols(); ++i) {
    if (memory.travelled_m < memory.wakes_m[i]) continue;
    const auto sleep = [&](double way_m) { memory.wakes_m[i] = memory.travelled_m + way_m - kRounding_m; };
    const Vector3d p_S = X_SB * control_points_m.col(i);
    if (const double way_m = beyond_bounds_m(p_S); way_m >= 0.0) {
      sleep(way_m);
      continue;
    }
    const Start start = find_start(surface, p_S, settings.reach_m, hint, memory.known[i]);
    if (start.sample < 0) {
      sleep(start.free_m);
      continue;
    }
    hint = start.sample;
    const ImplicitSurface::Estimate estimate = surface.estimate(p_S, start.sample);
    if (estimate.least_m >= band_m) {
      sleep(std::min({start.free_m, estimate.least_m - band_m, estimate.firm_m}));
      continue;
    }
    memory.prospects.push_back({i, p_S, start.sample, estimate.distance_m, estimate.least_m});
  }
}

}  // namespace

void find_contacts(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings, FindingMemory& memory,
                   std::vector<ContactCandidate>& found, std::vector<ContactCandidate>* left_out) {
  assert(settings.band_m > 0.0 && settings.max_contacts >= 0);
  found.clear();
  found.reserve(control_points_m.cols());
  if (left_out != nullptr) {
    left_out->clear();
    left_out->reserve(control_points_m.cols());
  }
  const auto leave_out = [&](const ContactCandidate& contact) {
    if (left_out != nullptr && contact.gap_m < settings.band_m) left_out->push_back(contact);
  };
  if (static_cast<Index>(memory.known.size()) != control_points_m.cols()) set_up(control_points_m, memory);
  if (settings.max_contacts == 0) return;

  travel(X_SB, settings, memory);
  find_prospects(control_points_m, X_SB, surface, settings, memory);
  std::vector<Prospect>& prospects = memory.prospects;
  std::make_heap(prospects.begin(), prospects.end(), later);
  for (; !prospects.empty(); prospects.pop_back()) {
    std::pop_heap(prospects.begin(), prospects.end(), later);
    const Prospect& next = prospects.back();
    const bool full = static_cast<Index>(found.size()) == settings.max_contacts;
    if (full && next.least_m > found.front().gap_m) {
      const SurfaceDistance plane = surface.plane_distance(next.at_m, next.sample);
      leave_out({next.control_point, plane.distance_m, plane.point_m, plane.normal});
      continue;
    }
    const SurfaceDistance to = surface.distance_from(next.at_m, next.sample);
    if (to.distance_m >= settings.band_m) continue;
    const ContactCandidate contact{next.control_point, to.distance_m, to.point_m, to.normal};
    if (full) {
      if (!less_gap(contact, found.front())) {
        leave_out(contact);
        continue;
      }
      std::pop_heap(found.begin(), found.end(), less_gap);
      leave_out(found.back());
      found.pop_back();
    }
    found.push_back(contact);
    std::push_heap(found.begin(), found.end(), less_gap);
  }
  std::sort(found.begin(), found.end(), less_control_point);
}

}  // namespace thenar
