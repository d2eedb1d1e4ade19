// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <random>
#include <type_traits>

namespace thenar {

/// Random numbers from a seed. The distributions are our own: those of the standard library differ from one library to
/// the next.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}

  /// Uniform in [low, high).
  double uniform(double low = 0.0, double high = 1.0) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1.0p-53;
  }
  /// 10^x, x uniform in [low, high).
  double power_of_ten(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  /// A whole number of first..last.
  template <std::integral First, std::integral Last>
  auto whole(First first, Last last) {
    using Whole = std::common_type_t<First, Last>;
    return static_cast<Whole>(first) + static_cast<Whole>(uniform() * static_cast<double>(last - first + 1));
  }
  /// About normal, of variance 1: Irwin-Hall.
  double normal() {
    double sum = -6.0;
    for (int k = 0; k < 12; ++k) sum += uniform();
    return sum;
  }
  Eigen::Vector3d normal3() {
    const double x = normal();
    const double y = normal();
    const double z = normal();
    return {x, y, z};
  }
  bool chance(double probability) { return uniform() < probability; }

  /// A unit vector, all directions alike: the first of those in the cube that is in the ball, and not at its centre.
  Eigen::Vector3d direction() {
    for (;;) {
      const double x = uniform(-1.0, 1.0);
      const double y = uniform(-1.0, 1.0);
      const double z = uniform(-1.0, 1.0);
      const double square = x * x + y * y + z * z;
      if (square <= 1.0 && square > 1e-4) return Eigen::Vector3d(x, y, z) / std::sqrt(square);
    }
  }
  /// A unit vector square to `axis`.
  Eigen::Vector3d square_to(const Eigen::Vector3d& axis) { return axis.cross(direction()).normalized(); }
  /// A right-handed frame whose first axis is along n, turned about it at random.
  Eigen::Matrix3d frame_about(const Eigen::Vector3d& n) {
    Eigen::Matrix3d frame;
    frame.col(0) = n.normalized();
    frame.col(1) = square_to(frame.col(0));
    frame.col(2) = frame.col(0).cross(frame.col(1));
    return frame;
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace thenar
