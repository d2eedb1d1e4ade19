// SPDX-License-Identifier: Apache-2.0
#include "app/results.h"

#include <fmt/format.h>

#include <iostream>
#include <optional>
#include <system_error>
#include <utility>

#include "engine/scenes/config.h"

namespace thenar::app {

namespace fs = std::filesystem;

void check_results(const std::vector<Result>& results, const std::vector<fs::path>& inputs) {
  std::error_code none;  // What cannot be looked at is refused when it is read or written.
  for (auto result = results.begin(); result != results.end(); ++result) {
    for (const fs::path& input : inputs) {
      if (!fs::equivalent(result->file, input, none)) continue;
      throw ConfigError({{result->flag, "",
                          fmt::format("{} would replace {}, which this command reads: name another",
                                      result->file.string(), input.string())}});
    }
    const fs::path file = fs::weakly_canonical(result->file, none);
    for (auto other = results.begin(); other != result; ++other) {
      if (fs::weakly_canonical(other->file, none) != file) continue;
      throw ConfigError({{result->flag, "",
                          fmt::format("{} is a file of {}'s own: name another", result->file.string(), other->flag)}});
    }
  }
}

FileLock claim_folder(const fs::path& folder, const std::string& flag) {
  prepare_folder(folder);
  std::optional<FileLock> lock = FileLock::take(folder);
  if (!lock) {
    throw ConfigError({{flag, "", fmt::format("another run writes into {}: name another folder", folder.string())}});
  }
  return *std::move(lock);
}

NewFolders::NewFolders(fs::path folder) {
  std::error_code none;
  for (; !folder.empty() && !fs::exists(folder, none); folder = folder.parent_path()) missing_.push_back(folder);
}

NewFolders::~NewFolders() {
  std::error_code not_empty;
  for (const fs::path& folder : missing_) fs::remove(folder, not_empty);
}

void print_object_notes(const std::vector<std::string>& notes, bool quiet) {
  if (quiet) return;
  for (const std::string& note : notes) std::cerr << "object: " << note << '\n';
}

McapReading look_through(const fs::path& recording, double& last_s) {
  bool has_states = false;
  const McapReading reading = read_mcap(recording, [&](const McapMessage& message) {
    has_states = has_states || message.topic == "/state";
    last_s = message.time_s;
  });
  if (has_states) return reading;
  throw FileError(recording, reading.whole ? "holds no states: it is no recording of `thenar run --record`"
                             : reading.damaged_chunks > 0 ? "is damaged: no state of it can be read"
                                                          : "was cut off before its first state: record it again");
}

}  // namespace thenar::app
