// SPDX-License-Identifier: Apache-2.0
#include "collision/surface_patches.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <numbers>

#include "collision/sphere_fit.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// The radius of a disc in supports: nearly a spacing, beyond which another sample is nearer.
constexpr double kDisc = 0.4;

// Polynomials are fitted at as many places as they are tried at.
constexpr int kTerms = 15, kFitted = 32, kPlaces = 64;
using Places = Eigen::Array<float, kPlaces, 1>;

// Allowed error at the test points, relative to that between them; and largest distance to a test point, in discs.
constexpr float kShare = 0.4F, kBetween = 0.1F;

// Allowance for lower values between these points, relative to the variation.
constexpr float kUnseen = 0.2F;

// A smaller disc is not worth its memory.
constexpr float kLeastDisc = 0.3F;

// Smaller weights occur at the rim of a support, where samples end.
constexpr float kLeastWeight = 1e-6F;

/// Points of a unit disc, equally dense (Vogel's spiral), and the matrix of polynomial fits to values at the first
/// ones.
struct Disc {
  Places u, v, radius;
  Eigen::Matrix<float, kPlaces, kTerms> terms;
  Eigen::Matrix<float, kTerms, kFitted> fit;
};

Disc make_disc() {
  Disc disc;
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  Eigen::Matrix<double, kPlaces, kTerms> terms;
  for (int i = 0; i < kPlaces; ++i) {
    // The others lie between the first ones, and on the rim.
    const bool fitted = i < kFitted;
    const double k = fitted ? i + 0.5 : i - kFitted + 1.0, angle = turn * k + (fitted ? 0.0 : 0.5);
    const double radius = std::sqrt(k / kFitted), u = radius * std::cos(angle), v = radius * std::sin(angle);
    disc.radius[i] = static_cast<float>(radius);
    disc.u[i] = static_cast<float>(u);
    disc.v[i] = static_cast<float>(v);
    for (int degree = 0, term = 0; degree <= 4; ++degree) {
      for (int power = 0; power <= degree; ++power) terms(i, term++) = std::pow(u, degree - power) * std::pow(v, power);
    }
  }
  disc.terms = terms.cast<float>();
  const Eigen::MatrixXd fitted = terms.topRows<kFitted>();
  disc.fit = fitted.completeOrthogonalDecomposition().pseudoInverse().cast<float>();
  return disc;
}

/// The samples with any weight on the disc, in its frame and in supports.
struct Neighbour {
  float u, v, z;
  float weight;  // by its normal
  float n_u, n_v, n_z;
};

/// The second projection at the points: n.(c - a) in supports, and n. NaN where samples end.
struct Exact {
  Places height, n_u, n_v, n_z;
};

Exact project_places(const std::vector<Neighbour>& neighbours, const Places& u, const Places& v) {
  constexpr int kTogether = 8;
  using Lanes = Eigen::Array<float, kTogether, 1>;
  Exact exact;
  for (int i = 0; i < kPlaces; i += kTogether) {
    const Lanes at_u = static_cast<float>(kDisc) * u.segment<kTogether>(i);
    const Lanes at_v = static_cast<float>(kDisc) * v.segment<kTogether>(i);
    Lanes sum = Lanes::Zero(), squares = sum, along = sum;
    Lanes a_u = sum, a_v = sum, a_z = sum, n_u = sum, n_v = sum, n_z = sum;
    for (const Neighbour& s : neighbours) {
      const Lanes to_u = s.u - at_u, to_v = s.v - at_v;
      const Lanes squared = to_u.square() + to_v.square() + s.z * s.z;
      const Lanes weight = s.weight * (1.0F - squared).max(0.0F).square().square();
      sum += weight;
      a_u += weight * to_u;
      a_v += weight * to_v;
      a_z += weight * s.z;
      n_u += weight * s.n_u;
      n_v += weight * s.n_v;
      n_z += weight * s.n_z;
      squares += weight * squared;
      along += weight * (to_u * s.n_u + to_v * s.n_v + s.z * s.n_z);
    }
    const PlaneOver<Lanes> plane = touching_plane<Lanes>(
        {a_u / sum, a_v / sum, a_z / sum, n_u / sum, n_v / sum, n_z / sum, squares / sum, along / sum});
    exact.height.segment<kTogether>(i) = (sum > kLeastWeight).select(-plane.height, std::nanf(""));
    exact.n_u.segment<kTogether>(i) = plane.n_x;
    exact.n_v.segment<kTogether>(i) = plane.n_y;
    exact.n_z.segment<kTogether>(i) = plane.n_z;
  }
  return exact;
}

}  // namespace

