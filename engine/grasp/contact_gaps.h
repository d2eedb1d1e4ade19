// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>

#include "engine/grasp/frame.h"
#include "engine/grasp/lanes.h"
#include "engine/grasp/object_compliance.h"
#include "engine/grasp/state.h"

namespace thenar {

/// The gaps of up to four contacts of one finger, their points deformed as a state has them: one in each lane. Lanes
/// beyond these are of no use.
struct ContactGaps {
  lanes::Vector u_F;  ///< The pulp's displacement; distal frame.
  lanes::Numbers gap_m;
  lanes::Vector n_F;  ///< As ContactGap::n_F.
};

/// Computes the gaps of one to four contacts of one finger as contact_gap() does, with the object at X_FO, displaced
/// there by u_O; object frame.
[[nodiscard]] ContactGaps contact_gaps(std::span<const FrameContact> contacts, const Eigen::Isometry3d& X_FO,
                                       const State& state, const lanes::Vector& u_O);

/// Calls back with contacts that are in the lanes together, one to four of one finger: `use(first, block)`, with the
/// index of the block's first.
template <typename Use>
void for_each_block(std::span<const FrameContact> contacts, const Use& use) {
  for (Eigen::Index first = 0, count = 0; first < std::ssize(contacts); first += count) {
    const Eigen::Index most = std::min<Eigen::Index>(lanes::kLanes, std::ssize(contacts) - first);
    count = 1;
    while (count < most && contacts[first + count].finger == contacts[first].finger) ++count;
    use(first, contacts.subspan(first, count));
  }
}

/// Calls back with the gap of each contact at a state, `use(i, gap_m)`, with the object at X_FO in each distal frame.
template <typename Use>
void for_each_gap(const Model& model, std::span<const FrameContact> contacts, const PerFinger<Eigen::Isometry3d>& X_FO,
                  const State& state, const Use& use) {
  for_each_block(contacts, [&](Eigen::Index first, std::span<const FrameContact> block) {
    lanes::Vector u_O = {};
    if (model.soft_object()) {
      for (int lane = 0; lane < std::ssize(block); ++lane) {
        lanes::set(u_O, lane, object_displacement(model, state, block[lane]));
      }
    }
    const ContactGaps gaps = contact_gaps(block, X_FO[block.front().finger], state, u_O);
    for (int lane = 0; lane < std::ssize(block); ++lane) use(first + lane, gaps.gap_m[lane]);
  });
}

}  // namespace thenar
