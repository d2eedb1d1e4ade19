// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "thenar/eigen_layout.h"

// Without AVX such vectors are passed in another way than with it, which GCC warns of. Only inline functions take or
// return them by value.
#pragma GCC diagnostic ignored "-Wpsabi"

/// The arithmetic of four contacts at once: the same step for each, one in each lane. The lanes are the compiler's own
/// vectors: arrays of Eigen's are copied by halves and then read whole, for which a processor waits.
namespace thenar::lanes {

inline constexpr int kLanes = 4;
/// A number of each contact.
using Numbers [[gnu::vector_size(kLanes * sizeof(double))]] = double;

/// A vector of one contact (double), or of each (Numbers): x, y, z.
template <typename Number>
using VectorOf = std::array<Number, 3>;
using Vector = VectorOf<Numbers>;
/// The three columns of a matrix of each contact.
using Axes = std::array<Vector, 3>;

inline double root(double x) { return std::sqrt(x); }
/// Returns the square roots. Eigen has an instruction for all four, the compiler's vectors have none.
inline Numbers root(Numbers x) {
  Eigen::Array<double, kLanes, 1> roots;
  std::memcpy(roots.data(), &x, sizeof x);
  roots = roots.sqrt().eval();
  std::memcpy(&x, roots.data(), sizeof x);
  return x;
}

/// Returns the larger of the two numbers, and x where that is none.
inline double at_least(double least, double x) { return x < least ? least : x; }
inline Numbers at_least(double least, const Numbers& x) { return x < least ? Numbers{least, least, least, least} : x; }

template <typename Number>
Number dot(const VectorOf<Number>& a, const VectorOf<Number>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Returns a x b, where a may be one vector for all lanes.
template <typename Left>
Vector cross(const Left& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Returns a - b, with one b for all lanes.
inline Vector minus(const Vector& a, const Eigen::Vector3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Returns A v, with one A for all lanes.
inline Vector product(const Eigen::Matrix3d& A, const Vector& v) {
  Vector Av;
  for (int r = 0; r < 3; ++r) Av[r] = A(r, 0) * v[0] + A(r, 1) * v[1] + A(r, 2) * v[2];
  return Av;
}

/// Returns orthonormal right-handed axes: the unit vector n, and along t1 as far as it is across n. The other two are
/// zero where it is along n.
inline Axes axes_of(const Vector& n, const Vector& t1) {
  const Numbers along = dot(t1, n);
  Vector t = {t1[0] - along * n[0], t1[1] - along * n[1], t1[2] - along * n[2]};
  const Numbers per_length = 1.0 / root(at_least(std::numeric_limits<double>::min(), dot(t, t)));
  for (Numbers& part : t) part *= per_length;
  return {n, t, cross(n, t)};
}

/// Returns a vector for each lane: the Eigen vector that vector_of(lane) returns.
template <typename VectorOfLane>
Vector gather(const VectorOfLane& vector_of) {
  const auto &a = vector_of(0), &b = vector_of(1), &c = vector_of(2), &d = vector_of(3);
  return {Numbers{a[0], b[0], c[0], d[0]}, Numbers{a[1], b[1], c[1], d[1]}, Numbers{a[2], b[2], c[2], d[2]}};
}

/// Returns a number for each lane: number_of(lane).
template <typename NumberOfLane>
Numbers gather_numbers(const NumberOfLane& number_of) {
  return Numbers{number_of(0), number_of(1), number_of(2), number_of(3)};
}

/// Sets the vector of one lane.
inline void set(Vector& v, int lane, const Eigen::Vector3d& to) {
  for (int r = 0; r < 3; ++r) v[r][lane] = to[r];
}

/// Returns the vector of one lane.
inline Eigen::Vector3d get(const Vector& v, int lane) { return {v[0][lane], v[1][lane], v[2][lane]}; }

/// Writes the numbers of each of the first `count` lanes one after the other: lane i from to[i * stride] on.
template <std::size_t kNumbers>
void write(const std::array<Numbers, kNumbers>& numbers, int count, double* to, Eigen::Index stride) {
  std::size_t k = 0;
  for (; k + kLanes <= kNumbers; k += kLanes) {
    const Numbers &a = numbers[k], &b = numbers[k + 1], &c = numbers[k + 2], &d = numbers[k + 3];
    const Numbers ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6),
                  ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7),
                  cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6),
                  cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    const std::array<Numbers, kLanes> of_lanes = {
        __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5), __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5),
        __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7), __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7)};
    for (int lane = 0; lane < kLanes; ++lane) {
      if (lane < count) std::memcpy(to + lane * stride + k, &of_lanes[lane], sizeof(Numbers));
    }
  }
  for (; k < kNumbers; ++k) {
    for (int lane = 0; lane < count; ++lane) to[lane * stride + static_cast<Eigen::Index>(k)] = numbers[k][lane];
  }
}

/// Writes the matrices of the first `count` lanes one after the other, column by column.
inline void write(const Axes& E, int count, double* to) {
  write(std::array{E[0][0], E[0][1], E[0][2], E[1][0], E[1][1], E[1][2], E[2][0], E[2][1], E[2][2]}, count, to, 9);
}

}  // namespace thenar::lanes
