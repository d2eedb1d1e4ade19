// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/window/admission.h"
#include "app/window/message.h"
#include "app/window_flags.h"

namespace thenar::window {

struct ServerSettings {
  std::string address = app::kLoopback;  ///< Numeric address.
  std::uint16_t port = 0;                ///< 0: any that is free.
  std::string token;                     ///< Token that pages must show, can_be_token(); empty: a random one.
  std::vector<HostName> also;            ///< Names by which pages reach it, beside its own.
  std::filesystem::path page;            ///< The built page, one file.
  std::filesystem::path recording;       ///< Served instead of a simulation; empty: live.
  double patience_s = 20.0;  ///< A header, a message to a page or its sign of life that takes longer has failed.
};

/// Serves the page and its messages, on one thread of its own. Keeps the newest state alone, and one message on its way
/// to each page, whatever the pages do: its memory is bounded.
class WindowServer {
 public:
  /// Listens. Throws PortError if it cannot, FileError if the page or the recording cannot be read.
  WindowServer(const ServerSettings& settings, Receive receive);
  ~WindowServer();
  WindowServer(const WindowServer&) = delete;
  WindowServer& operator=(const WindowServer&) = delete;

  /// Returns the URL for pages, with the token that they must show.
  [[nodiscard]] std::string url() const;

  // From any one thread:
  /// Sets the first messages to every page: scene_message and geometry_message.
  void set_scene(std::string scene, std::string geometry);
  /// Sets the newest status, which every page gets.
  void set_status(std::string status);
  /// Sets the results or the progress of a search for grasps, which every page gets, too.
  void set_grasps(std::string grasps);
  /// Shows the newest state to pages that ask.
  void show(std::string state);
  /// Returns the number of connected pages.
  [[nodiscard]] int pages() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The address cannot be listened on (exit code 4).
class PortError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace thenar::window
