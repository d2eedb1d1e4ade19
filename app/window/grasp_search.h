// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "app/window/message.h"
#include "collision/implicit_surface.h"
#include "engine/finder/finder.h"
#include "engine/grasp/scene.h"

namespace thenar::window {

/// A scene as in its file, before any grasp was taken: with all fingers and its requirements on a grasp.
struct AskedScene {
  thenar::Scene scene;
  std::filesystem::path hand, object;  ///< Files of the scene, as named in the text of a kept scene.
  int fingers = 0;                     ///< Fingers in the hand's file.
};

/// Result of a search; never changed.
struct FoundGrasps {
  int search = 0;    ///< Number of the search.
  AskedScene asked;  ///< Scene with the settings of the search.
  thenar::FinderReport report;
  std::string fault;  ///< Error that ended the search; mostly empty.
  double took_s = 0.0;
};

/// Progress of the newest search.
struct SearchState {
  int search = 0;  ///< Number of the search; 0: there was none.
  bool running = false, stopping = false;
  double share = 0.0;  ///< Share of its stage: below 1 it looks for what fits, at 1 that is tried.
  int found = 0;       ///< Grasps so far in this stage: those that fit, or that held when tried.
  std::shared_ptr<const FoundGrasps> grasps;  ///< Null while it runs.
};

/// Searches grasps on a thread of its own, which gives way to all others: one search at a time.
class GraspSearch {
 public:
  explicit GraspSearch(const thenar::ImplicitSurface& object);
  GraspSearch(const GraspSearch&) = delete;
  GraspSearch& operator=(const GraspSearch&) = delete;

  // From any thread. Both return why they do nothing, or an empty text.
  [[nodiscard]] std::string begin(AskedScene asked, int best);
  /// Stops the search: at least one grasp that fits so far is still tried; those that held are kept.
  [[nodiscard]] std::string stop();
  [[nodiscard]] SearchState state();

  [[nodiscard]] const thenar::ImplicitSurface& object() const { return object_; }

 private:
  struct Order {
    AskedScene asked;
    int best = 1;
  };
  [[nodiscard]] FoundGrasps search(Order order, const std::stop_token& end);
  void work(const std::stop_token& end);

  const thenar::ImplicitSurface object_;
  std::mutex mutex_;  // guards the three below
  std::condition_variable_any ordered_;
  std::optional<Order> order_;
  SearchState state_;
  std::atomic<bool> stop_{false};
  std::jthread thread_;  // the last one: it ends before what it uses
};

/// Returns the scene that begins with a found grasp, by its rank from 1 on.
[[nodiscard]] thenar::Scene grasp_scene(const FoundGrasps& found, int rank);

/// Returns the message to pages: docs/reference/window.md. `taken`: the grasp that runs.
[[nodiscard]] std::string grasps_message(const SearchState& state, const Take& taken);

}  // namespace thenar::window
