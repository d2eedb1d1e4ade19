#pragma once

#include "collision/point_cloud.h"

namespace thenar {

/// Gives a cloud without normals (`normals` empty, or to be replaced) unit outward normals.
///
/// A sample's normal is that of the plane through its neighbours, weighted anew by their distances from the plane, so
/// that a sharp edge does not tilt it. Signs spread along the spanning tree of least doubt [Hoppe et al. 1992], by the
/// rule that two neighbours lie on one arc [Koenig & Gumhold 2009], which also carries them round edges and the rims of
/// thin plates. Each part of the surface that no neighbour joins to another encloses a positive volume: a cavity's wall
/// comes out as a body's. Same cloud, same normals.
/// Throws std::invalid_argument for fewer than two samples, or samples all in one place.
void estimate_normals(PointCloud& cloud);

}  // namespace thenar
