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
  int face = -1;  ///< -1: there is none; of `at` the normal alone counts, the samples'.
  SurfaceForm at;
};

/// What finding contacts works in, and what it remembers from frame to frame.
struct ContactSearch {
  explicit ContactSearch(const Model& model);

  PerFinger<FindingMemory> memory;
  PerFinger<std::vector<KnownSample>> known_deformed;  ///< Of control points as they are deformed.
  PerFinger<std::vector<HeldFoot>> feet;               ///< Likewise, on faces that are known exactly.
  PerFinger<std::vector<KnownSample>> known_before;    ///< Likewise, of what is before them along the pulp's normals.
  PerFinger<KnownSample> known_ball;                   ///< Of what is nearest to the pulp.
  PerFinger<Eigen::Isometry3d> X_OF_then;              ///< Where fingers were at the last frame, at this tick;
  std::int64_t tick_then = -1;                         ///< < 0: there was none.
  EdgeWork edges;
  std::vector<ContactCandidate> candidates, left_out;
  Eigen::VectorXd moved_m;             ///< |u| of one finger's control points.
  std::vector<Eigen::Index> deepest;   ///< Of the object's fine samples, by control point; -1: none.
  std::vector<FrameContact> contacts;  ///< One finger's.
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
/// What a finger's list has no room for goes to `frame.left_out`.
/// `frame` has its drive. Does not allocate, after the first call.
void find_frame_contacts(const Model& model, const HandPose& pose, const ContactSnapshot& snapshot,
                         ContactSearch& search, Frame& frame);

}  // namespace thenar
