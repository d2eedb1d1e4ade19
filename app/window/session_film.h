// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "app/window/telemetry.h"
#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"
#include "engine/loops/film_tap.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/picture.h"
#include "engine/recordings/recording_file.h"
#include "engine/results/recording.h"

namespace thenar::window {

/// The recordings of a session, one after the other; its loops may become others. While none is made it does nothing.
/// All is for the calling thread, and what names `live` for when neither loop runs.
class SessionFilm {
 public:
  /// The model, which is referred to, may change while it lives. `folder`: of begin_in_folder().
  SessionFilm(const Model& model, RecordingSettings settings, std::filesystem::path folder)
      : model_(model), settings_(std::move(settings)), folder_(std::move(folder)) {}

  [[nodiscard]] bool is_on() const { return file_ != nullptr; }
  /// Returns true if the disk has failed: what follows is lost.
  [[nodiscard]] bool has_failed() const { return file_ && file_->has_failed(); }

  /// Begins a recording at `now_s`. `surface`: the object's shown_surface(). Throws FileError.
  void begin(const std::filesystem::path& file, const TriangleMesh& surface, double now_s, LiveContact& live);
  /// Likewise, in a new file of the folder that is named by the scene and the time of day. What keeps it from that is
  /// in news().
  void begin_in_folder(const TriangleMesh& surface, double now_s, LiveContact& live);
  /// Ends the recording. What is missing in it is in news().
  void end(LiveContact& live);
  /// Ends the recording at the end of the session. Throws FileError if it or an earlier one is not whole.
  void finish(LiveContact& live);
  /// Returns what became of the newest recording, as `recording` of a status message; null: there was none.
  [[nodiscard]] const nlohmann::ordered_json& news() const { return news_; }

  /// Takes from these loops from now on.
  void follow(LiveContact& live);
  /// Takes what the contact thread has left, but for pictures, which wait for the records of their ticks.
  void take();
  /// Adds the state that tick `number` left, if it is due, with the figures of `telemetry` in its record.
  void see(std::int64_t number, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N, Telemetry& telemetry);
  /// Adds a state between two runs.
  void add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N);
  /// Adds the scene again, which has become another one.
  void add_scene(double now_s);
  void add_status(double now_s, const nlohmann::ordered_json& status);

 private:
  const Model& model_;
  RecordingSettings settings_;
  std::filesystem::path folder_;
  std::unique_ptr<RecordingFile> file_;
  std::unique_ptr<FilmTap> tap_;                   ///< Tap of the present loops.
  std::int64_t lost_states_ = 0, lost_ticks_ = 0;  ///< Losses of the earlier loops.
  nlohmann::ordered_json news_;
  std::exception_ptr fault_;  ///< The first FileError of a recording that had begun.
};

}  // namespace thenar::window
