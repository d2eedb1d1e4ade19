// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/model.h"
#include "engine/loops/film_tap.h"
#include "engine/loops/latest_value.h"
#include "engine/loops/live_contact.h"
#include "engine/loops/live_input.h"
#include "engine/loops/threads.h"
#include "engine/recordings/recording_file.h"

namespace thenar {

/// Films a run on two threads: takes what its contact thread shows to a recording's file, which watches the run.
class ThreadFilm {
 public:
  /// Sets `live` and `on_look` of the run's settings; the file is to be one of its watchers. The file and the film
  /// outlive the run. A state that nobody had time for is missing in the file.
  ThreadFilm(const Model& model, RecordingFile& file, ThreadSettings& settings);
  ThreadFilm(const ThreadFilm&) = delete;
  ThreadFilm& operator=(const ThreadFilm&) = delete;

  /// Takes what is left when the run has ended, and tells the file what it lacks.
  void finish();

 private:
  RecordingFile& file_;
  LatestValue<LiveInput> nobody_;
  LiveHands hands_;
  LiveContact live_;
  FilmTap tap_;
};

}  // namespace thenar
