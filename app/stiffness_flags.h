// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace thenar::app {

/// Options of `thenar stiffness`.
struct StiffnessOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::string at;                ///< As written; empty: the scene's end.
  std::string free = "muscles";  ///< "muscles" or "control".
  bool probe = true;
  std::filesystem::path json;  ///< Empty: none.
};

/// Adds the command `thenar stiffness`.
void add_stiffness(CLI::App& app, StiffnessOptions& options);

}  // namespace thenar::app
