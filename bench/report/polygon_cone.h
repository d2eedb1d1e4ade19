// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "solvers/dual_active_set.h"
#include "solvers/reduced_grasp.h"

namespace thenar {

/// Coulomb's cone as a pyramid of any number of sides circumscribed about it; 4 is eq. (9) of the paper. For charts:
/// what more sides cost and gain.
struct Polygon {
  static constexpr int kLanes = 4;
  const Lane<kLanes>& mu;
  int sides;

  [[nodiscard]] Constraint<3> most_violated(const ActiveSet<3 * kLanes>::Vector& f, double) const {
    Constraint<3> worst;
    worst.slack = std::numeric_limits<double>::max();
    for (int i = 0; i < kLanes; ++i) {
      const double f_n = f[i], f_t1 = f[kLanes + i], f_t2 = f[2 * kLanes + i];
      // The side that faces the tangential force.
      const double turn = 2.0 * std::numbers::pi / sides;
      const double side = turn * std::round(std::atan2(f_t2, f_t1) / turn);
      const double c = std::cos(side), s = std::sin(side);
      const double slack = mu[i] * f_n - c * f_t1 - s * f_t2;
      if (slack < worst.slack) {
        worst = {i * sides + static_cast<int>(std::lround(side / turn)),
                 slack,
                 {i, kLanes + i, 2 * kLanes + i},
                 {mu[i], -c, -s}};
      }
    }
    return worst;
  }
};

/// Grasp forces of up to four contacts in pyramids of so many sides, world axes. False if there are none.
inline bool solve_polygon_cone(const GraspProblem& problem, int sides, Eigen::Ref<Eigen::VectorXd> f) {
  constexpr int kLanes = Polygon::kLanes;
  ReducedGrasp<kLanes> grasp;
  Vector6d twist;
  if (reduce(problem, grasp, twist) != Reduction::kDone) return false;
  ActiveSet<3 * kLanes> set;
  for (const LaneForces<kLanes>& row : grasp.Q) {
    if ((row != 0.0).any()) set.basis[set.equalities++] = row.reshaped();
  }
  std::array<double, 6> missing = reduced_wrench(grasp, grasp.bias);
  for (int k = 0; k < 6; ++k) missing[k] = grasp.w[k] - missing[k];
  ActiveSet<3 * kLanes>::Vector x = (grasp.bias + combine(grasp, missing)).reshaped();
  if (project(Polygon{grasp.cones.mu, sides}, set, x).status != ActiveSetStatus::kOptimal) return false;
  to_world<kLanes>(grasp, x.reshaped(kLanes, 3), f);
  return true;
}

}  // namespace thenar
