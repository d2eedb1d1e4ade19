// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

/// A contact's point, deformed as the state has it, and its gap there. Of one that leans, the frame's own gap.
struct ContactPoint {
  Eigen::Vector3d u_F;  ///< The pulp's displacement; distal frame.
  Eigen::Vector3d u_O;  ///< A soft object's; object frame.
  ContactGap gap;
};

/// A frame's contacts at one state: their gaps, and J_c, how the bodies' motion changes gaps and slips. Finger and
/// object meet at the deformed finger point, where the force acts: with J_c taken elsewhere, it would not be the
/// derivative of the gap, and contact would feed the bodies with energy.
struct ContactKinematics {
  explicit ContactKinematics(const Model& model);

  // As place_bodies() and find_gaps() leave it:
  Eigen::Isometry3d X_WO;             ///< The object.
  PerFinger<Eigen::Isometry3d> X_FO;  ///< The same in each distal frame.
  std::vector<ContactPoint> points;   ///< Capacity, as all below.
  // As find_jacobians() leaves it:
  Eigen::VectorXd gap_m;
  /// Ratio of gap_m to the frame's own gap: 1 except where a contact leans.
  Eigen::VectorXd gap_unit;
  GroupedDelassus::OwnJacobian J_finger;     ///< Rows -E' J_k; 3 capacity x 4.
  Eigen::VectorXd J_fifth;                   ///< Its fifth column, where a finger has five joints; else none.
  GroupedDelassus::OwnJacobian J_mobile;     ///< J_finger as W has it where joints differ: see Mobility::root.
  Eigen::VectorXd J_fifth_mobile;            ///< J_fifth likewise.
  GroupedDelassus::CommonJacobian J_object;  ///< Rows E' [I, -[r]x, 0 0]; 3 capacity x 6, padded to 8.
  std::vector<Eigen::Matrix3d> E_W;          ///< Columns n, t1, t2, world axes.
  /// The same in the distal frame. For a contact that fades the first is its gap's growth with u, and not of
  /// length one.
  std::vector<Eigen::Matrix3d> E_F;
  std::vector<Eigen::Vector3d> c_W;  ///< Contact points of finger and object.
  /// Rows E_F', 3 capacity x 3, none for rigid fingertips: the axes of the pulps' compliance. The solver presses in
  /// them and deform() commits u in them: in other axes a finger that sticks would walk.
  GroupedDelassus::Axes pulp_axes;
  PerFinger<double> pulp_share;  ///< (1 - rho) of each pulp over that of the first; no entries: they are alike.
  // Only for a soft object:
  /// Columns n, t1, t2, object frame, of the object's gap growth: n does not lean, and is as E_F's of a contact
  /// that fades.
  std::vector<Eigen::Matrix3d> E_O;
  GroupedDelassus::Axes object_tensors;  ///< Rows E_O' T.
  Eigen::MatrixX3d u_O;                  ///< u_o as points have it, in columns; capacity x 3.
  Eigen::Matrix3Xd u_object_m;           ///< u_o in contact rows; 3 x capacity.
};

/// Sets the poses of the bodies from the state and the pose of its hand.
void place_bodies(const Model& model, const HandPose& pose, const State& state, ContactKinematics& kinematics);
/// Finds u and gap of each contact, for bodies that have been placed.
void find_gaps(const Model& model, const Frame& frame, const State& state, ContactKinematics& kinematics);
/// Computes the rest, for gaps that have been found.
void find_jacobians(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                    ContactKinematics& kinematics);
/// Computes all of it.
void contact_kinematics(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                        ContactKinematics& kinematics);

}  // namespace thenar
