// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "engine/grasp/delassus.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"

namespace thenar {

/// Share of spare friction below which a contact is on its cone's surface. Where it slides, the solver puts it there to
/// the last bit.
inline constexpr double kOnCone = 1e-6;
/// Speed below which a point is at rest: 1 mm in 17 minutes. Solves to the default tolerance move points by 0.1 um/s.
inline constexpr double kMoves_m_per_s = 1e-6;

/// Motion of a finger's patch against the object in a tick, from that of its loaded points, and the margin of its force
/// to the friction limit.
struct PatchReport {
  Eigen::Vector3d slip_W = Eigen::Vector3d::Zero();  ///< Mean displacement of its points, weighted by normal force.
  double slip_m = 0.0;                               ///< Its size.
  double spin_rad = 0.0;       ///< Turn about the mean normal, through the pressure centre; signed; 0 of a point.
  double sliding_share = 0.0;  ///< Share of the normal force on points that slide: on their cone's surface, and moving.
  double creep_m_per_s = 0.0;  ///< Speed of the fastest loaded point inside its cone: it should stick.
  Eigen::Vector3d dent_O = Eigen::Vector3d::Zero();  ///< Mean u_o of a soft object at its points, weighted likewise.
  double moment_Nm = 0.0;  ///< Torsion M_n: of its forces about the mean normal through the pressure centre; signed.
  double moment_limit_Nm = 0.0;  ///< M_max = mu sum f_n,i |r_i|, the most that its pressure can carry; 0 of a point.
  /// Margin before it slides, by the ellipsoid between friction and torsion [Goyal, Ruina, Papadopoulos 1991;
  /// Howe, Cutkosky 1996]:
  ///     1 - sqrt((|F_t| / (mu F_n))^2 + (M_n / M_max)^2)
  /// F the resultant, r_i from the pressure centre. 1: no load on friction; 0: the patch slides as a whole. Between a
  /// pure pull and a pure torsion a Hertz patch carries up to 6 % less than the ellipsoid says. NaN without load or
  /// friction.
  double margin = std::numeric_limits<double>::quiet_NaN();
};

/// A loaded contact over a tick.
struct PatchPoint {
  Eigen::Index contact = 0;  ///< Index in the frame.
  Eigen::Vector3d u_end_F;   ///< The pulp's displacement at the end; distal frame.
  Eigen::Vector3d u_end_O;   ///< A soft object's displacement at the end; object frame.
  Eigen::Vector3d x_O;       ///< The finger's point against the object's surface, at the start; object frame.
  Eigen::Vector3d r_W;       ///< Contact point of finger and object from the patch's pressure centre; at the start.
  Eigen::Vector3d f_W;       ///< Force on the object [N].
  double normal_N = 0.0;     ///< Its normal part.
  double friction_N = 0.0;   ///< Size of its tangential part.
  Eigen::Vector3d d_W;       ///< Displacement of the finger's point against the object's, along the surface.
};

/// The loaded contacts of a tick.
struct PatchPoints {
  explicit PatchPoints(const Model& model) : begin(model.fingers() + 1) {
    points.reserve(model.max_contacts);
    if (model.soft_object()) u_end_O.setZero(model.max_contacts, 3);
  }

  void clear() {
    points.clear();
    std::ranges::fill(begin, 0);
  }
  [[nodiscard]] std::span<const PatchPoint> of_finger(int k) const {
    return std::span(points).subspan(begin[k], begin[k + 1] - begin[k]);
  }

  std::vector<PatchPoint> points;  ///< Finger by finger.
  std::vector<std::size_t> begin;  ///< Finger k has points begin[k] .. begin[k + 1).
  Eigen::MatrixX3d u_end_O;        ///< u_o of all contacts at the end, for a soft object.
};

/// Finds the contacts loaded by the forces f (3 rows a contact), and their displacements since the state of the
/// kinematics, after the motion of the bodies, the pulps and a soft object: `state`, with the pose of its hand, and the
/// finger loads of the tick. In the object's frame, on each contact's tangent plane.
void find_displacements(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                        const HandPose& pose, const State& state, const Eigen::VectorXd& f, PatchPoints& points);

/// Computes the report of a finger's patch for a step of `step_s`.
[[nodiscard]] PatchReport patch_report(std::span<const PatchPoint> patch, const FingerLoad& load, double mu,
                                       double step_s);

}  // namespace thenar
