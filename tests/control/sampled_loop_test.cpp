// SPDX-License-Identifier: Apache-2.0
#include "engine/control/sampled_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <deque>
#include <numbers>
#include <vector>

namespace thenar::sampled_loop_test {
namespace {

/// The gains of a PID.
struct Pid {
  double p = 0.0, i = 0.0, d = 0.0;
};

/// An object on a viscosity of 1, in steps of 1, under a PID on its place.
SampledLoop integrator(const Pid& gains, int steps, int delay) {
  SampledLoop loop;
  loop.steps = steps;
  loop.delay = delay;
  loop.A = loop.B = Eigen::MatrixXd::Ones(1, 1);
  // The memory is the integral, and the last place.
  loop.Ac = Eigen::MatrixXd::Zero(2, 2);
  loop.Ac(0, 0) = gains.i != 0.0 ? 1.0 : 0.0;
  loop.Bc = Eigen::MatrixXd::Ones(2, 1);
  loop.Bc(0, 0) = gains.i != 0.0 ? steps : 0.0;
  loop.Cc = Eigen::RowVector2d(-gains.i, gains.d / steps);
  loop.Dc = Eigen::MatrixXd::Constant(1, 1, -(gains.p + gains.i * steps + gains.d / steps));
  return loop;
}

/// Returns the largest size of the polynomial's roots, the highest power first [Durand 1960; Kerner 1966].
double largest_root(const std::vector<double>& powers) {
  const std::size_t degree = powers.size() - 1;
  std::vector<std::complex<double>> roots(degree);
  for (std::size_t k = 0; k < degree; ++k) {
    roots[k] = std::polar(0.97, 0.3 + 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(degree));
  }
  for (int sweep = 0; sweep < 2000; ++sweep) {
    for (std::size_t k = 0; k < degree; ++k) {
      std::complex<double> value = powers[0], others = powers[0];
      for (std::size_t i = 1; i <= degree; ++i) value = value * roots[k] + powers[i];
      for (std::size_t j = 0; j < degree; ++j) others *= j == k ? 1.0 : roots[k] - roots[j];
      roots[k] -= value / others;
    }
  }
  double largest = 0.0;
  for (const auto& root : roots) largest = std::max(largest, std::abs(root));
  return largest;
}

// Without a delay a period multiplies the place by 1 - k T: stable up to k T = 2.
TEST(SampledLoop, WithoutADelayAPeriodTakesItsShare) {
  for (const double kT : {0.1, 0.9, 1.5, 1.99, 2.01}) {
    for (const int steps : {1, 5}) {
      EXPECT_NEAR(slowest_pole(integrator({kT / steps}, steps, 0), 1).radius, std::abs(1.0 - kT), 1e-9) << kT;
    }
  }
}

// x' = -k x(t - T) is stable up to k T = pi/2, and sampled in steps of T / n up to k T = 2 n sin(pi / (4 n + 2)): there
// z^(n+1) - z^n + k T / n has a pair of roots on the unit circle. With the half step that a command is old in the mean
// it is pi/2 (sin x / x), x = pi / (4 n + 2), 0.17 / n^2 below at most.
TEST(SampledLoop, ADelayedIntegratorIsStableUpToHalfPi) {
  for (const int delay : {1, 7, 100, 400}) {
    const double most = 2.0 * std::sin(std::numbers::pi / (4.0 * delay + 2.0));
    EXPECT_LT(slowest_pole(integrator({0.999 * most}, 1, delay), 1).radius, 1.0) << delay;
    EXPECT_GT(slowest_pole(integrator({1.001 * most}, 1, delay), 1).radius, 1.0) << delay;
    EXPECT_NEAR(most * (delay + 0.5), std::numbers::pi / 2.0, 0.17 / (delay * delay));
  }
}

// With I and D gains: the roots of its polynomial, z^(n+1) (z - 1)^2 + p z (z - 1) + i z^2 + d (z - 1)^2, found by
// another method. Both find simple roots to rounding; a tenth of a millionth is far below any limit that is told.
TEST(SampledLoop, APidHasTheRootsOfItsPolynomial) {
  for (const Pid& gains : {Pid{0.1, 0.003, 0.0}, Pid{0.1, 0.0, 0.05}, Pid{0.05, 0.001, 0.02}, Pid{0.4, 0.01, 0.1}}) {
    for (const int delay : {0, 3, 20}) {
      std::vector<double> powers(delay + 4, 0.0);
      const double square[] = {1.0, -2.0, 1.0};
      for (int j = 0; j < 3; ++j) {
        powers[j] += square[j];
        powers[delay + 1 + j] += gains.d * square[j];
      }
      powers[delay + 1] += gains.p + gains.i;
      powers[delay + 2] -= gains.p;
      // Without an integral the loop has none: its root at 1 belongs to none of its motions.
      if (gains.i == 0.0) {
        for (std::size_t j = 1; j + 1 < powers.size(); ++j) powers[j] += powers[j - 1];
        powers.pop_back();
      }
      EXPECT_NEAR(slowest_pole(integrator(gains, 1, delay), 1).radius, largest_root(powers), 1e-7) << delay;
    }
  }
}

// Commands that come in the middle of a period: against the loop itself, step by step. Over n periods a decay or growth
// shows to about 1/n, whatever the phase of its swing.
TEST(SampledLoop, GrowsAndDiesOutAsItsSteps) {
  for (const Pid& gains : {Pid{0.02, 0.0, 0.0}, Pid{0.06, 0.0003, 0.0}, Pid{0.1, 0.001, 0.05}}) {
    for (const int delay : {0, 2, 5, 13, 28}) {
      constexpr int kSteps = 5, kPeriods = 4000;
      double x = 1.0, integral = 0.0, last = 0.0, logarithm = 0.0, at_half = 0.0;
      std::deque<double> commands(1 + delay / kSteps + 1, 0.0);  // The newest first.
      for (int period = 0; period < kPeriods; ++period) {
        integral += gains.i != 0.0 ? kSteps * x : 0.0;
        commands.push_front(-(gains.p * x + gains.i * integral + gains.d * (x - last) / kSteps));
        commands.pop_back();
        last = x;
        for (int step = 0; step < kSteps; ++step) {
          x += commands[delay / kSteps + (step < delay % kSteps ? 1 : 0)];
        }
        double size = std::abs(x) + std::abs(last) + gains.i * std::abs(integral);
        for (const double command : commands) size += std::abs(command);
        logarithm += std::log(size);
        if (period == kPeriods / 2) at_half = logarithm;
        for (double* all : {&x, &integral, &last}) *all /= size;
        for (double& command : commands) command /= size;
      }
      const double rate = (logarithm - at_half) / (kPeriods - 1 - kPeriods / 2);
      EXPECT_NEAR(std::log(slowest_pole(integrator(gains, kSteps, delay), 1).radius), rate, 3.0 / kPeriods) << delay;
    }
  }
}

// A loop that has forgotten all within a period has no pole but zero.
TEST(SampledLoop, MayForgetAll) { EXPECT_LT(slowest_pole(integrator({1.0}, 1, 0), 1).radius, 1e-6); }

}  // namespace
}  // namespace thenar::sampled_loop_test
