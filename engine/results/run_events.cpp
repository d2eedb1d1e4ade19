// SPDX-License-Identifier: Apache-2.0
#include "engine/results/run_events.h"

#include <fmt/format.h>

#include <algorithm>

namespace thenar {

namespace {

/// What the scene does at times that it names.
std::vector<RunEvent> planned(const Scene& scene) {
  std::vector<RunEvent> events;
  double friction = scene.contact.friction;
  for (const FrictionStep& step : scene.task.friction) {
    const char* const way = step.friction < friction ? "falls" : "rises";
    events.push_back({step.from_s, fmt::format("friction {} to {:.3g}", way, step.friction)});
    friction = step.friction;
  }
  if (const auto& push = scene.task.push) {
    events.push_back({push->from_s, "push"});
    events.push_back({push->from_s + push->over_s, "push ends"});
  }
  if (const auto& move = scene.task.translate) events.push_back({move->from_s, "target moves"});
  if (const auto& turn = scene.task.rotate) events.push_back({turn->from_s, "target turns"});
  return events;
}

/// Phases that begin, and the end of the last one.
void add_phases(const Scene& scene, const Recording& recording, std::vector<RunEvent>& events) {
  const std::vector<Phase>& phases = scene.task.phases;
  int last = -1;
  for (const TickRecord& tick : recording.ticks) {
    if (tick.phase == last) continue;
    last = tick.phase;
    if (last < 0) continue;
    const auto number = static_cast<std::size_t>(last);
    events.push_back({tick.time_s, number < phases.size() ? to_string(phases[number].kind) : "task done"});
  }
}

/// Answers of the grip to what fingertips felt.
void add_reflexes(const Scene& scene, const Recording& recording, std::vector<RunEvent>& events) {
  double last_s = -1.0;
  for (const TickRecord& tick : recording.ticks) {
    const LastReflex& reflex = tick.last_reflex;
    if (reflex.event == ReflexEvent::kNone || reflex.time_s == last_s) continue;
    last_s = reflex.time_s;
    const std::string& finger = scene.hand.fingertips[static_cast<std::size_t>(reflex.finger)].finger;
    events.push_back(
        {last_s, fmt::format("grip answers {}, {}", reflex.event == ReflexEvent::kSlip ? "slip" : "load", finger)});
  }
}

}  // namespace

std::vector<RunEvent> run_events(const Scene& scene, const Recording& recording) {
  if (recording.ticks.empty()) return {};
  const double end_s = recording.ticks.back().time_s;
  std::vector<RunEvent> events = planned(scene);
  std::erase_if(events, [&](const RunEvent& event) { return event.time_s > end_s; });
  add_phases(scene, recording, events);
  add_reflexes(scene, recording, events);
  if (recording.verdict.lost_s) events.push_back({*recording.verdict.lost_s, "lost"});
  if (recording.verdict.outcome == Outcome::kTaskFailed) events.push_back({end_s, "task failed"});
  std::ranges::stable_sort(events, {}, &RunEvent::time_s);
  return events;
}

}  // namespace thenar
