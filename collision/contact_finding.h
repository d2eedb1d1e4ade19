#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
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
  Eigen::Index control_point;  ///< Column of the control points.
  double gap_m;                ///< Signed distance of the control point from the surface.
  Eigen::Vector3d point_m;     ///< Its projection on the surface, in the surface's frame.
  Eigen::Vector3d normal;      ///< Outward normal of the surface there, in the surface's frame.
};

/// What the last call knew about a body's control points and a surface: it makes the next one cheaper, and changes
/// nothing in what is found.
struct FindingMemory {
  /// The sample nearest to a control point, found at at_m. It is so until the point has moved free_m from there.
  struct Known {
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
    double free_m = -1.0;      ///< Of a point without a sample: none is nearer than this; < 0: nothing is known.
    Eigen::Index sample = -1;  ///< -1: none was in reach.
  };
  /// A control point that may be a contact.
  struct Prospect {
    Eigen::Index control_point;
    Eigen::Vector3d at_m;
    Eigen::Index sample;
    double estimate_m;  ///< Of its gap.
    double least_m;     ///< Its gap is this or more.
  };
  std::vector<Known> known;         // of each control point
  std::vector<Prospect> prospects;  // room for one call's

  // A control point that is no prospect sleeps until the body has travelled so far that it might be one.
  std::vector<double> wakes_m;  // of each control point, at this travelled_m
  double travelled_m = 0.0;     // no control point went farther
  Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();
  double band_m = 0.0, reach_m = 0.0;  // what the sleepers are asleep for

  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of a sphere around the control points, in their frame
  double radius_m = 0.0;
};

/// Finds the control points of a body (3 x L in its own frame, posed by X_SB in the surface's frame) that lie within
/// the band of `surface` or inside it: those inside its bounds grown by the band near a sample, whose signed distance
/// is below the band. Keeps the max_contacts of least gap, ties by number; sorted by control point.
///
/// Distances are taken in the order of their estimates, deepest first, until a lower bound shows that no other is among
/// the least.
///
/// Requires  band > 0, max_contacts >= 0; reach finite and greater than the band and than the depth to be expected.
///           `memory` belongs to one pair of control points and surface.
/// `left_out`, if given, gets the candidates that there was no room for, in no order. It costs no distances: those that
/// a bound has ruled out are on the plane of the samples near them, as after a first projection: point_m is the plane's
/// middle, gap_m the distance from the plane.
/// `found`, `left_out` and `memory` keep their capacity: no allocation once they have grown to the number of control
/// points.
void find_contacts(const Eigen::Matrix3Xd& control_points_m, const Eigen::Isometry3d& X_SB,
                   const ImplicitSurface& surface, const ContactFindingSettings& settings, FindingMemory& memory,
                   std::vector<ContactCandidate>& found, std::vector<ContactCandidate>* left_out = nullptr);

}  // namespace thenar
