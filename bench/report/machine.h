// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

#include "bench/report/measure.h"

// What one core of the machine can do, measured.

namespace thenar {

/// Least time of many calls: what the hardware can do.
template <typename Work>
double least_us(Work&& work) {
  double least = time_us(work);
  for (int i = 0; i < 100; ++i) least = std::min(least, time_us(work));
  return least;
}

/// Cycles a nanosecond: additions that wait for one another take a cycle each.
inline double measured_GHz() {
  constexpr int kAdditions = 1 << 20;
  const double us = least_us([] {
    std::uint64_t sum = 1;
    for (int i = 0; i < kAdditions; i += 8) {
      // Opaque to the compiler, which would fold additions of a constant.
      for (int k = 0; k < 8; ++k) {
        sum += sum;
        asm volatile("" : "+r"(sum));
      }
    }
  });
  return 1e-3 * kAdditions / us;
}

/// Floating-point operations a nanosecond of multiply-adds that wait for nothing, in the vectors that this build uses.
inline double measured_Gflops() {
  constexpr int kSteps = 1 << 15, kLanes = 32;
  using Lanes = Eigen::Array<double, kLanes, 1>;
  Lanes sums = Lanes::LinSpaced(0.1, 0.9);  // In no more registers than there are.
  const Lanes factor = Lanes::Constant(0.999), more = Lanes::Constant(1e-3);
  const double us = least_us([&] {
    Lanes s = sums;
    for (int i = 0; i < kSteps; ++i) s = s * factor + more;
    sums = s;
  });
  return sums.isFinite().all() ? 2e-3 * kSteps * kLanes / us : 0.0;
}

/// Gigabytes a second that are read from where a megabyte lies: as much as a contact tick goes through.
inline double measured_GB_per_s() {
  const Eigen::VectorXd data = Eigen::VectorXd::LinSpaced(1 << 17, 0.0, 1.0);
  double sum = 0.0;
  const double us = least_us([&] { sum += data.sum(); });
  return sum > 0.0 ? 1e-3 * static_cast<double>(data.size() * sizeof(double)) / us : 0.0;
}

}  // namespace thenar
