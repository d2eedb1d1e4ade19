#include "app/hand_capacity.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "app/exit_code.h"
#include "app/results.h"
#include "app/scene_flags.h"
#include "engine/capacity/capacity_report.h"
#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"

namespace thenar::app {

void add_hand_capacity(CLI::App& hand, CapacityOptions& options) {
  CLI::App* const command = hand.add_subcommand(
      "capacity", "Finds the largest forces that a hand's muscles can give in the posture in which a scene starts");
  add_scene(*command, options.scene, options.overrides,
            "Scene (YAML), or the name of one that comes with the program; a hand alone has no posture", true);
  command->add_option("--friction", options.friction, "Friction of the pinch; default: the scene's")
      ->type_name("NUMBER")
      ->check(within(0.0, 10.0));
  command->add_option("--json", options.json, "File for all figures")
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());
}

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
