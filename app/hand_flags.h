// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace thenar::app {

/// Options of `thenar hand capacity`.
struct CapacityOptions {
  std::filesystem::path scene;  ///< Scene, or a hand, which is refused; empty: not requested.
  std::vector<std::string> overrides;
  std::optional<double> friction;  ///< Nothing: the scene's.
  std::filesystem::path json;      ///< Empty: none.
};

/// Options of `thenar hand`.
struct HandOptions {
  std::string hand;            ///< A hand file, or the name of a hand that comes with the program.
  std::filesystem::path file;  ///< MJCF or URDF, to be imported; empty: the hand is listed.
  std::vector<std::string> tips, locks;
  std::string base, axes;
  bool uncouple = false, mirror = false;
  std::filesystem::path out;  ///< The picture, or the hand file; empty: none.
  CapacityOptions capacity;
};

/// Adds the command `thenar hand`, and those below it.
void add_hand(CLI::App& app, HandOptions& options);

}  // namespace thenar::app
