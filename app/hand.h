#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/hand_capacity.h"

namespace CLI {
class App;
}  // namespace CLI

namespace thenar::app {

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

/// Adds the command and its options.
void add_hand(CLI::App& app, HandOptions& options);

/// Lists and draws a hand, makes one of an MJCF or URDF file, or finds what one can give. Returns the exit code.
[[nodiscard]] int run_hand(const HandOptions& options);

}  // namespace thenar::app
