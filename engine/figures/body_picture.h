// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "collision/solids/solid.h"
#include "engine/figures/surfels.h"

namespace thenar {

/// Adds the lines of a solid at X_WE that are within 80 mm of `near_m`, world axes: its edges, of round ones some
/// circles, of a plane a grid. They hide little, and are dark to an eye that is along `to_eye`.
void add_outline(const Solid& solid, const Eigen::Isometry3d& X_WE, const Eigen::Vector3d& near_m,
                 const Eigen::Vector3d& to_eye, std::vector<Surfel>& surfels);

}  // namespace thenar
