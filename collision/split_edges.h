// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/mesh_edges.h"

namespace thenar {

/// Splits open edges, those of a single triangle, where the ends of others lie on them to `apart_m`: both sides of a
/// slit without width get the same edges, and it is closed. Such slits are left where one large face meets several
/// small ones. Returns the number of splits. `sides` are the mesh's, before and after. Cost O(n log n); vertices of
/// more than 32 open edges are left as they are.
Eigen::Index split_open_edges(TriangleMesh& mesh, std::vector<EdgeSide>& sides, double apart_m);

}  // namespace thenar
