// SPDX-License-Identifier: Apache-2.0
// How a program of yours runs a grasp: load a scene, tick, read the state.

#include <cstdio>
#include <exception>

#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/studies/load_model.h"

int main(int argc, char** argv) try {
  const thenar::Model model = thenar::load_model(argc > 1 ? argv[1] : "configs/box_grasp.yaml");
  thenar::State state(model);  // all that moves: q, object pose, deformation, forces
  thenar::Frame frame(model);  // contacts and drive, frozen between control ticks
  thenar::Controller controller(model);
  thenar::ContactMemory memory(model);  // what the contact tick keeps from tick to tick
  thenar::ContactScratch work(model);   // what it works in: it takes no memory later

  for (int tick = 0; tick < 500; ++tick) {
    if (model.control_is_due(tick)) thenar::control_tick(model, state, controller, frame);
    const thenar::TickReport report = thenar::contact_tick(model, frame, memory, work, state);
    if (tick % 100 == 99) {
      const double time_s = static_cast<double>(state.tick) * model.scene.step_s;
      std::printf("%.1f s: %ld contacts carry force, residual %.0e, the thumb presses with %.2f N\n", time_s,
                  static_cast<long>(report.active), report.solve.residual, state.load[0].normal_N);
    }
  }
  return 0;
} catch (const std::exception& error) {  // load_model says what is wrong with a scene, and where
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
