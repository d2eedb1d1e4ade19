// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "collision/sample_blocks.h"

namespace thenar {

/// The second projection of an ImplicitSurface, as polynomials.
///
/// The first projection takes x to c in a plane that belongs to the nearest sample. The second one depends on the
/// position of c in this plane alone:
///     f(x) = n(c).(x - a(c)) = n(c).(c - a(c)) + f_1 n(c).n_1.
/// So two coordinates suffice, at any depth: n.(c - a) and the two components of n along the plane are polynomials of
/// degree four on a disc around the plane's middle. Each sample has such a patch, with the radius in which it is
/// accurate, found by comparison with exact projections at points other than the fitted ones.
class SurfacePatches {
 public:
  /// Reserves patches; an f counts as good within `error_m` of the exact one where |f_1| is `depth_m` at most.
  SurfacePatches(double support_m, double error_m, double depth_m, std::size_t samples);

  /// Adds the next sample's patch; its first plane is (a, n). Costs about three distances.
  void add(const SampleBlocks& samples, const Eigen::Vector3d& a_m, const Eigen::Vector3d& n);

  /// Bounds of a projection, found without it.
  struct Estimate {
    double least_m = -std::numeric_limits<double>::infinity();  ///< Lower bound of f.
    double firm_m =
        0.0;  ///< Distance that x may move, still nearest to this sample, while `least_m` falls no faster than x moves.
  };
  [[nodiscard]] Estimate estimate(const Eigen::Vector3d& x_m, Eigen::Index sample, const Eigen::Vector3d& a_m,
                                  const Eigen::Vector3d& n) const noexcept {
    const Patch& patch = patches_[sample];
    const Eigen::Vector3d from_a = x_m - a_m;
    const double f_1 = n.dot(from_a), stray_m = std::sqrt(std::max(0.0, from_a.squaredNorm() - f_1 * f_1));
    const double firm_m = std::min(radius_m_ * patch.good - stray_m, depth_m_ - std::abs(f_1));
    if (!(firm_m > 0.0)) return {};
    return {patch.least_height_m + (f_1 > 0.0 ? patch.least_cosine : 1.0) * f_1, firm_m};
  }

  struct Projection {
    double f_m;
    Eigen::Vector3d n;  ///< Unit normal.
  };
  /// Computes the second projection of x by a sample's patch, whose first plane is (a, n); nothing outside of it.
  [[nodiscard]] std::optional<Projection> project(const Eigen::Vector3d& x_m, Eigen::Index sample,
                                                  const Eigen::Vector3d& a_m, const Eigen::Vector3d& n) const noexcept {
    const Patch& patch = patches_[sample];
    const Eigen::Vector3d from_a = x_m - a_m, t_2 = n.cross(patch.t_1);
    const double f_1 = n.dot(from_a);
    const auto u = static_cast<float>(patch.t_1.dot(from_a) / radius_m_);
    const auto v = static_cast<float>(t_2.dot(from_a) / radius_m_);
    if (!(u * u + v * v < patch.good * patch.good) || !(std::abs(f_1) <= depth_m_)) return std::nullopt;
    const Values values = patch.at(u, v);
    const double n_1 = values[1], n_2 = values[2];
    const double cosine = std::sqrt(std::max(0.0, 1.0 - n_1 * n_1 - n_2 * n_2));
    return Projection{values[0] + f_1 * cosine, n * cosine + patch.t_1 * n_1 + t_2 * n_2};
  }

  [[nodiscard]] double bytes() const { return static_cast<double>(patches_.capacity() * sizeof(Patch)); }

 private:
  static constexpr int kTerms = 15;
  using Values = Eigen::Array4f;  ///< n.(c - a) [m], the components of n along t_1 and t_2, and an unused entry.

  struct Patch {
    /// Three coefficients each of 1, u, v, u^2, u v, v^2, ... u^4 ... v^4, and one that is read with the last.
    std::array<float, 3 * kTerms + 1> of{};
    Eigen::Vector3d t_1 = Eigen::Vector3d::Zero();     // across n; t_2 = n x t_1
    float good = 0.0F;                                 // radius, in discs
    float least_height_m = 0.0F, least_cosine = 0.0F;  // where it is good

    [[nodiscard]] Values at(float u, float v) const {
      const auto c = [&](std::size_t k) { return Eigen::Map<const Values>(&of[3 * k]); };
      const Values u_3 = c(6) + u * c(10) + v * c(11);
      const Values u_2 = c(3) + v * (c(7) + v * c(12));
      const Values u_1 = c(1) + v * (c(4) + v * (c(8) + v * c(13)));
      const Values u_0 = c(0) + v * (c(2) + v * (c(5) + v * (c(9) + v * c(14))));
      return u_0 + u * (u_1 + u * (u_2 + u * u_3));
    }
  };

  double support_m_, error_m_, depth_m_;
  double radius_m_;  // of a disc
  std::vector<Patch> patches_;
};

}  // namespace thenar
