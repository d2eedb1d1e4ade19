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

/// The grasps of a session: what is searched, what was found, and which one runs. The session's mutex keeps the two
/// calls apart that say so.
class LiveGrasps {
 public:
  /// `asked`: nothing stands for the scene that runs, all that it asks of a grasp left open. `recorded`: a recording is
  /// made, which has the fingers of this scene and no others.
  LiveGrasps(const thenar::Model& model, const std::optional<AskedScene>& asked, bool recorded);

  // The server's thread. Each returns why it does nothing, or nothing.
  /// Searches with the settings of now, as far as somebody has changed them since the scene began. Under the session's
  /// mutex.
  [[nodiscard]] std::string find(const Find& wish, const LiveSettings& begun, const LiveSettings& now);
  [[nodiscard]] std::string stop() { return search_.stop(); }
  /// Whether the grasp can be taken.
  [[nodiscard]] std::string check(const Take& grasp);

  // The calling thread.
  /// The model of a scene that begins with the grasp; nothing if another search has begun since.
  [[nodiscard]] std::optional<thenar::Model> take(const Take& grasp);
  /// From now on searches ask for what the one asked for that found the taken grasp, with what was set then. Under the
  /// session's mutex.
  void ask_as_taken() { now_asked_ = found_ ? found_->asked : asked_; }
  /// Calls `set_grasps` with the message to pages when it has changed: how far a search is, ten times a second.
  void show(const std::function<void(std::string)>& set_grasps);

 private:
  const AskedScene asked_;                           ///< By the scene itself.
  const thenar::Scene own_;                          ///< That it began with.
  const std::vector<std::string> recorded_fingers_;  ///< Empty: nothing is recorded.
  GraspSearch search_;
  AskedScene now_asked_;                      ///< By the next search; the session's mutex is for this.
  Take taken_;                                ///< The grasp that runs.
  std::shared_ptr<const FoundGrasps> found_;  ///< Among these; null: it is the scene's own start.
  SearchState shown_;                         ///< The search as pages have it.
  Take shown_taken_;                          ///< The grasp that runs, as pages have it.
  std::int64_t shown_ns_ = 0;
};

}  // namespace thenar::window
