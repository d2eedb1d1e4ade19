#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace thenar::app {

/// What `thenar hand capacity` is asked for.
struct CapacityOptions {
  std::filesystem::path scene;  ///< Or a hand, which is refused. Empty: it is not asked for.
  std::vector<std::string> overrides;
  std::optional<double> friction;  ///< Nothing: the scene's.
  std::filesystem::path json;      ///< Empty: none.
};

/// Adds the command, below `thenar hand`.
void add_hand_capacity(CLI::App& hand, CapacityOptions& options);

/// Prints the largest forces that a scene's hand can give at its start. Returns the exit code.
[[nodiscard]] int run_hand_capacity(const CapacityOptions& options);

}  // namespace thenar::app
