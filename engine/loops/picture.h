// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// One contact for display, world axes.
struct ShownContact {
  Eigen::Index finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d point_m;  ///< Contact point of finger and object.
  Eigen::Vector3d normal;   ///< Into the object.
  Eigen::Vector3d force_N;  ///< On the object.
  /// Normal and tangential force of the friction cone. Where a contact is tilted at an edge, they are not the parts of
  /// `force_N` along its normal and across it.
  double normal_N = 0.0, friction_N = 0.0;
  double share = 1.0;         ///< Covered share of the control point's cell: less at edges and on small objects.
  double slip_m_per_s = 0.0;  ///< Speed of the finger's point relative to the object's, in the tick.
};

/// A contact of the object with a body of its environment that carries force.
struct ShownTouch {
  int body = 0;
  Eigen::Vector3d point_E;  ///< Frame of the body [m].
  Eigen::Vector3d normal;   ///< Into the object, world axes, as the next.
  Eigen::Vector3d force_N;  ///< On the object.
};

/// Returns the largest number of contacts of the object with its environment; 0 without environment.
[[nodiscard]] std::size_t most_touches(const Scene& scene);

/// The spring by which the user pulls the object, world axes.
struct ShownPull {
  Eigen::Vector3d anchor_m, handle_m;
  Eigen::Vector3d force_N;  ///< On the object, at the anchor.
};

/// A picture of one instant: a copy of the state after a tick, for display. Its memory is allocated once, so that a
/// contact thread may fill it.
struct Picture {
  explicit Picture(const Model& model);

  double step_s;  ///< Step of the contact loop.
  Snapshot snapshot;
  std::vector<Eigen::MatrixX3d> u_m;   ///< See State.
  std::vector<ShownContact> contacts;  ///< Capacity model.max_contacts.
  std::vector<ShownTouch> touches;     ///< Capacity most_touches().
  std::optional<ShownPull> pull;
};

/// Fills all but `pull`, from the state after a tick and that tick's workspace. Does not allocate, lock or throw.
void take_picture(const State& state, const ContactMemory& memory, const ContactScratch& work,
                  Picture& picture) noexcept;

}  // namespace thenar
