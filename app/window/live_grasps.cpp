// SPDX-License-Identifier: Apache-2.0
#include "app/window/live_grasps.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "engine/loops/realtime.h"
#include "engine/models/surface_model.h"

namespace thenar::window {

namespace {

constexpr std::int64_t kProgress_ns = 100'000'000;

std::vector<std::string> fingers_of(const Hand& hand) {
  std::vector<std::string> names;
  for (const Fingertip& tip : hand.fingertips) names.push_back(tip.finger);
  return names;
}

AskedScene asked_scene(const std::optional<AskedScene>& asked, const Scene& running) {
  AskedScene scene = asked.value_or(AskedScene{running, "hand.yaml", "", running.hand.fingers()});
  if (!scene.scene.grasp) scene.scene.grasp = GraspWish{};
  return scene;
}

}  // namespace

LiveGrasps::LiveGrasps(const Model& model, const std::optional<AskedScene>& asked)
    : asked_(asked_scene(asked, model.scene)),
      own_(model.scene),
      search_(model.object),
      now_asked_(asked_),
      now_fingers_(fingers_of(own_.hand)) {}

std::string LiveGrasps::find(const Find& wish, const LiveSettings& begun, const LiveSettings& now) {
  if (own_.hand.slides) return "fingertips on slides are no hand to find a grasp for";
  AskedScene asked = now_asked_;
  Scene& scene = asked.scene;
  // Who has set the squeeze wants that one, whatever the scene asks for.
  if (now.value("internal_force_N") != begun.value("internal_force_N")) scene.grasp->press_N.reset();
  apply(begun, now, scene);
  // The controller must not plan with more friction than there is.
  if (scene.control) scene.control->grasp_friction = std::min(scene.control->grasp_friction, scene.contact.friction);
  return search_.begin(std::move(asked), wish.best);
}

std::string LiveGrasps::check(const Take& grasp, bool recorded) {
  std::vector<std::string> fingers = fingers_of(own_.hand);
  if (grasp.grasp > 0) {
    const SearchState state = search_.state();
    const bool there = state.grasps && state.search == grasp.search &&
                       grasp.grasp <= static_cast<int>(state.grasps->report.grasps.size());
    if (!there) return "there is no such grasp any more: take one of the newest search";
    fingers = fingers_of(grasp_scene(*state.grasps, grasp.grasp).hand);
  }
  if (!recorded || fingers == now_fingers_) return "";
  return "this grasp has other fingers than the recording that is being made";
}

std::optional<Model> LiveGrasps::take(const Take& grasp) {
  std::shared_ptr<const FoundGrasps> found;
  if (grasp.grasp > 0) {
    found = search_.state().grasps;
    if (!found || found->search != grasp.search) return std::nullopt;
  }
  std::optional<Model> model = surface_model(found ? grasp_scene(*found, grasp.grasp) : own_, search_.object());
  taken_ = grasp;
  found_ = std::move(found);
  return model;
}

void LiveGrasps::ask_as_taken() {
  now_asked_ = found_ ? found_->asked : asked_;
  now_fingers_ = fingers_of(found_ ? grasp_scene(*found_, taken_.grasp).hand : own_.hand);
}

void LiveGrasps::show(const std::function<void(std::string)>& set_grasps) {
  SearchState now = search_.state();
  const bool same = now.search == shown_.search && now.running == shown_.running && now.stopping == shown_.stopping &&
                    taken_ == shown_taken_;
  const bool farther = now.running && (now.share != shown_.share || now.found != shown_.found);
  const std::int64_t now_ns = steady_now_ns();
  const bool due = shown_ns_ == 0 || !same || (farther && now_ns - shown_ns_ > kProgress_ns);
  if (!due) return;
  set_grasps(grasps_message(now, taken_));
  shown_ = std::move(now);
  shown_taken_ = taken_;
  shown_ns_ = now_ns;
}

}  // namespace thenar::window
