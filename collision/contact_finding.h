#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "collision/implicit_surface.h"
#include "collision/sphere_tree.h"

namespace thenar {

/// Which control points become contacts.
struct ContactFindingSettings {
  double band_m = 0.3e-3;          ///< Candidates have a gap below this.
  double reach_m = 4e-3;           ///< No candidate is deeper than this; it bounds the search.
  Eigen::Index max_contacts = 20;  ///< Keeps those of least gap, ties by control point.
};

/// A control point of one body near the surface of the other.
struct ContactCandidate {
  Eigen::Index control_point;  ///< Leaf number in the first body's tree.
  double gap_m;                ///< Signed distance of the control point from the surface.
  Eigen::Vector3d point_m;     ///< Its projection on the surface, in the surface's frame.
  Eigen::Vector3d normal;      ///< Outward normal of the surface there, in the surface's frame.
};

/// Finds the control points of a body (cloud and tree, posed by X_SB in the surface's frame) that lie within the band
/// of `surface` or inside it: those inside its bounds grown by the band whose signed distance exists and is below the
/// band. Sorted by control point.
///
/// Requires  band > 0, max_contacts >= 0; reach finite and greater than the band and than the depth to be expected.
/// Cost      about 1 us a candidate. `found` keeps its capacity: no allocation once it has grown to the number of
/// leaves.
void find_contacts(const PointCloud& cloud, const SphereTree& tree, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings,
                   std::vector<ContactCandidate>& found);

}  // namespace thenar