SurfacePatches::SurfacePatches(double support_m, double error_m, double depth_m, std::size_t samples)
    : support_m_(support_m), error_m_(error_m), depth_m_(depth_m), radius_m_(kDisc * support_m) {
  patches_.reserve(samples);
}

void SurfacePatches::add(const SampleBlocks& samples, const Vector3d& a_m, const Vector3d& n) {
  static const Disc disc = make_disc();
  const Vector3d t_1 = n.unitOrthogonal(), t_2 = n.cross(t_1);
  std::vector<Neighbour> neighbours;
  neighbours.reserve(64);
  const double reach_m = (1.0 + kDisc) * support_m_;
  samples.for_each_near(a_m, reach_m, [&](const SampleBlocks::Block& block, Index) {
    const SampleBlocks::Lanes cosine = block.cosines(n), squared = block.squared_distances(a_m);
    for (int k = 0; k < SampleBlocks::kLanes; ++k) {
      if (!(cosine[k] > 0.5) || !(squared[k] < reach_m * reach_m)) continue;
      const Vector3d to = (block.point_m(k) - a_m) / support_m_, normal = block.normal(k);
      const double weight = (2.0 * cosine[k] - 1.0) * (2.0 * cosine[k] - 1.0);
      const Eigen::Matrix<double, 7, 1> of_frame{to.dot(t_1),     to.dot(t_2),     to.dot(n), weight * weight,
                                                 normal.dot(t_1), normal.dot(t_2), cosine[k]};
      const auto f = of_frame.cast<float>().eval();
      neighbours.push_back({f[0], f[1], f[2], f[3], f[4], f[5], f[6]});
    }
  });
  const Exact exact = project_places(neighbours, disc.u, disc.v);

  Patch& patch = patches_.emplace_back();
  patch.t_1 = t_1;
  const auto coefficients = [&](const Places& values) { return (disc.fit * values.head<kFitted>().matrix()).eval(); };
  const auto height = coefficients(exact.height), n_u = coefficients(exact.n_u), n_v = coefficients(exact.n_v);
  const auto values = [&](const auto& fitted) { return (disc.terms * fitted).array().eval(); };
  const Places u = values(n_u), v = values(n_v);
  const Places cosine = (1.0F - u.square() - v.square()).max(0.0F).sqrt();
  const Places error_m = static_cast<float>(support_m_) * (values(height) - exact.height).abs() +
                         static_cast<float>(depth_m_) * (cosine - exact.n_z).abs();
  // NaN is not good.
  const float good = (error_m <= kShare * static_cast<float>(error_m_)).select(2.0F, disc.radius).minCoeff();
  if (!(good > kLeastDisc) || !exact.height.allFinite()) return;
  patch.good = good > 1.0F ? 1.0F : good - kBetween;
  const float lowest = exact.height.minCoeff(), most = exact.height.maxCoeff(), turned = exact.n_z.minCoeff();
  patch.least_height_m =
      static_cast<float>(support_m_) * (lowest - kUnseen * (most - lowest)) - static_cast<float>(error_m_);
  patch.least_cosine = turned - kUnseen * (1.0F - turned);
  for (int k = 0; k < kTerms; ++k) {
    const auto at = static_cast<std::size_t>(3 * k);
    patch.of[at] = static_cast<float>(support_m_) * height[k];
    patch.of[at + 1] = n_u[k];
    patch.of[at + 2] = n_v[k];
  }
}

}  // namespace thenar
