#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "collision/implicit_surface.h"

namespace thenar {

/// Which control points become contacts.
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
  Eigen::Index sample = -1;     ///< Of the surface, the nearest to the control point.
  bool is_smooth = true;        ///< As SurfaceDistance has it.
  double deformed_gap_m = 0.0;  ///< Of the control point as it is deformed: whoever deforms it says so.
  SurfaceBend bend = {};        ///< Likewise, of the surface there.
  bool is_beyond = false;       ///< Likewise: it is nearest to a face that its body does not look at.
};

/// The sample of a surface nearest to a point that moves, found when it was at at_m. It is so until the point has moved
/// free_m from there.
struct KnownSample {
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  double free_m = -1.0;      ///< Of a point without a sample: none is nearer than this; < 0: nothing is known.
  Eigen::Index sample = -1;  ///< -1: none was in reach.
};

/// A sample, or -1 if there is none in reach; it stays so while the point moves less than free_m.
struct NearestSample {
  Eigen::Index sample;
  double free_m;
};

/// The sample nearest to x, after a search if it is not known. `hint`, a sample's number or -1, is where it might be.
[[nodiscard]] NearestSample find_nearest(const ImplicitSurface& surface, const Eigen::Vector3d& x_m, double reach_m,
                                         Eigen::Index hint, KnownSample& known);

/// What the last call knew about a body's control points and a surface: it makes the next one cheaper, and changes
/// nothing in what is found.
struct FindingMemory {
  std::vector<KnownSample> known;  // of each control point

  // A control point that is no prospect sleeps until the body has travelled so far that it might be one.
  std::vector<double> wakes_m;  // of each control point, at this travelled_m
  double travelled_m = 0.0;     // no control point went farther
  Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();
  double band_m = 0.0, reach_m = 0.0;  // what the sleepers are asleep for

  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of a sphere around the control points, in their frame
  double radius_m = 0.0;

  std::vector<double> wider_m;  // of each control point, what its band is wider by; none: nothing
  double widest_m = 0.0;        // of them
};

/// Keeps the `most` candidates of least gap, ties by control point; the others go to `left_out`, if given, which stays
/// as it is where there are none. Expects and leaves them sorted by control point.
void keep_least_gaps(Eigen::Index most, std::vector<ContactCandidate>& candidates,
                     std::vector<ContactCandidate>* left_out);

/// From the next call on the bands of control points are wider, each by its own length; empty: as asked for. For memory
/// that has been used.
void widen(std::span<const double> wider_m, FindingMemory& memory);

/// Finds the control points of a body (3 x L in its own frame, posed by X_SB in the surface's frame) that lie within
/// the band of `surface` or inside it: those inside its bounds grown by the band near a sample, whose signed distance
/// is below the band, which `memory.wider_m` may widen for each of them: change it by `widen`. Keeps the max_contacts
/// of least gap, ties by number; sorted by control point.
///
/// Requires  band > 0, max_contacts >= 0; reach finite and greater than the band and than the depth to be expected.
///           `memory` belongs to one pair of control points and surface.
/// `left_out`, if given, gets the candidates that there was no room for, in no order.
/// `found`, `left_out` and `memory` keep their capacity: no allocation once they have grown to the number of control
/// points.
void find_contacts(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings, FindingMemory& memory,
                   std::vector<ContactCandidate>& found, std::vector<ContactCandidate>* left_out = nullptr);

}  // namespace thenar
