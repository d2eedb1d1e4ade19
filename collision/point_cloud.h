#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace thenar {

/// A surface as an unstructured set of samples with outward normals, in the body's frame.
struct PointCloud {
  Eigen::Matrix3Xd points_m;  ///< 3 x N.
  Eigen::Matrix3Xd normals;   ///< 3 x N, unit, outward.
};

/// Exactly `count` blue-noise samples of a box's surface, centred on the origin. Same seed, same cloud.
[[nodiscard]] PointCloud sample_box(const Eigen::Vector3d& size_m, Eigen::Index count, std::uint32_t seed = 1);

/// Exactly `count` blue-noise samples of a sphere's surface, centred on the origin. Same seed, same cloud.
[[nodiscard]] PointCloud sample_sphere(double radius_m, Eigen::Index count, std::uint32_t seed = 1);

/// The side of the square that one sample stands for: the median over a subset, from eight neighbours each.
/// Throws std::invalid_argument for fewer than two samples. Cost O(points).
[[nodiscard]] double sample_spacing_m(const PointCloud& cloud);

}  // namespace thenar
