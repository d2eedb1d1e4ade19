#include "bench/recorded.h"

#include <map>
#include <stdexcept>
#include <string>

#include "engine/handover.h"

namespace thenar {

using Eigen::Index;

namespace {

constexpr int kFrom = 700, kTo = 800;  // Ticks: the box moves at 35 to 45 mm/s.

Scene box_scene(Index contacts) {
  return load_scene(THENAR_CONFIGS "/box_grasp.yaml",
                    {"contact.max_per_finger=" + std::to_string(contacts / kFingers)});
}

}  // namespace

RecordedRun::RecordedRun(Index contacts) : model(box_scene(contacts)) {
  State state(model);
  Frame frame(model);
  Controller controller(model);
  ContactWorkspace work(model);
  for (int tick = 0; tick < kTo; ++tick) {
    const bool recorded = tick >= kFrom;
    if (recorded) ticks.push_back({state, controller, {}});
    const ControlReport control = control_tick(model, state, controller, frame);
    Eigen::VectorXd f_last(3 * model.max_contacts);
    carry_forces(model, frame, state.forces, f_last);
    (void)contact_tick(model, frame, work, state);
    if (!recorded) continue;
    if (frame.size() != contacts) throw std::runtime_error("the recorded run lost contacts");
    ticks.back().control = control;
    problems.push_back({work.W(contacts), work.delta_free.head(3 * contacts), work.mu.head(contacts), f_last});
  }
}

const RecordedRun& recorded_run(Index contacts) {
  static std::map<Index, RecordedRun> runs;
  return runs.try_emplace(contacts, contacts).first->second;
}

}  // namespace thenar
