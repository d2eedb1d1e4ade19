// SPDX-License-Identifier: Apache-2.0
#include "app/window/grasp_search.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <stop_token>
#include <utility>

#include "engine/loops/realtime.h"
#include "engine/models/scene_grasp.h"
#include "engine/recordings/state_message.h"
#include "engine/results/tick_fields.h"
#include "engine/scenes/scene_text.h"

namespace thenar::window {

using nlohmann::ordered_json;

GraspSearch::GraspSearch(const ImplicitSurface& object)
    : object_(object), thread_([this](const std::stop_token& end) { work(end); }) {}

std::string GraspSearch::begin(AskedScene asked, int best) {
  const std::lock_guard lock(mutex_);
  if (state_.running) return "a search is under way: stop it first";
  state_ = {.search = state_.search + 1, .running = true, .grasps = nullptr};
  stop_.store(false, std::memory_order_relaxed);  // The mutex orders it before the order.
  order_ = {std::move(asked), best};
  ordered_.notify_one();
  return "";
}

std::string GraspSearch::stop() {
  const std::lock_guard lock(mutex_);
  if (!state_.running) return "no search is under way";
  state_.stopping = true;
  stop_.store(true, std::memory_order_relaxed);
  return "";
}

SearchState GraspSearch::state() {
  const std::lock_guard lock(mutex_);
  return state_;
}

FoundGrasps GraspSearch::search(Order order, const std::stop_token& end) {
  FoundGrasps found;
  found.asked = std::move(order.asked);
  const std::int64_t begin_ns = steady_now_ns();
  try {
    const FinderSettings settings{.seed = found.asked.scene.grasp->seed, .best = order.best};
    found.report = find_tried_grasps(found.asked.scene, object_, settings, [&](double share, int grasps) {
      const std::lock_guard lock(mutex_);
      state_.share = share;
      state_.found = grasps;
      return !stop_.load(std::memory_order_relaxed) && !end.stop_requested();
    });
  } catch (const std::exception& error) {
    found.fault = error.what();
  }
  found.took_s = 1e-9 * static_cast<double>(steady_now_ns() - begin_ns);
  return found;
}

void GraspSearch::work(const std::stop_token& end) {
  // Of this thread alone, in Linux. Not 19, as for what nobody waits for.
  setpriority(PRIO_PROCESS, 0, 10);
  std::unique_lock lock(mutex_);
  while (ordered_.wait(lock, end, [this] { return order_.has_value(); })) {
    Order order = *std::exchange(order_, std::nullopt);
    lock.unlock();
    auto found = std::make_shared<FoundGrasps>(search(std::move(order), end));
    lock.lock();
    found->search = state_.search;
    state_.running = state_.stopping = false;
    state_.found = static_cast<int>(found->report.grasps.size());
    state_.grasps = std::move(found);
  }
}

Scene grasp_scene(const FoundGrasps& found, int rank) {
  Scene scene = found.asked.scene;
  take_grasp(found.report.grasps.at(static_cast<std::size_t>(rank) - 1), scene);
  scene.name += fmt::format(", grasp {}", rank);
  return scene;
}

namespace {

/// The scene file of a grasp.
std::string text_of(const FoundGrasps& found, const Scene& scene, int rank) {
  SceneTextNotes notes;
  notes.hand = found.asked.hand;
  notes.object = found.asked.object;
  notes.about = fmt::format("A grasp that thenar found, number {} of its search.", rank);
  notes.grasp =
      "How it holds: " + in_words(found.report.grasps[static_cast<std::size_t>(rank) - 1], found.asked.scene.hand);
  notes.names_fingers = scene.hand.fingers() < found.asked.fingers;
  return scene_text(scene, notes);
}

ordered_json grasp_json(const FoundGrasps& found, int rank) {
  const FoundGrasp& grasp = found.report.grasps[static_cast<std::size_t>(rank) - 1];
  const Scene scene = grasp_scene(found, rank);
  ordered_json fingers = ordered_json::array();
  for (const Fingertip& tip : scene.hand.fingertips) fingers.push_back(tip.finger);
  ordered_json json = {{"fingers", fingers}, {"opposer", fingers[static_cast<std::size_t>(grasp.opposer)]}};
  for (const GraspMeasure& measure : grasp_measures()) {
    json[std::string(measure.name)] = measure.is_of(grasp) ? ordered_json(measure.value(grasp)) : ordered_json(nullptr);
  }
  json["limit_joint"] = grasp.limit_joint;
  json["within_limits"] = grasp.rehearsal.within_limits();
  json["words"] = in_words(grasp, found.asked.scene.hand);
  json["hand"] = posture_json(scene.hand, scene.posture);
  json["object"] = pose_numbers(scene.object.X_WO);
  json["scene"] = text_of(found, scene, rank);
  return json;
}

/// The measures that a page shows of each grasp.
ordered_json measures_json() {
  ordered_json measures = ordered_json::array();
  for (const GraspMeasure& measure : grasp_measures()) {
    if (measure.shown.empty()) continue;
    measures.push_back({{"name", measure.name},
                        {"shown", measure.shown},
                        {"shown_unit", measure.shown_unit},
                        {"factor", measure.factor},
                        {"digits", measure.digits},
                        {"sentence", measure.sentence}});
  }
  return measures;
}

ordered_json refusal_json(const FoundGrasps& found) {
  if (!found.fault.empty()) return {{"reason", found.fault}, {"help", ""}};
  if (!found.report.grasps.empty()) return nullptr;
  if (found.report.cancelled)
    return {{"reason", "nothing that holds was found before the search was stopped"}, {"help", ""}};
  const Refusal refusal = found.report.refusal.value_or(Refusal{"no grasp was found", ""});
  return {{"reason", refusal.reason}, {"help", refusal.help}};
}

}  // namespace

std::string grasps_message(const SearchState& state, const Take& taken) {
  const bool older = taken.grasp > 0 && taken.search != state.search;
  ordered_json json = {{"type", "grasps"},
                       {"search", state.search},
                       {"running", state.running},
                       {"stopping", state.stopping},
                       {"share", state.share},
                       {"found", state.found},
                       {"taken", older ? ordered_json(nullptr) : ordered_json(taken.grasp)},
                       {"refusal", nullptr},
                       {"grasps", ordered_json::array()}};
  if (state.grasps) {
    json["refusal"] = refusal_json(*state.grasps);
    json["took_s"] = state.grasps->took_s;
    json["measures"] = measures_json();
    for (int rank = 1; rank <= std::ssize(state.grasps->report.grasps); ++rank) {
      json["grasps"].push_back(grasp_json(*state.grasps, rank));
    }
  }
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace thenar::window
