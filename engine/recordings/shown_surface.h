// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collision/triangle_mesh.h"
#include "engine/grasp/model.h"

namespace thenar {

/// The object as a closed surface, for eyes: the mesh of its file, if that is one and encloses a solid, and is not too
/// large to be sent; else one that is made of the surface which the fingers feel. Without triangles: it cannot be
/// closed. Takes up to a second, and memory: it is made once, before a run, and only for who looks at it.
[[nodiscard]] TriangleMesh shown_surface(const Model& model);

}  // namespace thenar
