// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collision/point_cloud.h"

namespace thenar {

/// Changes that repair() made to a cloud.
struct CloudRepair {
  Eigen::Index turned = 0;    ///< Samples whose normals were reversed, outvoted by the samples in their tangent plane.
  Eigen::Index removed = 0;   ///< Samples whose normals contradict their neighbours', without a majority for turning.
  Eigen::Index outliers = 0;  ///< Samples removed off the surface of their neighbours, or apart from all surfaces.
  double doubtful_share = 0.0;    ///< Reversed and removed samples, as a fraction of all.
  double normal_noise = 0.0;      ///< Typical angle between a normal and its neighbours' estimate of it [rad].
  double position_noise_m = 0.0;  ///< Typical height of samples over the surface [m]. Both are 0 on smooth surfaces.
  bool smoothed_normals = false, smoothed_points = false;  ///< True if the noise was averaged.
};

/// Makes a cloud consistent before a surface is made of it:
///   - a normal that is outvoted by the samples in its tangent plane is reversed;
///   - a sample that contradicts its neighbours otherwise, or lies off their surface, or apart from all surfaces, is
///     removed;
///   - normals with a noise above 2 degrees and points with a noise above h/50 are averaged over their face, edges kept
///     [bilateral filter: Jones et al. 2004, Normal improvement for point rendering].
/// A clean cloud does not change in any bit, with edges, corners, thin plates and needles. Samples keep their order.
/// `support_m` > 0 is the support of the surface to be made, see covering_support_m(). For use outside of loops.
CloudRepair repair(PointCloud& cloud, double support_m);

/// Returns the support for a cloud's surface [m]: 2.2 spacings where the density is even; where a tenth of the samples
/// have spacings a quarter above the median, 2.2 of those. A wide support is less sharp, a narrow one has holes. Unlike
/// sample_spacing_m() it treats the two sides of a thin plate as two surfaces.
/// Throws std::invalid_argument for fewer than two samples, or samples all in one place.
[[nodiscard]] double covering_support_m(const PointCloud& cloud);

}  // namespace thenar
