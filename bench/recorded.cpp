#include "bench/recorded.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

namespace thenar {

using Eigen::Index;

namespace {

constexpr int kFrom = 700, kTo = 900;  // Ticks: the box moves at 25 to 37 mm/s.

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
    if (tick >= kFrom) states.push_back(state);
    const ControlReport control = control_tick(model, state, controller, frame);
    if (tick >= kFrom) controls.push_back(control);
    const TickReport report = contact_tick(model, frame, work, state);
    if (tick >= kFrom && report.contacts != contacts) throw std::runtime_error("the recorded run lost contacts");
  }
}

const RecordedRun& recorded_run(Index contacts) {
  static std::map<Index, RecordedRun> runs;
  return runs.try_emplace(contacts, contacts).first->second;
}

std::vector<RecordedContacts> recorded_contacts(const RecordedRun& run) {
  Frame frame(run.model);
  Controller controller(run.model);
  ContactWorkspace work(run.model);
  std::vector<RecordedContacts> problems;
  for (const State& recorded : run.states) {
    State state = recorded;
    (void)control_tick(run.model, state, controller, frame);
    const Index n = frame.size();
    RecordedContacts problem;
    problem.f_last.setZero(3 * n);
    for (Index i = 0; i < n; ++i) {
      const FrameContact& contact = frame.contacts[i];
      const auto last = std::find_if(state.forces.begin(), state.forces.end(), [&](const ContactForce& force) {
        return force.finger == contact.finger && force.control_point == contact.control_point;
      });
      if (last != state.forces.end()) problem.f_last.segment<3>(3 * i) = last->f_C;
    }
    (void)contact_tick(run.model, frame, work, state);
    problem.W = work.W(n);
    problem.delta_free = work.delta_free.head(3 * n);
    problem.mu = work.mu.head(n);
    problems.push_back(std::move(problem));
  }
  return problems;
}

}  // namespace thenar
