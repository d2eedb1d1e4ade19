// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// A generator of uniform numbers in [0, 1), the same with all standard libraries, unlike
/// std::uniform_real_distribution.
class Uniform {
 public:
  explicit Uniform(std::uint32_t seed) : bits_(seed) {}
  double operator()() {
    const auto high = static_cast<double>(bits_() >> 5U);  // 27 bits
    const auto low = static_cast<double>(bits_() >> 6U);   // 26 bits: 53 together, a double's precision
    return (high * 0x1p26 + low) * 0x1p-53;
  }

 private:
  std::mt19937 bits_;
};

struct SurfaceSample {
  Eigen::Vector3d point_m;
  Eigen::Vector3d normal;  ///< Unit, outward.
};

/// A function that draws a sample of a surface's piece, uniformly by area; nothing where the solid covers it.
using DrawSample = std::function<std::optional<SurfaceSample>(Eigen::Index piece, Uniform& uniform)>;

/// Draws exactly `count` blue-noise samples of a surface that consists of pieces of these areas: more samples are drawn
/// uniformly by area, and the most crowded are eliminated [Yuksel 2015]. Same seed, same cloud.
/// Throws std::invalid_argument if count < 1, or if too few places are surface.
[[nodiscard]] PointCloud sample_blue_noise(const std::vector<double>& areas_m2, Eigen::Index count, std::uint32_t seed,
                                           const DrawSample& draw);

}  // namespace thenar
