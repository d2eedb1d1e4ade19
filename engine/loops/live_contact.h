// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <vector>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/loops/film_tap.h"
#include "engine/loops/latest_value.h"
#include "engine/loops/live_input.h"
#include "engine/loops/picture.h"
#include "engine/loops/split_grasp.h"

namespace thenar {

/// The contact problem of one tick with its forces: all data to solve it again elsewhere.
struct SolvedTick {
  explicit SolvedTick(const Model& model);

  Frame frame;
  ContactKinematics kinematics;
  Mobility mobility{};
  Eigen::VectorXd delta_free, mu, f_first, f;  ///< Values of the tick.

  // With an environment: the object's contacts with it, their forces, and the object's motion without any contact.
  std::vector<GroundContact> ground;  ///< Capacity most_touches().
  std::vector<Eigen::Vector3d> ground_N;
  GroundProblem::Motion x_free = GroundProblem::Motion::Zero();
};

/// The user's connection to a contact loop: the newest input goes in, pictures and solved problems come out, through
/// buffers that cannot block. Unwatched, it costs the loop two atomic loads.
struct LiveContact {
  /// Allocates all memory. `inputs` and `hands` outlive it: the hands' state outlasts the model.
  LiveContact(const Model& model, LatestValue<LiveInput>& inputs, LiveHands& hands);

  // For the contact thread; neither allocates, locks, throws nor calls the system.
  /// Returns the input of the tick that begins now. `stamp_ns` is the input's stamp if it is new, else 0.
  [[nodiscard]] TickInput input(const State& state, std::int64_t now_ns, std::int64_t& stamp_ns) noexcept;
  /// Handles the end of a tick; returns true if a picture of it was taken.
  bool show(const SplitGrasp& grasp) noexcept;

  LatestValue<LiveInput>& inputs;
  LiveHands& hands;
  std::int64_t number = 0;  ///< Number of the last input.
  // Ticks between pictures, and between problems; to be set while no loop runs.
  std::int64_t picture_ticks = 1, problem_ticks = 1;
  FilmTap* tap = nullptr;  ///< Tap of a recording, with its own pictures; null: none.

  std::atomic<bool> watched{false};  ///< True if it is watched; any thread sets it.
  LatestValue<Picture> pictures;     ///< For one reader, as `problems`.
  LatestValue<SolvedTick> problems;
};

}  // namespace thenar
