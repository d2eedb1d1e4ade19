#pragma once

#include <Eigen/Core>

#include "collision/point_cloud.h"

namespace thenar {

/// What repair() did to a cloud.
struct CloudRepair {
  Eigen::Index turned = 0;      ///< Samples whose normals were outvoted by the samples in their tangent plane.
  Eigen::Index removed = 0;     ///< Samples whose normals contradict their neighbours', without a majority for turning.
  Eigen::Index outliers = 0;    ///< Samples removed off the surface of their neighbours, or apart from all surfaces.
  double doubtful_share = 0.0;  ///< Turned and removed, as a share of all samples.
  double normal_noise = 0.0;    ///< Typical angle between a normal and what its neighbours make of it [rad].
  double position_noise_m = 0.0;  ///< Typical height of samples over the surface [m]. Both are 0 on smooth surfaces.
  bool smoothed_normals = false, smoothed_points = false;  ///< Whether the noise was averaged.
};

/// Makes a cloud consistent before a surface is made of it:
///   - a sample whose normal is outvoted by the samples in its tangent plane is turned;
///   - a sample that contradicts its neighbours otherwise, or stands off the surface that they make, or apart from all
///     surfaces, is removed;
///   - normals with a noise above 2 degrees and points with a noise above h/50 are averaged over their face, edges kept
///     [bilateral filter: Jones et al. 2004, Normal improvement for point rendering].
/// A clean cloud stays as it is, to the last bit: edges, corners, thin plates and needles, too. Samples keep their
/// order. `support_m` > 0 is the support of the surface to be made, see covering_support_m(). For work done once.
CloudRepair repair(PointCloud& cloud, double support_m);

/// The support of the surface that a cloud can carry [m]: 2.2 spacings where the density is even. Where a tenth of the
/// samples have spacings a quarter wider than the middle one, theirs: a wide support is less sharp, a narrow one has
/// holes. Unlike sample_spacing_m() it takes the two sides of a thin plate for two surfaces.
/// Throws std::invalid_argument for fewer than two samples, or samples all in one place.
[[nodiscard]] double covering_support_m(const PointCloud& cloud);

}  // namespace thenar
