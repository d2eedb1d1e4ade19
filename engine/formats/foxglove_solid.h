// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collision/solids/solid.h"
#include "engine/formats/foxglove.h"

namespace thenar::foxglove {

/// Returns an item of "triangles": the surface of a solid in its own frame; of a plane, and of the plate around a hole,
/// the part near its middle.
[[nodiscard]] Json solid(const Solid& solid, const Color& color);

}  // namespace thenar::foxglove
