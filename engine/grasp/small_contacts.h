// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "collision/contact_finding.h"
#include "collision/solids/surface_form.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Returns the curvatures of the gap between a pulp of this radius and a place of an object, along the place's t1 and
/// across it.
[[nodiscard]] Eigen::Vector2d relative_per_m(const SurfaceForm& object, double radius_m);

/// Computes the SmallPatch of a pulp of this radius and spacing of control points at a place of an object this deep in
/// it. The patch is Hertz's where the undeformed bodies overlap by more than half of the depth. Zeros at edges and in
/// hollows that are narrower than the pulp.
[[nodiscard]] SmallPatch small_patch(const SurfaceForm& object, double radius_m, double spacing_m, double depth_m);

/// Part of a patch nearest to a control point, in the plane of the patch.
struct PatchCell {
  Eigen::Index control_point = 0;
  Eigen::Vector2d y = Eigen::Vector2d::Zero();  ///< The control point [m].
  double share_m2 = 0.0;
  Eigen::Vector2d moment_m3 = Eigen::Vector2d::Zero();  ///< First moment of the share about the control point.
};

/// Workspace for finding small contacts, with the memory from frame to frame.
struct SmallContacts {
  PerFinger<KnownSample> known;
  std::vector<PatchCell> cells;
  std::vector<FrameContact> contacts;
};

/// Finds Hertz's contact of a pulp with a part so small that it falls between control points, or goes so deep that the
/// pulp would close around it. It blends into the contacts of control points as both become untrue.
///
/// For a patch narrower than the spacing of control points each bears the part in its own cell: its contact is in the
/// middle of that share, and gives way as a patch of that size does, so that the force is Hertz's wherever the patch
/// lies among control points. A patch is where the undeformed bodies overlap by more than half of the most.
///
/// An object deeper than it is wide has overhanging sides. Points that press on these would slip off, as the skin
/// between them does not let them: there the object is Hertz's paraboloid, pressed along its axis.
///
/// `small` holds the changed contacts of a finger and those added, at most one per control point. Returns zeros, with
/// nothing changed, if the finger presses nothing small. A finger has one such patch, where it is deepest;
/// towards an edge it fades. Contacts are found for the band and what the finger may travel. Does not allocate.
SmallPatch add_small_contacts(const Model& model, const ContactSnapshot& snapshot, const Eigen::Isometry3d& X_OF,
                              int finger, double band_m, std::span<const FrameContact> contacts, SmallContacts& small);

/// Returns the object's nearest place to x, from its samples within reach; exactly, where it has a formula.
[[nodiscard]] std::optional<SurfaceForm> nearest_surface(const Model& model, const Eigen::Vector3d& x_O, double reach_m,
                                                         KnownSample& known);

/// Places a contact at this point of the object, whose outward normal there is n.
void put_on_surface(const Eigen::Vector3d& s_O, const Eigen::Vector3d& n_O, const SurfaceBend& bend,
                    const Fingertip& tip, const Eigen::Matrix3d& R_OF, FrameContact& contact);

/// Makes a contact of a control point at p in the distal frame with this place of the object, likewise.
[[nodiscard]] FrameContact frame_contact(const Fingertip& tip, const Eigen::Matrix3d& R_OF, int finger,
                                         Eigen::Index control_point, const Eigen::Vector3d& p_F,
                                         const Eigen::Vector3d& s_O, const Eigen::Vector3d& n_O,
                                         const SurfaceBend& bend);

}  // namespace thenar
