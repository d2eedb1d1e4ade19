// SPDX-License-Identifier: Apache-2.0
#include "app/studies/insertion.h"

#include <iostream>
#include <optional>
#include <utility>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "engine/formats/files.h"
#include "engine/insertion/insertion_figure.h"
#include "engine/insertion/insertion_report.h"
#include "engine/studies/load_model.h"

namespace thenar::app {

int insertion(const Options& options) {
  Scene scene = scene_of(options);
  const PegScene peg = peg_scene(scene, options.scene.string());
  std::vector<Result> files;
  std::optional<FileLock> lock;
  if (!options.out.empty()) {
    for (const char* name : kInsertionFiles) files.push_back({"--out", options.out / name});
    check_results(files, scene_files(options.scene, options.overrides));
    lock.emplace(claim_folder(options.out, "--out"));
  }
  ReadyingLine line(options.quiet);
  const auto is_whole = [&](const Model&) { line.hide(); };
  const Model model = load_model(std::move(scene), {.begins = line.begins(), .is_whole = is_whole});
  require_part(model, Part::kEnvironment, options.scene);
  RunWatch watch(model.scene, options.quiet);
  const InsertionStudy study = study_insertion(model, peg, {.progress = watch.progress()});
  watch.end();
  if (options.format == "json") std::cout << insertion_json(model.scene, study).dump(2) << '\n';
  if (options.format != "json" && !options.quiet) std::cout << insertion_text(model.scene, study);
  const int code = report_verdict(model.scene, study.verdict);
  const bool was_stopped = stop_is_asked();  // Then the verdict says so.
  if (!options.out.empty() && !write_insertion(model.scene, study, options.out))
    std::cerr << "warning: no figure, for gnuplot is missing or failed\n";
  return code_at_end(code, was_stopped);
}

}  // namespace thenar::app
