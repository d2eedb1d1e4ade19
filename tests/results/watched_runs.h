// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/results/grasp_monitor.h"
#include "tests/support/scenes.h"

/// Runs as a monitor is given them.
namespace thenar::watched_runs {

inline const Model& minimal() {
  static const Model model = build_model(scene_of("minimal"));
  return model;
}

/// A control tick that found all its forces.
inline ControlReport solved() {
  ControlReport report(minimal().scene.hand);
  for (GraspContact& contact : report.contacts) contact.axes.setIdentity();
  return report;
}

/// Ticks and control ticks as a monitor takes them.
struct Watched {
  std::vector<TickRecord> ticks;
  std::vector<std::pair<double, ControlReport>> controls;

  [[nodiscard]] Verdict verdict(const Model& model = minimal()) const {
    GraspMonitor monitor(model);
    const Eigen::VectorXd none;
    auto control = controls.begin();
    for (const TickRecord& tick : ticks) {
      for (; control != controls.end() && control->first < tick.time_s; ++control) {
        monitor.add(control->first, control->second, none);
      }
      monitor.add(tick);
    }
    return monitor.verdict();
  }
  [[nodiscard]] Outcome outcome() const { return verdict().outcome; }
  /// From this tick on a finger has slipped so much more.
  void slip(std::size_t from, int finger, double more_m) {
    ticks[from].contact.patch[finger].slip_m = more_m;
    ticks[from].contact.patch[finger].sliding_share = 1.0;
    for (std::size_t i = from; i < ticks.size(); ++i) ticks[i].slip_m[finger] += more_m;
  }
  /// From this tick on a patch has walked so much more, and turned.
  void walk(std::size_t from, int finger, const Eigen::Vector3d& more_m, double turn_rad = 0.0) {
    for (std::size_t i = from; i < ticks.size(); ++i) {
      ticks[i].walk_m[finger] += more_m;
      ticks[i].turn_rad[finger] += turn_rad;
    }
  }
  void unsolved_muscles(double time_s) {
    ControlReport report = solved();
    report.muscle = MuscleStatus::kInfeasible;
    controls.emplace_back(time_s, report);
  }
};

/// A run of 0.5 s in steps of 1 ms in which nothing happens, every finger loaded by force_N(tick).
template <typename Force>
Watched steady_run(Force force_N) {
  Watched run;
  for (int i = 0; i < 500; ++i) {
    TickRecord tick(minimal().scene.hand);
    tick.q_rad = minimal().scene.posture;
    tick.time_s = 1e-3 * (i + 1);
    tick.position_m = tick.target_m = Eigen::Vector3d::Zero();
    for (auto& force : tick.force) force.normal_N = force_N(i);
    run.ticks.push_back(tick);
  }
  return run;
}
inline Watched steady_run() {
  return steady_run([](int) { return 2.0; });
}

}  // namespace thenar::watched_runs
