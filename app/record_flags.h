// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/recordings/recording_file.h"

namespace CLI {
class App;
}  // namespace CLI

namespace thenar::app {

/// The flags of a recording, of all commands that make one.
struct RecordFlags {
  std::filesystem::path file;  ///< Empty: none is made.
  std::string rate;            ///< As written; empty: not asked for.
  std::vector<std::string> fields;
  bool contacts = false;

  [[nodiscard]] bool asked() const { return !file.empty(); }
  [[nodiscard]] RecordingSettings settings() const;
};

/// Adds --record, which `what` describes, --record-rate, --record-fields and --record-contacts.
void add_record(CLI::App& command, RecordFlags& flags, const char* what);

/// Throws ConfigError if a scene has no such fields, or fewer contact ticks than states are to be kept of.
void check_record(const Model& model, const RecordFlags& flags);

/// Ends a recording, and says on stderr what it lacks. Throws FileError.
void finish_recording(RecordingFile& film, const Recording& run);

}  // namespace thenar::app
