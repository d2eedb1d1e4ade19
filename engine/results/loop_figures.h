// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>

namespace thenar {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
inline constexpr int kLatencyBins = 24;
inline constexpr double kFirstLatency_s = 50e-6;  ///< Start of the second bin; each is sqrt(2) wide.

/// Percentiles of a latency [us]; NaN where nothing was measured.
using ThreePercentiles = std::array<double, 3>;  // p50, p99, p99.9
inline constexpr ThreePercentiles kNoPercentiles = {kNotMeasured, kNotMeasured, kNotMeasured};

/// Performance of the two loops, by wall clock. NaN: not measured.
struct LoopFigures {
  double contact_Hz = kNotMeasured;
  ThreePercentiles contact_compute_us = kNoPercentiles, contact_jitter_us = kNoPercentiles;
  double contact_overruns = kNotMeasured, contact_slipped = kNotMeasured;
  double control_Hz = kNotMeasured;
  ThreePercentiles control_compute_us = kNoPercentiles, control_jitter_us = kNoPercentiles;
  double control_slipped = kNotMeasured;
  double realtime_factor = kNotMeasured;
  double unaccounted = kNotMeasured;
  double lost_records = kNotMeasured;
  double reference_error = kNotMeasured, reference_residual = kNotMeasured;
  ThreePercentiles latency_us = kNoPercentiles;
  std::array<double, kLatencyBins> latency_counts{};
};

}  // namespace thenar
