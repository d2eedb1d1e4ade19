// SPDX-License-Identifier: Apache-2.0
#include "app/run/export.h"

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "app/exit_code.h"
#include "app/results.h"
#include "engine/figures/recording_page.h"
#include "engine/formats/files.h"
#include "engine/formats/mcap_reader.h"
#include "engine/formats/text.h"
#include "engine/recordings/recorded_run.h"
#include "engine/recordings/run_tables.h"
#include "engine/scenes/scene_file.h"

namespace thenar::app {

namespace fs = std::filesystem;

namespace {

/// Refuses what has no states, and says what is wrong with the others.
void look_at(const fs::path& recording) {
  double last_s = 0.0;
  const McapReading reading = look_through(recording, last_s);
  if (reading.damaged_chunks > 0) {
    std::cerr << "warning: " << printable(recording.string()) << " is damaged: parts of it are missing\n";
  } else if (!reading.whole) {
    std::cerr << "warning: " << printable(recording.string()) << " was cut off; it goes on to " << last_s << " s\n";
  }
}

}  // namespace

int export_recording(const Options& options) {
  std::vector<Result> results;
  if (!options.html.empty()) results.push_back({"--html", options.html});
  if (!options.csv.empty()) results.push_back({"--csv", options.csv});
  if (!options.npz.empty()) results.push_back({"--npz", options.npz});
  if (!options.sto.empty()) results.push_back({"--sto", options.sto});
  check_results(results, {options.recording});
  look_at(options.recording);
  Attempts attempts;
  if (!options.html.empty()) {
    attempts.attempt([&] { write_file(options.html, recording_page(options.recording)); });
  }
  if (!options.csv.empty()) {
    attempts.attempt([&] { write_file(options.csv, run_csv(read_recording(options.recording, {is_signal, false}))); });
  }
  if (!options.sto.empty()) {
    const auto of_joints = [](const Field& field) {
      return field.name == "time_s" || field.name == "q_rad" || field.name == "q_m" || field.name == "muscles_N" ||
             field.name == kUnstretched;
    };
    attempts.attempt([&] {
      write_file(options.sto, run_sto(read_recording(options.recording, {of_joints, false}), options.recording));
    });
  }
  if (!options.npz.empty()) {
    attempts.attempt([&] { write_file(options.npz, run_npz(read_recording(options.recording), options.npz)); });
  }
  attempts.finish();
  return kDone;
}

}  // namespace thenar::app
