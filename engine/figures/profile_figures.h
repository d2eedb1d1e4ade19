// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "engine/results/profile.h"

namespace thenar {

/// Files that draw_profile() may leave in a folder.
inline constexpr std::array<const char*, 3> kProfileFigures{"jitter.svg", "handover.svg", "timeline.svg"};

/// Start jitters measured beside a profile, for comparison [us]; empty: not measured.
struct JitterFloor {
  std::vector<double> cyclictest_us;  ///< Jitters of a loop that does nothing.
  std::vector<double> contact_us;     ///< Jitters of the contact loop without a spin.
};

/// Draws, from the ticks of a profile:
///   jitter.svg    share of ticks that start later, or compute longer, than x: complementary distribution, log-log
///   handover.svg  the loaded fingers' forces over 0.1 s in the middle of the motion, hand-overs marked
///   timeline.svg  a little more than one control period: both loops' ticks, what they publish and take
/// False if there is no gnuplot or it failed, or no tick to draw. Throws FileError if a figure cannot be
/// written.
[[nodiscard]] bool draw_profile(const Model& model, const LoopProfile& profile, const JitterFloor& floor,
                                double spin_us, const std::filesystem::path& folder);

}  // namespace thenar
