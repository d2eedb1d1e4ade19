// SPDX-License-Identifier: Apache-2.0
#include "app/studies/hand_capacity.h"

#include <iostream>

#include "app/exit_code.h"
#include "app/results.h"
#include "engine/capacity/capacity_report.h"
#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"

namespace thenar::app {

int run_hand_capacity(const CapacityOptions& options) {
  if (is_hand_file(options.scene)) {
    throw ConfigError(
        {{options.scene.string(), "", "is a hand, which has no posture: name a scene in which it holds something"}});
  }
  Scene scene = load_scene(options.scene, options.overrides);
  if (scene.hand.muscles.empty()) {
    throw ConfigError({{options.scene.string(), "", "its hand has no muscles, so that nothing limits its forces"}});
  }
  if (!options.json.empty()) check_results({{"--json", options.json}}, scene_files(options.scene, options.overrides));
  const Model model = build_model(std::move(scene));
  const HandGrip grip = grip_at_start(model);
  const HandCapacity capacity = hand_capacity(grip, options.friction.value_or(model.scene.contact.friction));
  if (!options.json.empty()) write_file(options.json, capacity_json(grip, capacity).dump(2) + "\n");
  std::cout << capacity_text(grip, capacity);
  return capacity.pinch.status == LimitStatus::kUnproved ? kFailed : kDone;
}

}  // namespace thenar::app
