#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "collision/contact_finding.h"
#include "engine/frame.h"
#include "engine/hand.h"
#include "engine/model.h"

namespace thenar {

/// What finding contacts works in, and what it remembers from frame to frame.
struct ContactSearch {
  explicit ContactSearch(const Model& model);

  std::array<FindingMemory, kFingers> memory;
  std::vector<ContactCandidate> candidates;
};

/// Finds the frame's contacts on the rest shapes of the fingertips: control points of the pulps, or, for rigid
/// fingertips, the one point of each pulp sphere that is nearest to the object.
void find_frame_contacts(const Model& model, const HandPose& pose, const Eigen::Isometry3d& X_WO, ContactSearch& search,
                         Frame& frame);

}  // namespace thenar
