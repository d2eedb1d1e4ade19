// SPDX-License-Identifier: Apache-2.0
// Two contacts with friction between a block and the floor, by the solver of the contact tick: which forces keep the
// block from sinking in, and how far does it slide? It links thenar::grasp, which needs Eigen alone.

#include <Eigen/Core>
#include <cstdio>

#include "solvers/gauss_seidel.h"

int main() {
  // A block of 2 kg on two points, pushed sideways. Rows of a contact: normal, tangent 1, tangent 2.
  constexpr double kMobility_m_per_N = 1e-4, kFriction = 0.5;
  thenar::ContactData problem{.W = kMobility_m_per_N * Eigen::MatrixXd::Identity(6, 6),
                              .delta_free = Eigen::VectorXd(6),
                              .mu = Eigen::VectorXd::Constant(2, kFriction)};
  problem.delta_free << -1e-3, 4e-4, 0.0, -1e-3, 8e-4, 0.0;

  Eigen::VectorXd f = Eigen::VectorXd::Zero(6), delta(6);
  const thenar::SolveReport report = thenar::solve_contacts(problem, {}, {f, delta});
  for (int i = 0; i < 2; ++i) {
    std::printf("contact %d: normal %.2f N, friction %.2f N, slides %.2f mm\n", i, f[3 * i],
                f.segment<2>(3 * i + 1).norm(), 1e3 * delta.segment<2>(3 * i + 1).norm());
  }
  return report.status == thenar::SolveStatus::kConverged ? 0 : 1;
}
