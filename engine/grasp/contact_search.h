#pragma once

#include <cstdint>
#include <vector>

#include "collision/contact_finding.h"
#include "collision/solids/surface_form.h"
#include "engine/grasp/edge_contacts.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/small_contacts.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"

namespace thenar {

/// The foot that a control point had on an exact face when it was at x. It serves the frames that follow, until the
/// point has gone so far along the surface that the form there may be another.
struct HeldFoot {
  Eigen::Vector3d x_O = Eigen::Vector3d::Constant(1e9);
  int face = -1;  ///< -1: none; only the normal of `at` is valid, from the samples.
  SurfaceForm at;
};

/// Workspace for finding contacts, with the memory from frame to frame.
struct ContactSearch {
  explicit ContactSearch(const Model& model);

  PerFinger<FindingMemory> memory;
  PerFinger<std::vector<KnownSample>> known_deformed;  ///< Samples near the deformed control points.
  PerFinger<std::vector<HeldFoot>> feet;               ///< Their feet on exactly known faces.
  PerFinger<std::vector<KnownSample>> known_before;    ///< Samples before them along the pulp's normals.
  PerFinger<KnownSample> known_ball;                   ///< Sample nearest to the pulp.
  PerFinger<Eigen::Isometry3d> X_OF_then;              ///< Poses of the fingers at the last frame.
  std::int64_t tick_then = -1;                         ///< Tick of the last frame; < 0: none.
  EdgeWork edges;
  std::vector<ContactCandidate> candidates, left_out;
  Eigen::VectorXd moved_m;             ///< |u| of one finger's control points.
  std::vector<Eigen::Index> deepest;   ///< Fine sample of the object deepest in the pulp, by control point; -1: none.
  std::vector<FrameContact> contacts;  ///< Contacts of one finger.
  SmallContacts small;
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
