// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// Finds the samples of parts that control points `control_spacing_m` apart may miss: needles, tips, rims of thin
/// plates. A face is wide at a sample if samples of similar normal (within 60 degrees) cover more than 0.42 of the disc
/// of a control spacing about it; samples are fine if no sample of their face within that distance is wide. The sides
/// of an edge or a corner are wide faces. The disc has a radius of 2.5 spacings of the cloud at least, its resolution;
/// denser clouds are subsampled at a stride: neighbours should be consecutive, as in a tree's order. Not for loops.
[[nodiscard]] std::vector<Eigen::Index> fine_parts(const PointCloud& cloud, double control_spacing_m);

}  // namespace thenar
