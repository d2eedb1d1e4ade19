// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "engine/hand/hand.h"

namespace thenar {

/// The unknowns of a stance: joints, then the object's translation and rotation vector.
inline constexpr int kMaxUnknowns = kMaxHandJoints + 6;
using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;
using UnknownsMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;

/// J'J, J'r and r'r of residuals r(x), accumulated one by one without storing residuals.
struct NormalEquations {
  explicit NormalEquations(Eigen::Index unknowns)
      : JJ(UnknownsMatrix::Zero(unknowns, unknowns)), Jr(Unknowns::Zero(unknowns)) {}

  void add(double residual, const Unknowns& derivative) {
    JJ.selfadjointView<Eigen::Lower>().rankUpdate(derivative);
    Jr += residual * derivative;
    cost += residual * residual;
  }
  /// Adds a residual that is zero unless `excess` is positive.
  void add_hinge(double excess, double scale, const Unknowns& derivative) {
    if (excess > 0.0) add(excess / scale, derivative / scale);
  }

  UnknownsMatrix JJ;  ///< Lower triangle.
  Unknowns Jr;
  double cost = 0.0;
};

/// Minimises the sum of squares by damped least squares [Levenberg 1944, Marquardt 1963] from x on. `equations(x)`
/// returns its normal equations, and `moved(x, step)` x after a step, within its bounds. Never returns a worse x.
template <typename X, typename Equations, typename Moved>
[[nodiscard]] X least_squares(X x, int most_steps, Equations equations, Moved moved) {
  constexpr double kLeastGain = 1e-4;  // Relative decrease of the cost below which a step counts as idle.
  NormalEquations now = equations(x);
  double damping = 1e-2;
  int idle = 0;
  for (int step = 0; step < most_steps && damping < 1e6 && idle < 2; ++step) {
    UnknownsMatrix A = now.JJ;
    A.diagonal() += damping * (A.diagonal().array() + 1e-3).matrix();
    const Unknowns dx = -A.selfadjointView<Eigen::Lower>().ldlt().solve(now.Jr);
    X next = moved(x, dx);
    NormalEquations then = equations(next);
    if (!(then.cost < now.cost)) {
      damping *= 8.0;
      continue;
    }
    idle = then.cost > (1.0 - kLeastGain) * now.cost ? idle + 1 : 0;
    x = next;
    now = then;
    damping = damping < 1e-7 ? damping : damping / 4.0;
  }
  return x;
}

}  // namespace thenar
