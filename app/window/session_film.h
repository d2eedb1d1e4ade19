// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "app/window/telemetry.h"
#include "engine/loops/film_tap.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/realtime.h"
#include "engine/recordings/recording_file.h"

namespace thenar::window {

/// The recording of a session, whose loops may become others.
class SessionFilm {
 public:
  SessionFilm(const std::filesystem::path& record, const thenar::Model& model,
              const thenar::RecordingSettings& settings, thenar::LiveContact& live)
      : file(record, model, settings) {
    follow(model, live);
  }

  /// Takes from these loops from now on. Called while neither runs.
  void follow(const thenar::Model& model, thenar::LiveContact& live) {
    lost_states_ += tap_ ? tap_->lost_pictures() : 0;
    lost_ticks_ += tap_ ? tap_->lost_contacts() : 0;
    tap_ = std::make_unique<thenar::FilmTap>(model, ticks_per_state(model, file.settings()), file.settings().contacts);
    live.tap = tap_.get();
  }

  /// Takes what the contact thread has left, but for pictures, which wait for the records of their ticks.
  void take() {
    file.take_contacts(*tap_);
    file.miss(lost_states_ + tap_->lost_pictures(), lost_ticks_ + tap_->lost_contacts());
  }

  /// Adds the state that tick `number` left, if it is due, with the figures of `telemetry` in its record.
  void see(std::int64_t number, const thenar::TickRecord& tick, const Eigen::VectorXd& muscle_forces_N,
           Telemetry& telemetry) {
    const thenar::Picture* const picture = tap_->picture_of(number);
    if (picture == nullptr) return;
    thenar::TickRecord whole = tick;
    telemetry.write_stages(whole);
    file.add(*picture, whole, muscle_forces_N, telemetry.figures(thenar::steady_now_ns()));
    tap_->pictures.pop();
  }

  thenar::RecordingFile file;

 private:
  std::unique_ptr<thenar::FilmTap> tap_;           ///< Tap of the present loops.
  std::int64_t lost_states_ = 0, lost_ticks_ = 0;  ///< Losses of the earlier loops.
};

}  // namespace thenar::window
