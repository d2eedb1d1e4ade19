#include "collision/contact_finding.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <tuple>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

bool less_gap(const ContactCandidate& a, const ContactCandidate& b) {
  return std::tie(a.gap_m, a.control_point) < std::tie(b.gap_m, b.control_point);
}

bool less_control_point(const ContactCandidate& a, const ContactCandidate& b) {
  return a.control_point < b.control_point;
}

}  // namespace

FindingReport find_contacts(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                            const ImplicitSurface& surface, const ContactFindingSettings& settings,
                            FindingMemory& /*memory*/, std::vector<ContactCandidate>& found) {
  assert(settings.band_m > 0.0 && settings.max_contacts >= 0);
  FindingReport report;
  found.clear();
  found.reserve(control_points_m.cols());
  for (Index i = 0; i < control_points_m.cols(); ++i) {
    const Vector3d p_S = X_SB * control_points_m.col(i);
    // No point is nearer to the surface than to its bounds.
    if (surface.bounds().squaredExteriorDistance(p_S) >= settings.band_m * settings.band_m) continue;
    const std::optional<SurfaceDistance> to = surface.distance(p_S, settings.reach_m);
    if (to && to->distance_m < settings.band_m) found.push_back({i, to->distance_m, to->point_m, to->normal});
  }

  if (static_cast<Index>(found.size()) > settings.max_contacts) {
    const auto end = found.begin() + settings.max_contacts;
    std::nth_element(found.begin(), end, found.end(), less_gap);
    found.erase(end, found.end());
    std::sort(found.begin(), found.end(), less_control_point);
  }
  return report;
}

}  // namespace thenar
