// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <span>
#include <vector>

#include "collision/implicit_surface.h"

namespace thenar {

/// Settings of the search for contacts.
struct ContactFindingSettings {
  double band_m = 0.3e-3;          ///< Candidates have a gap below this.
  double reach_m = 4e-3;           ///< No candidate is deeper than this; it bounds the search.
  Eigen::Index max_contacts = 20;  ///< Keeps those of least gap, ties by control point.
};

/// A control point of one body near the surface of the other.
struct ContactCandidate {
  Eigen::Index control_point;   ///< Column of the control points.
  double gap_m;                 ///< Signed distance of the control point from the surface.
  Eigen::Vector3d point_m;      ///< Its projection on the surface, in the surface's frame.
  Eigen::Vector3d normal;       ///< Outward normal of the surface there, in the surface's frame.
  Eigen::Index sample = -1;     ///< Sample of the surface nearest to the control point.
  bool is_smooth = true;        ///< See SurfaceDistance.
  double deformed_gap_m = 0.0;  ///< Gap of the deformed control point; set by the code that deforms it.
  SurfaceBend bend = {};        ///< Curvature of the surface there; set likewise.
};

/// The sample of a surface nearest to a moving point, found at at_m; valid until the point has moved free_m from there.
struct KnownSample {
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  double free_m = -1.0;      ///< Distance [m]; without a sample: none is nearer than this; < 0: nothing is known.
  Eigen::Index sample = -1;  ///< -1: none was in reach.
};

/// The nearest sample, or -1 if there is none in reach; valid while the point moves less than free_m.
struct NearestSample {
  Eigen::Index sample;
  double free_m;
};

/// Returns the sample nearest to x, after a search if it is not known. `hint` is a guess, a sample's number or -1.
[[nodiscard]] NearestSample find_nearest(const ImplicitSurface& surface, const Eigen::Vector3d& x_m, double reach_m,
                                         Eigen::Index hint, KnownSample& known);

/// Memory of the search between a body's control points and a surface: it speeds up the next call and changes no
/// result.
struct FindingMemory {
  std::vector<KnownSample> known;  // of each control point

  // A control point that cannot be a candidate sleeps until the body has moved far enough.
  std::vector<double> wakes_m;  // of each control point: travelled_m at which it wakes
  double travelled_m = 0.0;     // bound of the path length of all control points
  Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();
  double band_m = 0.0, reach_m = 0.0;  // values for which control points sleep

  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of a sphere around the control points, in their frame
  double radius_m = 0.0;

  std::vector<double> wider_m;  // of each control point: amount by which its band is wider; empty: none
  double widest_m = 0.0;        // largest of wider_m
};

/// Widens the bands of control points from the next call on, each by its own length; empty: by nothing. For used
/// memory.
void widen(std::span<const double> wider_m, FindingMemory& memory);

/// Lets a control point sleep, as its caller knows its contact, until it is woken, or the band grows. For used memory.
inline void let_sleep(Eigen::Index control_point, FindingMemory& memory) {
  memory.wakes_m[control_point] = std::numeric_limits<double>::infinity();
}
inline void wake(Eigen::Index control_point, FindingMemory& memory) { memory.wakes_m[control_point] = 0.0; }

/// Finds the control points of a body (3 x L in its own frame, posed by X_SB in the surface's frame) that lie within
/// the band of `surface` or inside it: those inside its bounds grown by the band near a sample, whose signed distance
/// is below the band, which `widen` may change for each of them. Keeps the max_contacts of least gap, ties by number;
/// sorted by control point.
///
/// Requires  band > 0, max_contacts >= 0; reach finite and greater than the band and than the depth to be expected.
///           `memory` belongs to one pair of control points and surface.
/// `found` and `memory` keep their capacity: no allocation once they have grown to the number of control
/// points.
void find_contacts(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings, FindingMemory& memory,
                   std::vector<ContactCandidate>& found);

}  // namespace thenar
