// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/imports/body_tree.h"
#include "engine/imports/imported_hand.h"
#include "engine/imports/tree_segments.h"

namespace thenar {

/// Converts tendons with muscles to the hand's muscles. From site to site a crossing has the same moment arms; around a
/// surface it is fitted to them over the joints' ranges, with its errors in `made.muscle_notes`. Throws ConfigError if
/// there are too many.
void import_muscles(const BodyTree& tree, const TreePose& pose, const TreeSegments& segments, ImportedHand& made);

}  // namespace thenar
