// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/window/grasp_search.h"
#include "app/window/message.h"
#include "app/window/server.h"
#include "engine/grasp/model.h"
#include "engine/recordings/recording_file.h"

namespace thenar::window {

struct SessionSettings {
  double spin_s = 50e-6;
  bool realtime = true;                 ///< Ask for real-time scheduling.
  int core = -1;                        ///< The contact thread's; -1: the last.
  bool quiet = false;                   ///< Log nothing.
  std::filesystem::path record;         ///< A recording of the run; empty: none.
  std::filesystem::path record_folder;  ///< Folder of recordings that pages begin; empty: the current one.
  thenar::RecordingSettings recording;  ///< Content of recordings.
  /// Scene for searches. Nothing: the scene that runs, all its requirements on a grasp left open.
  std::optional<AskedScene> asked;
};

/// Outputs of a session, as those of WindowServer.
struct Display {
  std::function<void(std::string scene, std::string geometry)> set_scene;
  std::function<void(std::string status)> set_status;
  std::function<void(std::string grasps)> set_grasps;
  std::function<void(std::string state)> show;
  std::function<int()> pages;
};

/// A scene that runs in real time, without end, while pages watch it and lay hands on it.
///
/// Inputs (pull, poke, target) go from the server's thread to the contact thread through a buffer that cannot block.
/// All else (pause, step, reset, speed, changes of the scene) takes effect between two runs of the loops: they are
/// stopped, the scene is changed while nobody reads it, and they go on from the state and with the controller's memory
/// that they left. Grasps are searched meanwhile, on a thread that gives way to all others; one that is taken is a
/// change of the scene with which all begins again.
///
/// With `realtime`, and two cores or more, one core is the contact thread's alone as long as the session lives: the
/// thread that makes it, and what that starts from then on, keeps to the others.
class Session {
 public:
  Session(thenar::Model model, const SessionSettings& settings);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Handles a message on the server's thread, see Receive.
  [[nodiscard]] std::string receive(const Message& message);

  /// Runs and shows until `stop`. Throws FileError if the recording cannot be written.
  void run(const Display& display, const std::atomic<bool>& stop);
  void run(WindowServer& server, const std::atomic<bool>& stop) {
    run({[&](std::string scene, std::string geometry) { server.set_scene(std::move(scene), std::move(geometry)); },
         [&](std::string status) { server.set_status(std::move(status)); },
         [&](std::string grasps) { server.set_grasps(std::move(grasps)); },
         [&](std::string state) { server.show(std::move(state)); }, [&] { return server.pages(); }},
        stop);
  }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thenar::window
