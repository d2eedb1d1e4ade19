// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collision/point_cloud.h"

namespace thenar {

/// Estimates the unit outward normals of a cloud (`normals` is empty, or to be replaced).
///
/// A sample's normal is that of the plane through its neighbours, reweighted by their distances from the plane, so that
/// a sharp edge does not tilt it. The neighbours are those within 3 spacings of the cloud; where these are few, because
/// the cloud is uneven, within up to 8 times as many. Signs propagate along the spanning tree of least doubt [Hoppe et
/// al. 1992], by the rule that two neighbours lie on one arc [Koenig & Gumhold 2009], which also carries them round
/// edges and the rims of thin plates. Each connected part of the surface encloses a positive volume: a cavity's wall is
/// oriented as a body's. Same cloud, same normals.
/// Throws std::invalid_argument for fewer than two samples, or samples all in one place.
void estimate_normals(PointCloud& cloud);

/// Returns the share of a thousand samples, or of all, whose normals are more than 45 degrees off the plane of their
/// neighbours, whatever their signs: a few percent at edges, most if they are not the surface's. Samples along a line,
/// or to all sides, have no plane, and are never off. Throws as above.
[[nodiscard]] double share_off_planes(const PointCloud& cloud);

}  // namespace thenar
