// SPDX-License-Identifier: Apache-2.0
#include "engine/pulps/elliptic_hertz.h"

#include <cmath>
#include <numbers>

namespace thenar {

namespace {

/// K(e) - E(e) and E(e) / aspect^2 - K(e): their ratio is that of the radii.
struct Integrals {
  double K, along, across;
};

Integrals integrals(double aspect) {
  const double e = std::sqrt(1.0 - aspect * aspect);
  const double K = std::comp_ellint_1(e), E = std::comp_ellint_2(e);
  return {K, K - E, E / (aspect * aspect) - K};
}

}  // namespace

EllipticHertz elliptic_hertz(double larger_radius_m, double lesser_radius_m) {
  constexpr double kRound = 1e-6, kThinnest = 1e-4;
  const double ratio = larger_radius_m / lesser_radius_m;
  if (ratio < 1.0 + kRound) return {};
  double low = std::log(kThinnest), high = 0.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    const Integrals at = integrals(std::exp(middle));
    (at.across > ratio * at.along ? low : high) = middle;
  }
  EllipticHertz result;
  result.aspect = std::exp(0.5 * (low + high));
  const Integrals at = integrals(result.aspect);
  const double e2 = 1.0 - result.aspect * result.aspect;
  result.size =
      std::cbrt(4.0 / (std::numbers::pi * e2) * std::pow(result.aspect, 1.5) * std::sqrt(at.across * at.along));
  result.depth = 2.0 / std::numbers::pi * std::sqrt(result.aspect) * at.K / result.size;
  return result;
}

}  // namespace thenar
