// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace thenar {

/// Weighted means of samples around a point c, in any unit of length: positions relative to c, normals, squared
/// distances from c, and positions along their own normals. Each is a row of lanes, one problem per lane.
template <typename Lanes>
struct SampleMeans {
  Lanes x, y, z;
  Lanes n_x, n_y, n_z;
  Lanes squared, along_normal;
};

/// The plane n.(p - c) = height.
template <typename Lanes>
struct PlaneOver {
  Lanes n_x, n_y, n_z;
  Lanes height;
};

/// Computes the plane that touches, over c, the sphere through samples with normals: exact on a sphere, and the mean of
/// flat samples. The curvature is that of Guennebaud & Gross [2007], from the change of normals between samples; values
/// above one over the unit of length count as noise, as do those of samples hardly apart.
template <typename Lanes>
PlaneOver<Lanes> touching_plane(const SampleMeans<Lanes>& s) {
  using Scalar = typename Lanes::Scalar;
  constexpr auto kHalf = static_cast<Scalar>(0.5), kMost = static_cast<Scalar>(1.0), kApart = static_cast<Scalar>(0.01);
  const Lanes length = (s.n_x.square() + s.n_y.square() + s.n_z.square()).sqrt();
  const Lanes n_x = s.n_x / length, n_y = s.n_y / length, n_z = s.n_z / length;
  const Lanes over = n_x * s.x + n_y * s.y + n_z * s.z;
  const Lanes spread = s.squared - (s.x.square() + s.y.square() + s.z.square());
  const Lanes turn = s.along_normal - length * over;
  const Lanes bend = (spread > kApart).select(turn / spread, Scalar{0}).max(-kMost).min(kMost);

  // The mean of the samples lies below the sphere. There the sphere's normal is n; at c it is tilted.
  const Lanes side_x = s.x - over * n_x, side_y = s.y - over * n_y, side_z = s.z - over * n_z;
  const Lanes side_squared = side_x.square() + side_y.square() + side_z.square();
  const Lanes foot = over + kHalf * bend * (spread - side_squared);  // along n
  const Lanes shrink = (Scalar{1} + bend.square() * side_squared).rsqrt();
  return {(n_x - bend * side_x) * shrink, (n_y - bend * side_y) * shrink, (n_z - bend * side_z) * shrink,
          foot * shrink};
}

}  // namespace thenar
