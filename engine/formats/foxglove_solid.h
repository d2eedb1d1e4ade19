#pragma once

#include "collision/solids/solid.h"
#include "engine/formats/foxglove.h"

namespace thenar::foxglove {

/// Of "triangles": the surface of a solid in its own frame. Of a plane, and of the plate around a hole, what is near
/// its middle.
[[nodiscard]] Json solid(const Solid& solid, const Color& color);

}  // namespace thenar::foxglove
