// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/split_runs.h"

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

Model timed(Model model, const Timing& timing) {
  model.scene.step_s = timing.step_s;
  model.scene.control_period_s = timing.period_s;
  model.scene.control_delay_s = timing.delay_s;
  return model;
}

State at_time(State state, double time_s, const Model& model) {
  state.tick = std::lround(time_s / model.scene.step_s);
  return state;
}

Path run_in_one_loop(const Model& model, State& state, double from_s, double until_s) {
  const Scene& scene = model.scene;
  const auto end = std::lround(until_s / scene.step_s), delay = std::lround(scene.control_delay_s / scene.step_s);
  Path path(scene, state, from_s);
  Frame frame(model);
  Controller controller(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  std::deque<std::pair<std::int64_t, JointVector>> drives;  // and from when on
  Stopwatch wall;
  for (std::int64_t sequence = 0; state.tick < end; ++sequence) {
    if (sequence == 0 || model.control_is_due(state.tick)) {
      (void)control_tick(model, state, controller, frame);
      drives.emplace_back(state.tick + (sequence == 0 ? 0 : delay), frame.torque_Nm);
    } else {
      frame.tick = state.tick;
      frame.X_WO = state.X_WO;
      forward_kinematics(scene.hand, state.q, controller.pose);
      for (int k = 0; k < scene.hand.fingers(); ++k) frame.X_WF[k] = controller.pose.distal(scene.hand, k);
      find_frame_contacts(model, controller.pose, state, controller.search, frame);
      controller.compliance.update(model, frame);
    }
    frame.sequence = sequence;
    while (drives.size() > 1 && drives[1].first <= state.tick) drives.pop_front();
    frame.torque_Nm = drives.front().second;
    path.add(state, contact_tick(model, frame, memory, work, state));
  }
  path.wall_s = wall.lap();
  return path;
}

Path run_split(const Model& model, const State& state, double from_s, double until_s, bool offset) {
  const auto end = std::lround(until_s / model.scene.step_s);
  Path path(model.scene, state, from_s);
  GraspRun loops(model, LockstepSettings{});
  loops.state = state;
  if (!offset) loops.memory.policy.offset_decay_s = 0.0;
  Stopwatch wall;
  while (loops.state.tick < end) {
    const TickReport tick = loops.tick();
    path.add(loops.state, tick);
  }
  path.wall_s = wall.lap();
  return path;
}

PathError path_error(const Path& path, const Path& reference) {
  PathError sum;
  double ticks = 0.0, loads = 0.0;
  for (std::size_t i = 0; i < path.X_WO.size(); ++i) {
    if (path.time_s(i) <= path.from_s) continue;
    const std::size_t j = reference.at(path.time_s(i));
    const Eigen::Isometry3d &X = path.X_WO[i], &X_ref = reference.X_WO[j];
    sum.position_m += (X.translation() - X_ref.translation()).squaredNorm();
    sum.rotation_rad += std::pow(Eigen::AngleAxisd(X_ref.linear().transpose() * X.linear()).angle(), 2);
    ++ticks;
    for (Eigen::Index k = 0; k < reference.force_N[j].cols(); ++k) {
      if (reference.force_N[j].col(k).isZero()) continue;
      sum.force_N += (path.force_N[i] - reference.force_N[j]).col(k).squaredNorm();
      ++loads;
    }
  }
  return {std::sqrt(sum.position_m / ticks), std::sqrt(sum.rotation_rad / ticks),
          std::sqrt(sum.force_N / std::max(loads, 1.0))};
}

}  // namespace thenar
