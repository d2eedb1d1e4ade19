#pragma once

#include <optional>

#include "collision/implicit_surface.h"
#include "collision/triangle_mesh.h"

namespace thenar {

/// The surface as triangles that enclose it, for eyes: edges and corners are where its faces meet. By dual contouring
/// [Ju et al. 2002] on a grid as fine as the samples, coarser where there are many of them: a vertex for each cell that
/// the surface passes through, where it fits the planes at the cell's edges best, and a quadrangle around each edge
/// that the surface crosses. Each edge of a triangle has as many triangles on either side. Where walls are too thin for
/// the grid, a finer one is taken.
///
/// Nothing if samples are left without triangles near them, or if the surface is open.
/// Cost about 0.5 s for 30 000 samples; it allocates.
[[nodiscard]] std::optional<TriangleMesh> closed_surface(const ImplicitSurface& surface);

}  // namespace thenar
