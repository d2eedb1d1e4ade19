// SPDX-License-Identifier: Apache-2.0
#include "app/stiffness_flags.h"

#include <CLI/CLI.hpp>

#include "app/scene_flags.h"

namespace thenar::app {

void add_stiffness(CLI::App& app, StiffnessOptions& options) {
  CLI::App* const command = app.add_subcommand(
      "stiffness", "Tells how stiff a hand holds an object: predicted, and measured by probes of the simulation");
  add_scene(*command, options.scene, options.overrides);
  command
      ->add_option("--at", options.at,
                   "When, in seconds, or with a unit, such as '500 ms'; default: the end of the scene")
      ->type_name("T")
      ->check(some_time());
  add_choice(*command, "--free", options.free, {"muscles", "control"},
             "What may act: muscles, whose excitations then stay, or the control law, which goes on")
      ->capture_default_str();
  command->add_flag_callback(
      "--no-probe", [&options] { options.probe = false; }, "Predicts alone");
  command->add_option("--json", options.json, "File for all figures")
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());
  command->footer(
      "Exit code: 0, also if the grasp turns away by itself; 2 for a wrong command or scene, 3 for a file, 6 if a "
      "contact solve failed, 7 if no finger holds the object.");
}

}  // namespace thenar::app
