// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/hand/hand.h"
#include "engine/hand/muscles.h"
#include "solvers/grasp_forces.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

/// One contact of a frame, in body-fixed terms, so that it follows the bodies while the frame is in use. The object's
/// surface around s is a torus that has its two curvatures there: of a rod, a ball and a plane it is the surface
/// itself.
struct FrameContact {
  int finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d p_F;  ///< Finger point, distal frame; rest shape.
  Eigen::Vector3d
      s_O;  ///< Foot of the deformed point on the object's surface, now or from a little before: see HeldContact.
  Eigen::Vector3d n_O;                            ///< Normal there, into the object; object frame.
  Eigen::Vector3d t_O = Eigen::Vector3d::Zero();  ///< A principal direction of the surface there, across n.
  double curvature_per_m = 0.0;                   ///< Curvature along t, of the torus's tube; > 0 convex.
  double ring_curvature_per_m = 0.0;              ///< Curvature along n x t, of its ring: no larger in size.
  double area_m2 = 0.0;  ///< Area of the contact, where it is a part of the control point's cell; else 0.
  Eigen::Matrix3d E_F = Eigen::Matrix3d::Identity();  ///< Columns n, t1, t2, distal frame, at the snapshot.
  // For an edge of the object in the control point's cell: see engine/grasp/edge_contacts.h. Else the defaults.
  double share = 1.0;                                ///< Own compliance of the cell over that of its pressed part.
  double covered = 1.0;                              ///< Area share of that part.
  Eigen::Vector3d lean_O = Eigen::Vector3d::Zero();  ///< Turn of n per force [1/N], object frame.
  double lean_m_per_N = 0.0;                         ///< The same, on the way that the frame expects.
  double press = 1.0;  ///< Growth of the gap per displacement of the pulp along E_F's first column, which is not n.

  [[nodiscard]] bool fades() const { return share < 1.0; }
};

/// Returns the area of the pulp's surface that a contact represents, for a deformable fingertip.
[[nodiscard]] double area_of(const Model& model, const FrameContact& contact);
/// Returns its share of its control point's cell; 1 for a rigid fingertip.
[[nodiscard]] double covered_share(const Model& model, const FrameContact& contact);

/// Extent to which control points do not resolve a finger's patch: see engine/grasp/small_contacts.h.
struct SmallPatch {
  double narrow = 0.0;    ///< Share of Hertz's patch in its contacts, against those of whole cells.
  double overhang = 0.0;  ///< Share of the paraboloid that stands for the object, against its surface.

  [[nodiscard]] explicit operator bool() const { return narrow > 0.0 || overhang > 0.0; }
};

/// Output of the control / free-motion side to the contact side: contacts in body-fixed terms, their compliance, and
/// the drive, all taken at one snapshot of the state and frozen until the next frame.
///
/// The frame holds neither W nor J_c, and of C only the kernels: W(h) = h J_c B^-1 J_c' + (1 - rho) C contains the
/// step, and J_c and the axes of C the bodies' motion since the snapshot. The stepping side computes these.
struct Frame {
  explicit Frame(const Model& model);

  std::int64_t sequence = -1;          ///< 0, 1, 2, …; -1: empty.
  std::int64_t tick = 0;               ///< Tick of the snapshot, from which the frame's age counts.
  Eigen::Isometry3d X_WO;              ///< Pose of the object at the snapshot.
  PerFinger<Eigen::Isometry3d> X_WF;   ///< Poses of the distal segments at the snapshot.
  std::vector<FrameContact> contacts;  ///< Sorted by finger and control point.
  std::vector<Eigen::Index> begin;     ///< Finger k has contacts begin[k] .. begin[k + 1).
  /// Control points in the band that their finger's list has no room for: sorted by finger.
  std::vector<FrameContact> left_out;
  PerFinger<SmallPatch> small;
  std::vector<SurfaceCompliance> compliance;  ///< Compliance among a finger's contacts, with its softness.
  /// Numbers of the contacts, and of them with their compliance, that frames have in common while these are the same:
  /// see KeptCompliance. < 0: unlike any other.
  std::int64_t list = -1, compliance_edition = -1;
  PerFinger<double> softness;     ///< Share of a pulp's compliance left under its load; 1 without load.
  Eigen::MatrixXd object_kernel;  ///< k_ij of a soft object, among all contacts; of a rigid one none.
  JointVector torque_Nm;          ///< tau - g: drive of the fingers without contact and
                                  ///< without their slides' own forces.
  MuscleVector muscle_N;          ///< Commanded muscle forces f of tau = H f; empty without muscles.
  // For a scene whose muscles act on the contact side (Scene::muscles_act), else empty:
  std::vector<Belly> bellies;      ///< Bellies at the snapshot.
  JointVector q;                   ///< Joint angles at the snapshot, to which the above refers.
  JointVector q_rest;              ///< q_0: joint angles to which the commands of lengthened muscles refer.
  PerFinger<JointMatrix> turning;  ///< dg/dq [N m/rad].
  Vector6d wrench;                 ///< W_ext on the object, world axes [N, N m].
  ArmOrder arm;                    ///< The last one of a task in phases.

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(contacts.size()); }
};

/// Returns the frame (columns n, t1, t2, distal axes) of a contact with normal n. The tangents are fixed in the finger
/// and carried to n along the great circle from the pulp's mean normal: they depend on the posture alone and turn with
/// n without a twist, parallel transport without a history. Requires unit vectors.
[[nodiscard]] Eigen::Matrix3d contact_frame(const Eigen::Vector3d& pulp_normal, const Eigen::Vector3d& n_F);

/// Returns orthonormal right-handed axes: the unit vector n, and along t1 as far as it is across n.
[[nodiscard]] Eigen::Matrix3d axes_of(const Eigen::Vector3d& n, const Eigen::Vector3d& t1);

/// Gap and normal at the deformed finger point of a contact.
struct ContactGap {
  double gap_m;  ///< Signed.
  Eigen::Vector3d
      n_F;  ///< Normal into the object at the point's foot; distal frame. Shorter than 1 at a centre of curvature.
};

/// Computes the gap with the object at X_FO in the distal frame and both deformed there, the pulp by u, the object by
/// u_o: the distance of p - u from the contact's torus, which is fixed in the object at s + u_o.
[[nodiscard]] ContactGap contact_gap(const FrameContact& contact, const Eigen::Isometry3d& X_FO,
                                     const Eigen::Vector3d& u_F, const Eigen::Vector3d& u_O = Eigen::Vector3d::Zero());

}  // namespace thenar
