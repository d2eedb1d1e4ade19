#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// The samples of parts that control points `control_spacing_m` apart may pass by: needles, tips, rims of thin plates.
/// A face is wide at a sample if samples of like normal (within 60 degrees) cover more than 0.42 of the disc of a
/// control spacing about it; fine are the samples with no wide place of their face within that distance. The sides of
/// an edge or a corner are wide faces. None is finer than 2.5 spacings of the cloud, which shows no more; of denser
/// clouds a part is looked at, every so manieth sample: neighbours are to follow each other, as in a tree's order. For
/// work done once.
[[nodiscard]] std::vector<Eigen::Index> fine_parts(const PointCloud& cloud, double control_spacing_m);

}  // namespace thenar
