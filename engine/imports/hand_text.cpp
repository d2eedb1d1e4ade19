// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/hand_text.h"

#include <fmt/format.h>

#include "engine/scenes/hand_file.h"

namespace thenar {

std::string hand_text(const ImportedHand& made, const std::string& origin) {
  std::string text =
      fmt::format("# {}\n# SI units: m, rad, kg, N. What is at_q0 is in the hand frame, all joints at 0.\n", origin);
  for (const std::string& note : made.notes) text += fmt::format("# - {}\n", note);
  for (std::size_t m = 0; m < made.muscle_notes.size(); ++m) {
    if (!made.muscle_notes[m].empty())
      text += fmt::format("# - {} {}\n", made.hand.muscles[m].name, made.muscle_notes[m]);
  }
  return text + hand_file_text(made.hand);
}

}  // namespace thenar
