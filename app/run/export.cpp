// SPDX-License-Identifier: Apache-2.0
#include "app/run/export.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "engine/figures/recording_film.h"
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
  const ExportFlags& flags = options.exported;
  std::vector<Result> wanted;
  for (const auto& [flag, file] :
       {std::pair("--html", flags.html), std::pair("--csv", flags.csv), std::pair("--npz", flags.npz),
        std::pair("--sto", flags.sto), std::pair("--png", flags.png), std::pair("--film", flags.film)}) {
    if (!file.empty()) wanted.push_back({flag, file});
  }
  check_results(wanted, {flags.recording});
  look_at(flags.recording);
  Attempts results;
  const auto make = [&](const fs::path& file, const auto& bytes) {
    if (!file.empty()) results.attempt([&] { write_file(file, bytes()); });
  };
  make(flags.html, [&] { return recording_page(flags.recording); });
  make(flags.csv, [&] { return run_csv(read_recording(flags.recording, {is_signal, false})); });
  make(flags.sto, [&] {
    const auto of_joints = [](const Field& field) {
      return field.name == "time_s" || field.name == "q_rad" || field.name == "q_m" || field.name == "muscles_N" ||
             field.name == kUnstretched;
    };
    return run_sto(read_recording(flags.recording, {of_joints, false}), flags.recording);
  });
  make(flags.npz, [&] { return run_npz(read_recording(flags.recording), flags.npz); });
  make(flags.png, [&] { return recording_picture(flags.recording, flags.view(), flags.at_s()); });
  make(flags.film, [&] {
    ProgressLine line(false);
    const std::string film =
        recording_film(flags.recording, flags.film_settings(), ending_of(flags.film),
                       [&](double share) { line.show(fmt::format("{:.0f} % of the film is drawn", 100.0 * share)); });
    line.clear();
    return film;
  });
  results.finish();
  return kDone;
}

}  // namespace thenar::app
