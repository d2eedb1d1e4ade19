// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/imports/hand_import.h"
#include "engine/imports/hand_text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "tests/support/scratch.h"

namespace thenar {

inline std::filesystem::path hand_data(const std::string& name) {
  return std::filesystem::path(THENAR_TEST_DATA) / "hands" / name;
}

inline HandRequest fingers(const std::vector<std::string>& tips) {
  HandRequest request;
  for (const std::string& tip : tips) request.tips.push_back(read_tip(tip));
  return request;
}

/// The fingers of tests/data/hands/gripper.xml.
inline HandRequest gripper() { return fingers({"thumb=thumb_2:@24/1/-3mm", "fore=fore_cap", "little=little_tip:7mm"}); }

/// The hand that comes out of the file it is written to.
inline Hand written_and_read(const ImportedHand& made) {
  const std::filesystem::path file = scratch() / "hand.yaml";
  std::ofstream(file) << hand_text(made, "A hand of the tests.");
  return load_hand(file);
}

inline Hand imported(const std::filesystem::path& file, const HandRequest& request) {
  return written_and_read(import_hand(read_bodies(file), request));
}

/// Writes a file and imports it.
inline ImportedHand imported_text(const std::string& name, const std::string& text, const HandRequest& request) {
  const std::filesystem::path file = scratch() / name;
  std::ofstream(file) << text;
  return import_hand(read_bodies(file), request);
}

/// What is said of a file that no hand can be made of.
inline std::string refusal(const std::string& name, const std::string& text, const HandRequest& request) {
  try {
    (void)imported_text(name, text, request);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace thenar
