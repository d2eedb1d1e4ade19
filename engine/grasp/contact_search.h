// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collision/contact_finding.h"
#include "engine/grasp/edge_contacts.h"
#include "engine/grasp/fine_contacts.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/small_contacts.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"

namespace thenar {

/// The contact of a control point as it was found in an earlier frame. It serves the frames that follow, in the object,
/// until the point has moved so far from where it was that the surface there, or the way to it, may be another.
struct HeldContact {
  FrameContact contact;
  Eigen::Vector3d p_O;  ///< The control point then, at rest.
  Eigen::Vector3d x_O;  ///< The same as it was deformed.
  double gap_m;         ///< Gap at rest then.
  double deformed_gap_m;
  double free_m;        ///< It holds while neither is farther from there; 0: for one frame; < 0: no longer.
  Eigen::Index sample;  ///< Sample of the object nearest to p then.
  int face;             ///< Exact face of the object; -1: none.
  bool is_smooth;       ///< See SurfaceDistance.
  bool is_round;        ///< The surface there is narrower than the pulp, which touches what faces it alone.
};

/// A control point near the object in one frame.
struct NearPoint {
  double gap_m;    ///< At rest.
  double least_m;  ///< The lesser of this and the gap as it is deformed.
  bool is_beyond;  ///< The face nearest to it is turned away from the pulp: it has passed the middle of a thin part.
  const HeldContact* held;

  [[nodiscard]] Eigen::Index control_point() const { return held->contact.control_point; }
  bool operator<(const NearPoint& other) const {
    return gap_m < other.gap_m || (gap_m == other.gap_m && held < other.held);
  }
};

/// Workspace for finding contacts, with the memory from frame to frame.
struct ContactSearch {
  explicit ContactSearch(const Model& model);

  PerFinger<FindingMemory> memory;
  PerFinger<std::vector<KnownSample>> known_deformed;  ///< Samples near the deformed control points.
  PerFinger<std::vector<HeldContact>> held;            ///< Contacts in or near the band, by control point.
  PerFinger<std::vector<KnownSample>> known_before;    ///< Samples before them along the pulp's normals.
  PerFinger<KnownSample> known_ball;                   ///< Sample nearest to the pulp.
  PerFinger<Eigen::Isometry3d> X_OF_then;              ///< Poses of the fingers at the last frame.
  std::int64_t tick_then = -1;                         ///< Tick of the last frame; < 0: none.
  EdgeWork edges;
  std::vector<ContactCandidate> candidates;  ///< Those of control points whose contact is not held.
  std::vector<NearPoint> near;               ///< First those that there is room for, by control point.
  std::size_t room = 0;                      ///< Number of these.
  Eigen::VectorXd moved_m;                   ///< |u| of one finger's control points.
  std::vector<FrameContact> contacts;        ///< Contacts of one finger.
  SmallContacts small;
  FineContacts fine;
};

/// Finds the frame's contacts on the rest shapes of the fingertips: control points of the pulps that are, or while the
/// frame is in use may come, nearer to the object than the contact band; or, for rigid fingertips, the one point of
/// each pulp that is nearest to it.
///
/// A pulp pressed on a plate by more than half its thickness has points beyond the plate's middle, nearer to its back.
/// They touch the side that the pulp comes from: it is seen along the pulp's normals, from its inside, as all is at
/// edges (edge_contacts.h).
/// Samples of a part too fine to meet a control point for sure (`Model::fine_m`) are looked for in the pulp.
/// Contacts that do not fit a finger's list go to `frame.left_out`.
/// `frame` has its drive. Does not allocate, after the first call.
void find_frame_contacts(const Model& model, const HandPose& pose, const ContactSnapshot& snapshot,
                         ContactSearch& search, Frame& frame);

}  // namespace thenar
