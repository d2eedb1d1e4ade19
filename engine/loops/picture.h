#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// One contact as it is shown, world axes.
struct ShownContact {
  Eigen::Index finger = 0;
  Eigen::Index control_point = 0;
  Eigen::Vector3d point_m;  ///< Where finger and object meet.
  Eigen::Vector3d normal;   ///< Into the object.
  Eigen::Vector3d force_N;  ///< On the object.
  /// What is on the cone, and what it is held against. Where a contact leans at an edge, they are not the parts of
  /// `force_N` along its normal and across it.
  double normal_N = 0.0, friction_N = 0.0;
  double share = 1.0;         ///< Of the control point's cell, what it stands for: less at edges and on small objects.
  double slip_m_per_s = 0.0;  ///< How fast the finger's point goes against the object's, in the tick.
};

/// A contact of the object with a body of its environment that carries force.
struct ShownTouch {
  int body = 0;
  Eigen::Vector3d point_E;  ///< Frame of the body [m].
  Eigen::Vector3d normal;   ///< Into the object, world axes, as the next.
  Eigen::Vector3d force_N;  ///< On the object.
};

/// As many contacts as the object can have with its environment; 0 in a scene that has none.
[[nodiscard]] std::size_t most_touches(const Scene& scene);

/// The spring by which someone pulls the object, world axes.
struct ShownPull {
  Eigen::Vector3d anchor_m, handle_m;
  Eigen::Vector3d force_N;  ///< On the object, at the anchor.
};

/// What one instant looks like: a copy of the state after a tick, for eyes. Its memory is taken once, so that a contact
/// thread may fill it.
struct Picture {
  explicit Picture(const Model& model);

  double step_s;  ///< Of the contact loop.
  Snapshot snapshot;
  std::vector<Eigen::MatrixX3d> u_m;   ///< As State has it.
  std::vector<ShownContact> contacts;  ///< Capacity model.max_contacts.
  std::vector<ShownTouch> touches;     ///< Capacity most_touches().
  std::optional<ShownPull> pull;
};

/// Fills all but `pull`, from the state that a tick left and what that tick worked in. Does not allocate, lock or
/// throw.
void take_picture(const State& state, const ContactMemory& memory, const ContactScratch& work,
                  Picture& picture) noexcept;

}  // namespace thenar
