// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/grasp_search.h"
#include "app/window/live_settings.h"
#include "app/window/message.h"
#include "engine/grasp/model.h"

namespace thenar::window {

/// The grasps of a session: the search, the found grasps and the running one. The session's mutex keeps the two calls
/// apart that say so.
class LiveGrasps {
 public:
  /// `asked`: nothing stands for the scene that runs, all that it asks of a grasp left open.
  LiveGrasps(const thenar::Model& model, const std::optional<AskedScene>& asked);

  // The server's thread. Each returns why it does nothing, or an empty text.
  /// Searches with the settings of now, as far as somebody has changed them since the scene began. Under the session's
  /// mutex.
  [[nodiscard]] std::string find(const Find& wish, const LiveSettings& begun, const LiveSettings& now);
  [[nodiscard]] std::string stop() { return search_.stop(); }
  /// Returns why the grasp cannot be taken, or an empty text. `recorded`: a recording is being made, which has the
  /// fingers of the grasp that runs and no others. Under the session's mutex.
  [[nodiscard]] std::string check(const Take& grasp, bool recorded);

  // The calling thread.
  /// Returns the model of a scene that begins with the grasp; nothing if another search has begun since.
  [[nodiscard]] std::optional<thenar::Model> take(const Take& grasp);
  /// Makes later searches ask as the one that found the taken grasp, with the settings of then. Under the session's
  /// mutex.
  void ask_as_taken();
  /// Calls `set_grasps` with the message to pages when it has changed: how far a search is, ten times a second.
  void show(const std::function<void(std::string)>& set_grasps);

 private:
  const AskedScene asked_;   ///< Scene for searches from the scene's own start.
  const thenar::Scene own_;  ///< Scene that the session began with.
  GraspSearch search_;
  // Guarded by the session's mutex:
  AskedScene now_asked_;                  ///< Scene for the next search.
  std::vector<std::string> now_fingers_;  ///< Fingers of the grasp that runs.

  Take taken_;                                ///< The grasp that runs.
  std::shared_ptr<const FoundGrasps> found_;  ///< Search result with that grasp; null: the scene's own start.
  SearchState shown_;                         ///< The search as pages have it.
  Take shown_taken_;                          ///< The grasp that runs, as pages have it.
  std::int64_t shown_ns_ = 0;
};

}  // namespace thenar::window
