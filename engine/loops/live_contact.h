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

/// The contact problem of one tick, and the forces that it found: all that it takes to solve it again elsewhere.
struct SolvedTick {
  explicit SolvedTick(const Model& model);

  Frame frame;
  ContactKinematics kinematics;
  Mobility mobility{};
  Eigen::VectorXd delta_free, mu, f_first, f;  ///< As the tick had them.

  // Of a scene that has an environment: the object's contacts with it, their forces, and how the object would move
  // without any contact.
  std::vector<GroundContact> ground;  ///< Capacity most_touches().
  std::vector<Eigen::Vector3d> ground_N;
  GroundProblem::Motion x_free = GroundProblem::Motion::Zero();
};

/// What people have to do with a contact loop: their newest input goes in, pictures and solved problems come out,
/// through buffers that cannot block. While nobody watches, it costs the loop a look at two atomics.
struct LiveContact {
  /// Takes all memory. `inputs` and `hands` outlive it: the hands' memory is older than the model.
  LiveContact(const Model& model, LatestValue<LiveInput>& inputs, LiveHands& hands);

  // The contact thread's; neither allocates, locks, throws nor calls the system.
  /// For the tick that begins now. `stamp_ns` is that of the input if no tick has seen it before, else 0.
  [[nodiscard]] TickInput input(const State& state, std::int64_t now_ns, std::int64_t& stamp_ns) noexcept;
  /// After a tick. Returns whether a picture was taken of it.
  bool show(const SplitGrasp& grasp) noexcept;

  LatestValue<LiveInput>& inputs;
  LiveHands& hands;
  std::int64_t number = 0;  ///< Of the last input.
  // To be set while no loop runs: a picture of every so many ticks, and a problem.
  std::int64_t picture_ticks = 1, problem_ticks = 1;
  FilmTap* tap = nullptr;  ///< Of a recording, which gets its own; null: there is none.

  std::atomic<bool> watched{false};  ///< Whether anybody looks; any thread sets it.
  LatestValue<Picture> pictures;     ///< For one reader, as the next.
  LatestValue<SolvedTick> problems;
};

}  // namespace thenar
