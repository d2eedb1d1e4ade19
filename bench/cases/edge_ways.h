// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bench/cases/probe.h"

/// Closed ways of a rigid object over a pulp, across its edges, corners and rims.
namespace thenar::truth {

/// An object that is pressed into the pulp along -x at `from`, dragged to `to`, and lifted. The x of both is how far
/// the object's origin is from what touches.
struct EdgeWay {
  std::string name;
  Shape shape;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero(), to_m = Eigen::Vector3d::Zero();
  bool is_pointed = false;  ///< An edge or corner points at the pulp.
};

/// Off an edge, onto a face, over a corner, across an edge and along it to its end, off a cylinder's rim, and off a
/// mug's mouth and bottom.
[[nodiscard]] std::vector<EdgeWay> edge_ways();

/// What the hand that took an object along a way did: its work, by forces and positions alone, and what the ledger
/// says. Nothing is left in the end.
struct Taken {
  double work_J = 0.0, stored_J = 0.0;  ///< The energy stored in the pulp, at most.
  double injected_J = 0.0, dissipated_J = 0.0;
  double largest_N = 0.0, step_N = 0.0;  ///< Of the drag; the step in a tick.
};

/// The probe's shape and pose are those of the way.
[[nodiscard]] Taken take(const EdgeWay& way, double depth_m, Probe probe, double tick_m = 5e-6);

}  // namespace thenar::truth
