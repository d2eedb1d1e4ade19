// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "engine/finder/finder.h"
#include "engine/models/object_surface.h"
#include "engine/results/scene_run.h"

namespace thenar::app {

/// Returns true from the first signal on that asked for an end (Ctrl-C, SIGTERM, SIGHUP) while a SearchWatch or a
/// RunWatch was there: also of one that came later, as the results were written, which are whole then.
[[nodiscard]] bool stop_is_asked();

/// One line of stderr that says how far a command is, if somebody is looking.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);

  /// Replaces the line. Words that follow within a tenth of a second are not shown.
  void show(const std::string& words);
  /// Makes room for the results.
  void clear();

 private:
  bool shows_;
  bool has_shown_ = false;
  std::chrono::steady_clock::time_point shown_at_;
};

/// A line of stderr that says, from the second second on, which stage of making a model ready takes so long, if
/// somebody is looking.
class ReadyingLine {
 public:
  explicit ReadyingLine(bool quiet);

  /// Returns the watch for load_model() and build_model(); valid as long as this.
  [[nodiscard]] StartWatch begins() {
    return [this](const char* stage) { stage_ = stage; };
  }
  /// Hides the line for good: others may write to stderr again.
  void hide() { teller_ = {}; }

 private:
  std::atomic<const char*> stage_ = "";
  std::jthread teller_;
};

/// Watches a search for grasps: shows how far it is, and ends it early if a signal asks for that, so that what was
/// found is kept. A second signal ends the program at once.
class SearchWatch {
 public:
  explicit SearchWatch(bool quiet);

  /// Returns the callback for the search; valid as long as this.
  [[nodiscard]] FinderProgress progress() {
    return [this](double share, int grasps) { return step(share, grasps); };
  }
  void end() { line_.clear(); }

 private:
  bool step(double share, int grasps);

  ProgressLine line_;
};

/// Watches a run: shows on a line of stderr how far it is, if somebody is looking, and ends it early if a signal asks
/// for that (Ctrl-C, SIGTERM, SIGHUP), so that its results are kept. A second signal ends the program at once.
class RunWatch {
 public:
  RunWatch(const Scene& scene, bool quiet);

  /// Returns the callback for the run; valid as long as this.
  [[nodiscard]] Progress progress() {
    return [this](double simulated_s, double wall_s) { return tick(simulated_s, wall_s); };
  }
  /// Ends the line after the run.
  void end() const;

 private:
  bool tick(double simulated_s, double wall_s);

  double duration_s_;
  bool shows_;
  double shown_s_ = 0.0;
};

}  // namespace thenar::app
