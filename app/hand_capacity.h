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

/// Adds the command, below `thenar hand`.
void add_hand_capacity(CLI::App& hand, CapacityOptions& options);

/// Prints the largest forces that a scene's hand can give at its start. Returns the exit code.
[[nodiscard]] int run_hand_capacity(const CapacityOptions& options);

}  // namespace thenar::app
