// SPDX-License-Identifier: Apache-2.0
#include "app/studies/stiffness.h"

#include <iostream>
#include <optional>

#include "app/exit_code.h"
#include "app/results.h"
#include "app/scene_flags.h"
#include "engine/formats/files.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/stiffness/stiffness_report.h"
#include "engine/studies/load_model.h"

namespace thenar::app {

namespace {

/// What has no stiffness to tell is refused.
void check_muscles(const Scene& scene, const std::string& name) {
  const auto refuse = [&](const std::string& why) { throw ConfigError({{name, "", why}}); };
  if (scene.hand.muscles.empty()) refuse("its hand has no muscles, whose stiffness this tells");
  if (!scene.has_muscles() || !scene.control->muscles->short_range) {
    refuse(
        "its muscles have no stiffness: name control.muscles.stiffness, such as "
        "--set 'control.muscles={stiffness: 23.4}'");
  }
  if (scene.object.compliance) refuse("its object is soft, and only stiffness of rigid ones in the hand is known");
}

}  // namespace

int run_stiffness(const StiffnessOptions& options) {
  Scene scene = load_scene(options.scene, options.overrides);
  check_muscles(scene, options.scene.string());
  if (!options.json.empty()) check_results({{"--json", options.json}}, scene_files(options.scene, options.overrides));
  const double at_s = options.at.empty() ? scene.duration_s : time_s(with_unit(options.at));
  const Model model = load_model(std::move(scene));
  require_part(model, Part::kMuscleStiffness, options.scene);
  const StiffnessStudy study =
      study_stiffness(model, at_s, options.free == "control" ? Acting::kControl : Acting::kMuscles,
                      options.probe ? std::optional(ProbeSettings{}) : std::nullopt);
  if (!options.json.empty()) write_file(options.json, stiffness_json(model.scene, study).dump(2) + "\n");
  std::cout << stiffness_text(model.scene, study);
  if (study.predicted.contacts == 0) return kLost;
  return study.measured && !study.measured->is_finite ? kFailed : kDone;
}

}  // namespace thenar::app
