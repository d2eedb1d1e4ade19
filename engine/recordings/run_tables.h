// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/recordings/recorded_run.h"

/// Exports of a recording for other programs: docs/reference/recordings.md.
namespace thenar {

/// A table of a run's signals, in the words and units of signals.csv: a header, a row a state. `run` needs their fields
/// alone, is_signal().
[[nodiscard]] std::string run_csv(const RecordedRun& run);

/// An archive of arrays for NumPy: each field of the states under its name, states x count, or states where it is one
/// number; `contact_…` for the contacts of the states, a row each; `tick_contact_…` for those of all ticks; and the
/// names of fingers, joints and muscles. Throws FileError, in the name of `file`, if it is too large for one.
[[nodiscard]] std::string run_npz(const RecordedRun& run, const std::filesystem::path& file);

/// A storage of OpenSim: joint angles [rad] and muscle forces [N] by name. Rows whose time does not grow are left out.
/// Throws FileError, in the name of `file`, if it has no angles and no forces.
[[nodiscard]] std::string run_sto(const RecordedRun& run, const std::filesystem::path& file);

}  // namespace thenar
