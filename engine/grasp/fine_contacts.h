// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/hand/hand.h"

namespace thenar {

/// Workspace for finding fine contacts.
struct FineContacts {
  std::vector<Eigen::Index> deepest;   ///< Fine sample of the object deepest in the pulp, by control point; -1: none.
  std::vector<FrameContact> contacts;  ///< Contacts of one finger.
};

/// Hands a finger's contacts to the frame, with the object at X_FO in its distal frame: as many of least gap as its
/// list has room for, by control point, and the others to `frame.left_out`. Reorders `contacts`.
void take_nearest(const Model& model, const Eigen::Isometry3d& X_FO, std::vector<FrameContact>& contacts, Frame& frame);

/// Makes the fine samples (`Model::fine_m`) in a finger's pulp, or nearer to it than the band, contacts of the control
/// points that they passed by, unless those are deeper contacts themselves. The normal is the pulp's: a tip has none.
/// The finger's contacts are the last ones of the frame. Does not allocate.
void add_fine_contacts(const Model& model, const HandPose& pose, const Eigen::Isometry3d& X_WO, int finger,
                       double band_m, FineContacts& work, Frame& frame);

}  // namespace thenar
