// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A linear plant under a sampled controller whose commands are late. The plant advances by steps; a control period has
/// several. At the beginning of each period
///     c = C_c z + D_c x,  then  z <- A_c z + B_c x,
/// from the plant's state x and the controller's memory z, and in each step x <- A x + B u, with u = c of the newest
/// period whose command has arrived: each arrives `delay` steps after its sample, and holds until the next one does.
struct SampledLoop {
  Eigen::MatrixXd A, B;            ///< Of the plant, over a step.
  Eigen::MatrixXd Ac, Bc, Cc, Dc;  ///< Of the controller, over a period.
  int steps = 1;                   ///< Number of steps of a period.
  int delay = 0;                   ///< [steps].
};

/// The slowest to die out, or fastest to grow, of a loop's motions.
struct SlowestPole {
  double radius = 0.0;     ///< Size of its pole over one control period: the loop's spectral radius.
  Eigen::VectorXcd state;  ///< The plant's part of its eigenvector, of size 1; zero if the plant does not take part.
};

/// Finds the pole of largest size of the loop's state over a period, which is x, z and the commands that are under way;
/// of the motions that the first `seen` numbers of x take part in. Infinity for matrices that are not finite.
///
/// Method: Arnoldi's iteration [Arnoldi 1951; Saad 2011, Numerical Methods for Large Eigenvalue Problems, ch. 6] on the
/// map of as many periods as a command is under way, so that the chain of stored commands, whose length grows with the
/// delay, costs no dimensions: the other poles of that chain are small there. Until the residual of the Ritz value is
/// below 1e-10 of it, or the space is complete and the values exact.
/// Requires matrices of matching sizes; steps >= 1, delay >= 0. Takes memory.
[[nodiscard]] SlowestPole slowest_pole(const SampledLoop& loop, Eigen::Index seen);

}  // namespace thenar
