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

/// A scene as its file has it, before any grasp was taken: with all fingers, and with what it asks of a grasp.
struct AskedScene {
  thenar::Scene scene;
  std::filesystem::path hand, object;  ///< Its files, as the text of a scene that is kept is to name them.
  int fingers = 0;                     ///< Of the hand's file.
};

/// What a search has found. It is never changed.
struct FoundGrasps {
  int search = 0;    ///< Its number.
  AskedScene asked;  ///< With the settings that it was searched with.
  thenar::FinderReport report;
  std::string fault;  ///< Why it came to no end; mostly empty.
  double took_s = 0.0;
};

/// How far the newest search is.
struct SearchState {
  int search = 0;  ///< Its number; 0: there was none.
  bool running = false, stopping = false;
  double share = 0.0;                         ///< Of its stage: below 1 it looks for what fits, at 1 that is tried.
  int found = 0;                              ///< So far in this stage: what fits, or what held when it was tried.
  std::shared_ptr<const FoundGrasps> grasps;  ///< Null while it runs.
};

/// Searches grasps on a thread of its own, which gives way to all others: one search at a time.
class GraspSearch {
 public:
  explicit GraspSearch(const thenar::ImplicitSurface& object);
  GraspSearch(const GraspSearch&) = delete;
  GraspSearch& operator=(const GraspSearch&) = delete;

  // From any thread. Both return why they do nothing, or nothing.
  [[nodiscard]] std::string begin(AskedScene asked, int best);
  /// Of what fits so far one grasp at least is still tried; those that held are kept.
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
  std::mutex mutex_;  // of the three below
  std::condition_variable_any ordered_;
  std::optional<Order> order_;
  SearchState state_;
  std::atomic<bool> stop_{false};
  std::jthread thread_;  // the last one: it ends before what it uses
};

/// The scene of a found grasp, by its rank from 1 on: it begins with it.
[[nodiscard]] thenar::Scene grasp_scene(const FoundGrasps& found, int rank);

/// The message to pages: docs/reference/window.md. `taken`: the grasp that runs.
[[nodiscard]] std::string grasps_message(const SearchState& state, const Take& taken);

}  // namespace thenar::window
