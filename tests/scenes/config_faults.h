// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "engine/scenes/config.h"
#include "engine/scenes/key_table.h"

/// Tables of keys and files of a test's own, and what is wrong with those.
namespace thenar::config_faults {

using Lines = std::vector<std::string>;
using Reader = std::function<void(const ConfigMap&)>;
using Table = std::vector<Key>;
using enum KeyKind;
using enum Dimension;

/// A key of a test's own table, which must be there unless `without` says what holds otherwise.
inline Key key(std::string_view path, KeyKind kind, std::string_view range = "", Dimension dimension = kNone,
               int items = 1, std::string_view without = "") {
  return {std::string(path), kind, dimension, range, without, "", items};
}

inline Key length(std::string_view path, std::string_view range = "", std::string_view without = "") {
  return key(path, kQuantity, range, kLength, 1, without);
}

/// The scene's keys of one map.
inline Table scene_keys_of(std::string_view map) {
  Table table;
  for (const Key& k : scene_keys()) {
    if (k.path.starts_with(map)) table.push_back(k);
  }
  return table;
}

/// A scene file of this text, one for each test.
inline std::filesystem::path scene_file(const std::string& text) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const auto folder = std::filesystem::path(THENAR_TEST_OUTPUT) / "config" / test->name();
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "scene.yaml", std::ios::binary) << text;
  return folder / "scene.yaml";
}

/// What is wrong with a file, one "line:column: key: message" each, or "--set key: message".
inline Lines faults(const Table& table, const std::string& text, const Reader& read, const Lines& overrides = {}) {
  const std::filesystem::path file = scene_file(text);
  try {
    Config config(file, table, overrides);
    read(config.root());
    config.finish();
  } catch (const ConfigError& error) {
    Lines lines;
    std::istringstream all(error.what());
    const std::string prefix = file.string() + ":";
    for (std::string line; std::getline(all, line);) {
      lines.push_back(line.starts_with(prefix) ? line.substr(prefix.size()) : line);
    }
    EXPECT_EQ(lines.size(), error.diagnostics().size());
    return lines;
  }
  return {};
}

inline constexpr const char* kReferenceScene = R"(name: box grasp
time: {duration: 2.5 s, step: 1 ms, control_period: 1 ms}
gravity: [7.018620 m/s^2, 5.581331 m/s^2, 3.977916 m/s^2]     # world = hand frame
hand:
  model: hand.yaml
  posture: [0.08634660 rad, 0.25390447 rad, -90 deg, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad]
  joint_viscosity: 0.05 N*m*s
fingertips: {points: 2400, reduced_modulus: 0.24 MPa, poisson: 0.5, relaxation: 2 ms, kernel: boussinesq}
object:
  shape: {box: [50 mm, 50 mm, 50 mm]}
  points: 36000
  mass: 100 g
  position: [119.43952 mm, 46.26999 mm, 36.52549 mm]
  rotation: [[0, 0, 1], [1.0, 0, 0], [0, 1, 0]]
  damping: {translation: 10 N*s/m, rotation: 0.005 N*m*s}
contact: {friction: 0.8, band: 0.3 mm, max_per_finger: 20, tolerance: 1e-6, max_sweeps: 200}
control:
  law: feedforward                                            # or: paper
  gain: auto                                                  # K of [22]
  pulp: {normal: 2000 N/m, tangential: 1.33 N/mm}
  position: {p: 300 N/m, i: 900 N/(m*s), d: 0 N*s/m}
  rotation: {p: 0.48 N*m/rad, i: 1.5 N*m/(rad*s), d: 0 N*m*s/rad}
  muscles: true
task:
  translate: {by: [0 mm, 20 mm, 0 mm], from: 0.4 s, over: 0.8 s}
)";

}  // namespace thenar::config_faults
