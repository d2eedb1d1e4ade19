#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "collision/sample_blocks.h"

namespace thenar {

/// The second projection of an ImplicitSurface, as polynomials.
///
/// The first projection takes x to c in a plane that belongs to the nearest sample. What the second one makes of c
/// depends on where in this plane c is, and on nothing else:
///     f(x) = n(c).(x - a(c)) = n(c).(c - a(c)) + f_1 n(c).n_1.
/// So two coordinates tell all, at any depth: n.(c - a) and the two components of n along the plane are polynomials of
/// degree four on a disc around the plane's middle. Each sample has such a patch, which knows how far from its middle
/// the answer is good, by trying it beside the exact one where it was not fitted.
class SurfacePatches {
 public:
  /// Good is an f within `error_m` of the exact one where |f_1| is `depth_m` at most.
  SurfacePatches(double support_m, double error_m, double depth_m, std::size_t samples);

  /// Adds the next sample's: its first plane is (a, n). About as dear as three distances.
  void add(const SampleBlocks& samples, const Eigen::Vector3d& a_m, const Eigen::Vector3d& n);

  /// What is known of a projection without it.
  struct Estimate {
    double least_m = -std::numeric_limits<double>::infinity();  ///< f is this or more.
    double firm_m = 0.0;  ///< While x moves no farther and belongs to this sample, `least_m` falls no faster than it moves.
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
    Eigen::Vector3d n;  ///< Of length one.
  };
  /// The second projection of x by a sample's patch, whose first plane is (a, n). Nothing where the patch is not good.
  [[nodiscard]] std::optional<Projection> project(const Eigen::Vector3d& x_m, Eigen::Index sample, const Eigen::Vector3d& a_m,
                                   const Eigen::Vector3d& n) const noexcept {
    const Patch& patch = patches_[sample];
    const Eigen::Vector3d from_a = x_m - a_m, t_1 = patch.t_1.cast<double>();
    const double f_1 = n.dot(from_a);
    const auto u = static_cast<float>(t_1.dot(from_a) / radius_m_);
    const auto v = static_cast<float>(n.cross(t_1).dot(from_a) / radius_m_);
    if (!(u * u + v * v < patch.good * patch.good) || !(std::abs(f_1) <= depth_m_)) return std::nullopt;
    const Terms terms = terms_of(u, v);
    const double height_m = (patch.height_m * terms).sum();
    const double n_1 = (patch.n_1 * terms).sum(), n_2 = (patch.n_2 * terms).sum();
    const double cosine = std::sqrt(1.0 - n_1 * n_1 - n_2 * n_2);
    return Projection{height_m + f_1 * cosine, n * cosine + t_1 * n_1 + n.cross(t_1) * n_2};
  }

  [[nodiscard]] double bytes() const { return static_cast<double>(patches_.capacity() * sizeof(Patch)); }

 private:
  static constexpr int kTerms = 16;  // 15, and a zero
  using Terms = Eigen::Array<float, kTerms, 1>;

  struct Patch {
    Terms height_m, n_1, n_2;  // coefficients
    Eigen::Vector3f t_1;       // across n; t_2 = n x t_1
    float good = 0.0F;          // radius, in discs
    float least_height_m = 0.0F, least_cosine = 0.0F;  // where it is good
  };

  [[nodiscard]] static Terms terms_of(float u, float v) {
    const float uu = u * u, uv = u * v, vv = v * v;
    return {{1.0F, u, v, uu, uv, vv, u * uu, u * uv, u * vv, v * vv, uu * uu, uu * uv, uu * vv, uv * vv, vv * vv, 0.0F}};
  }

  double support_m_, error_m_, depth_m_;
  double radius_m_;  // of a disc
  std::vector<Patch> patches_;
};

}  // namespace thenar
