#include "collision/contact_finding.h"

#include <algorithm>
#include <array>
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

void find_contacts(const PointCloud& cloud, const SphereTree& tree, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings,
                   std::vector<ContactCandidate>& found) {
  assert(settings.band_m > 0.0 && settings.max_contacts >= 0);
  found.clear();
  found.reserve(tree.leaves().size());

  // No point is nearer to the surface than to its bounds. A finger far away ends at the root of its tree.
  const auto is_near = [&](const Vector3d& p_S, double radius_m) {
    const double touching_m = settings.band_m + radius_m;
    return surface.bounds().squaredExteriorDistance(p_S) < touching_m * touching_m;
  };

  // Depth first, left before right: in the order of the leaves.
  std::array<Index, SphereTree::kMaxDepth> stack;
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const SphereTree::Node& node = tree.nodes()[stack[--depth]];
    if (!is_near(X_SB * node.centre_m, node.radius_m)) continue;
    if (!node.is_leaf()) {
      stack[depth++] = node.right;
      stack[depth++] = node.left;
      continue;
    }
    const Vector3d p_S = X_SB * cloud.points_m.col(node.representative);
    if (!is_near(p_S, 0.0)) continue;
    const std::optional<SurfaceDistance> to = surface.distance(p_S, settings.reach_m);
    if (to && to->distance_m < settings.band_m) {
      found.push_back({node.right, to->distance_m, to->point_m, to->normal});
    }
  }

  if (static_cast<Index>(found.size()) > settings.max_contacts) {
    const auto end = found.begin() + settings.max_contacts;
    std::nth_element(found.begin(), end, found.end(), less_gap);
    found.erase(end, found.end());
    std::sort(found.begin(), found.end(), less_control_point);
  }
}

}  // namespace thenar
