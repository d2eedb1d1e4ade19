// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/record_flags.h"
#include "app/scene_flags.h"

namespace CLI {
class App;
}

namespace thenar::app {

inline constexpr const char* kLoopback = "127.0.0.1";

/// Settings of the live window from the command line. What only the program `thenar-window` can judge is as written.
struct WindowFlags {
  std::filesystem::path file;  ///< A scene, or a recording.
  std::vector<std::string> overrides;
  RateFlags rates;
  RecordFlags record;
  std::filesystem::path record_folder;  ///< Folder of recordings that pages begin; empty: the current one.
  std::uint16_t port = 8470;            ///< 0: any that is free.
  std::string address = kLoopback;      ///< As written.
  std::optional<std::string> token;     ///< As written; nothing: a random one.
  std::vector<std::string> host_names;  ///< As written.
  bool browser = true;
  bool realtime = true;  ///< Ask for real-time scheduling.
  int core = -1;         ///< The contact thread's; -1: the last.
  bool quiet = false;
};

/// Adds the command that shows a scene or a recording in a browser.
void add_window(CLI::App& app, WindowFlags& flags);

}  // namespace thenar::app
