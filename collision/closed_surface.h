// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collision/implicit_surface.h"
#include "collision/triangle_mesh.h"

namespace thenar {

/// Makes triangles that enclose the surface, for display: edges and corners are where its faces meet. By dual
/// contouring [Ju et al. 2002] on a grid as fine as the samples, coarser if they are many: a vertex for each cell that
/// the surface intersects, where it best fits the planes at the cell's edges, and a quadrangle around each edge that
/// the surface crosses. Each edge of a triangle has equally many triangles on either side. Where walls are too thin for
/// the grid, a finer one is used.
///
/// Returns nothing if samples have no triangles near them, or if the surface is open. Cost about 0.5 s for 30 000
/// samples; it allocates.
[[nodiscard]] std::optional<TriangleMesh> closed_surface(const ImplicitSurface& surface);

}  // namespace thenar
