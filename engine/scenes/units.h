// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// Dimension of a number, which determines the units it may carry. The first unit named is the SI one, or %.
enum class Dimension {
  kNone,                    ///< No unit.
  kLength,                  ///< m, cm, mm, um
  kTime,                    ///< s, ms, us
  kMass,                    ///< kg, g
  kForce,                   ///< N, mN
  kTorque,                  ///< N*m, N*mm
  kAngle,                   ///< rad, deg
  kAcceleration,            ///< m/s^2
  kPressure,                ///< Pa, kPa, MPa
  kStiffness,               ///< N/m, N/mm
  kRotationalStiffness,     ///< N*m/rad
  kDamping,                 ///< N*s/m
  kRotationalDamping,       ///< N*m*s, N*m*s/rad; also joint viscosity
  kIntegralGain,            ///< N/(m*s)
  kRotationalIntegralGain,  ///< N*m/(rad*s)
  kFrequency,               ///< Hz, kHz
  kPerForce,                ///< 1/N
  kShare,                   ///< %, a hundredth
  kForceRate,               ///< N/s
  kRate,                    ///< 1/s
  kCompliance,              ///< m/N, um/N, nm/N
  kSpeed,                   ///< m/s, mm/s
};

/// A number read from text: its SI value, or what is wrong with the text.
struct Quantity {
  double value = 0.0;
  std::string fault;  ///< Empty if the value is good; else a sentence that starts with the text.
};

/// Reads a finite number and its unit, such as "50 mm" or "2 N/m". The unit must be one of the dimension's.
[[nodiscard]] Quantity read_quantity(std::string_view text, Dimension dimension);

/// The dimension in words, with its article: "a length".
[[nodiscard]] std::string_view name_of(Dimension dimension);

/// The dimension's units, the SI one first; none for a plain number.
[[nodiscard]] std::vector<std::string_view> unit_symbols(Dimension dimension);

/// The dimension's units in words: "m, cm, mm or um"; empty for a plain number.
[[nodiscard]] std::string unit_names(Dimension dimension);

/// The ends of the numbers of a dimension that a file may have, as text: "-1e5 N" and "1e5 N". Far beyond what any hand
/// needs, they are where sums and products of such numbers still have their digits.
[[nodiscard]] std::string_view least_of(Dimension dimension);
[[nodiscard]] std::string_view most_of(Dimension dimension);

/// An SI value with its unit, in the fewest digits that read back the same.
[[nodiscard]] std::string to_text(double value, Dimension dimension);
/// Several: "[1 m, 2 m]".
[[nodiscard]] std::string to_text(const Eigen::VectorXd& values, Dimension dimension);

}  // namespace thenar
