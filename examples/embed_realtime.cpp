// SPDX-License-Identifier: Apache-2.0
// How a real-time thread of yours, here a haptic device's, holds an object by a spring: it calls contact_step at its
// own rate, and another thread calls control_step.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <thread>
#include <vector>

#include "engine/loops/realtime.h"
#include "engine/loops/split_grasp.h"
#include "engine/studies/load_model.h"

using Eigen::Vector3d;

namespace {
constexpr double kStiffness_N_per_m = 50.0;  // of the virtual coupling
/// Stands for the device's driver: a hand that moves to and fro by 5 mm.
Vector3d device_position(double time_s) { return {0.0, 0.005 * std::sin(2.0 * M_PI * time_s), 0.0}; }
}  // namespace

int main(int argc, char** argv) try {
  const thenar::Model model = thenar::load_model(argc > 1 ? argv[1] : "configs/box_grasp.yaml");
  thenar::SplitGrasp grasp(model);  // takes all memory, and makes the first frame
  if (grasp.first_control().grasp != thenar::GraspStatus::kOptimal) {
    std::fprintf(stderr, "no grasp forces hold the object at the start\n");
    return 6;
  }
  // The last core is the device thread's alone: this thread, and what it starts from now on, keeps to the others.
  const std::vector<int> cores = thenar::allowed_cores();
  if (cores.size() > 1) thenar::keep_to_cores({cores.begin(), cores.end() - 1});
  const Vector3d start = model.scene.object.X_WO.translation();

  const std::jthread control([&](const std::stop_token& stop) {
    const std::chrono::nanoseconds period(std::lround(1e9 * model.scene.control_period_s));
    auto due = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      std::this_thread::sleep_until(due += period);
      grasp.control_step();
    }
  });

  double force_N = 0.0;  // the most that the device showed its user
  std::thread device([&] {
    const thenar::Scheduling granted = thenar::ask_for_realtime(cores.empty() ? -1 : cores.back());
    thenar::flush_denormals();
    std::printf("%s %s\n", granted.policy.c_str(), granted.remark.c_str());
    thenar::Schedule schedule(thenar::steady_now_ns() + 1'000'000, model.scene.step_s, 500, 2);
    while (const auto tick = schedule.next(thenar::steady_now_ns())) {
      thenar::wait_until(tick->deadline_ns, 50'000);
      const thenar::State& state = grasp.state();
      const double time_s = static_cast<double>(state.tick) * model.scene.step_s;
      thenar::TickInput input;  // a wrench on the object; input.X_WT would move its target
      input.wrench.head<3>() = kStiffness_N_per_m * (start + device_position(time_s) - state.X_WO.translation());
      grasp.contact_step(input);
      force_N = std::max(force_N, input.wrench.head<3>().norm());
    }
  });
  device.join();
  std::printf("The device pushed back with up to %.2f N; the thumb presses with %.2f N.\n", force_N,
              grasp.state().load[0].normal_N);
  return 0;
} catch (const std::exception& error) {  // load_model says what is wrong with a scene, and where
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
