// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/grasp/compliance.h"
#include "engine/grasp/stopwatch.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"

namespace thenar {

/// The clocks of a run.
struct Timing {
  double step_s;
  double period_s;       ///< Between control ticks, each with a frame; in one loop contacts are found at every step.
  double delay_s = 0.0;  ///< Of the frames; in one loop of the drive alone.
};

[[nodiscard]] Model timed(Model model, const Timing& timing);

/// The same moment, counted in the model's steps.
[[nodiscard]] State at_time(State state, double time_s, const Model& model);

/// What a run did, tick by tick.
struct Path {
  double step_s = 0.0, start_s = 0.0;
  double from_s = 0.0;  ///< Where its measures begin.
  std::vector<Eigen::Isometry3d> X_WO;
  std::vector<FingerForces> force_N;                    ///< Of the fingers on the object, world axes.
  double handover_step_N = 0.0, ordinary_step_N = 0.0;  ///< Largest change of a finger's force in a tick.
  double injected_J = 0.0, dissipated_J = 0.0, slip_m = 0.0;
  double wall_s = 0.0;

  Path(const Scene& scene, const State& state, double measured_from_s)
      : step_s(scene.step_s), start_s(static_cast<double>(state.tick) * scene.step_s), from_s(measured_from_s) {}

  /// The end of tick i.
  [[nodiscard]] double time_s(std::size_t i) const { return start_s + static_cast<double>(i + 1) * step_s; }
  /// The tick that ends at this time.
  [[nodiscard]] std::size_t at(double time) const { return std::lround((time - start_s) / step_s) - 1; }

  void add(const State& state, const TickReport& tick) {
    FingerForces force(3, state.load.size());
    for (Eigen::Index k = 0; k < force.cols(); ++k) force.col(k) = state.load[k].force_N;
    if (!force_N.empty() && time_s(X_WO.size()) > from_s) {
      double& largest = tick.handed_over ? handover_step_N : ordinary_step_N;
      largest = std::max(largest, (force - force_N.back()).colwise().norm().maxCoeff());
      injected_J += tick.ledger.injected_J;
      dissipated_J += tick.ledger.dissipated_J;
      double most_m = 0.0;
      for (const PatchReport& patch : tick.patch) most_m = std::max(most_m, patch.slip_m);
      slip_m += most_m;
    }
    X_WO.push_back(state.X_WO);
    force_N.push_back(force);
  }
};

/// Both ticks in one loop, to `until_s`: contacts, geometry and operator are new at every step. A control tick every
/// control period gives the drive, which comes into use a control delay later. The state is left as the run ended.
[[nodiscard]] Path run_in_one_loop(const Model& model, State& state, double from_s, double until_s);

/// The split loops on their virtual clock, from a state to `until_s`; with or without the gap offset at hand-overs.
[[nodiscard]] Path run_split(const Model& model, const State& state, double from_s, double until_s, bool offset = true);

/// Root mean squares over a path's ticks.
struct PathError {
  double position_m = 0.0, rotation_rad = 0.0;
  double force_N = 0.0;  ///< Of the fingers that are loaded in the reference.
};

/// How a path differs from a reference whose step divides its own.
[[nodiscard]] PathError path_error(const Path& path, const Path& reference);

/// A scene, and the state from which all runs of it that are compared go on.
///
/// Where everything sticks, friction remembers the order in which points first touched, which a run at another step
/// takes in another order: a difference of a whole step that would hide what the runners do differently. So such runs
/// begin from one state, a moment after the touch.
struct Course {
  Course(const Scene& scene, const Timing& finest, double start, double from, double until)
      : reference_model(timed(build_model(scene), finest)),
        start_s(start),
        from_s(from),
        until_s(until),
        state(reference_model) {
    if (start_s > 0.0) (void)run_in_one_loop(reference_model, state, start_s, start_s);
  }

  [[nodiscard]] Path in_one_loop(const Timing& timing) const {
    const Model model = timed(reference_model, timing);
    State own = at_time(state, start_s, model);
    return run_in_one_loop(model, own, from_s, until_s);
  }
  [[nodiscard]] Path split(const Timing& timing, bool offset = true) const {
    const Model model = timed(reference_model, timing);
    return run_split(model, at_time(state, start_s, model), from_s, until_s, offset);
  }

  Model reference_model;
  double start_s, from_s, until_s;
  State state;
};

}  // namespace thenar
