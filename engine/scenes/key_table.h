// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/scenes/keys.h"

namespace thenar {

/// All keys of a scene, as its description shows them (engine/scenes/describe.h).
[[nodiscard]] Keys scene_keys();
/// All keys of a hand file.
[[nodiscard]] Keys hand_keys();

}  // namespace thenar
