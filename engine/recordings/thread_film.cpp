// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/thread_film.h"

namespace thenar {

ThreadFilm::ThreadFilm(const Model& model, RecordingFile& file, ThreadSettings& settings)
    : file_(file),
      hands_(model),
      live_(model, nobody_, hands_),
      tap_(model, ticks_per_state(model, file.settings()), file.settings().contacts) {
  live_.tap = &tap_;
  settings.live = &live_;
  settings.on_look = [this] {
    file_.take_contacts(tap_);
    return true;
  };
}

void ThreadFilm::finish() {
  file_.take_contacts(tap_);
  file_.miss(tap_.lost_pictures(), tap_.lost_contacts());
}

}  // namespace thenar
