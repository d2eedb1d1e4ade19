// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "engine/grasp/state.h"

namespace thenar::python {

/// One number of a fingertip's touch, by its name in recordings.
struct TouchNumber {
  const char* name;
  double Touch::*field;
  const char* doc;
};
inline constexpr std::array kTouchNumbers{
    TouchNumber{
        "stick", &Touch::stick,
        "(fingers,) Share of each patch's loaded area that sticks, of scenes with fingertips.touch; else of none."},
    TouchNumber{"rim_friction", &Touch::friction,
                "(fingers,) Likewise: friction where the patch slips; NaN where nothing does."},
    TouchNumber{"slip_speed_m_per_s", &Touch::slip_m_per_s,
                "(fingers,) Likewise: mean speed of what of the patch slips [m/s]."},
    TouchNumber{"torsion_Nm", &Touch::moment_Nm, "(fingers,) Likewise: moment about the mean normal [N m]."},
    TouchNumber{"felt_normal_N", &Touch::normal_N,
                "(fingers,) Likewise: load along the mean normal, with the noise of what is felt [N]."},
};

}  // namespace thenar::python
