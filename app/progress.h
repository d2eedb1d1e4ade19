#pragma once

#include "engine/results/monolithic.h"

/// Watches a run: shows on a line of stderr how far it is, if somebody is looking, and ends it early if a signal asks
/// for that (Ctrl-C, SIGTERM, SIGHUP), so that its results are kept. A second signal ends the program at once.
class RunWatch {
 public:
  RunWatch(const thenar::Scene& scene, bool quiet);

  /// For the run; valid as long as this.
  [[nodiscard]] thenar::Progress progress() {
    return [this](double simulated_s, double wall_s) { return tick(simulated_s, wall_s); };
  }
  /// The run has ended: the line, too.
  void end() const;
  /// Whether a signal has ended the run.
  [[nodiscard]] bool interrupted() const { return interrupted_; }

 private:
  bool tick(double simulated_s, double wall_s);

  double duration_s_;
  bool shows_;
  double shown_s_ = 0.0;
  bool interrupted_ = false;
};
