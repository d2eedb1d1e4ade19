// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>

#include "solvers/grasp_problem.h"
#include "solvers/reduced_grasp.h"

namespace thenar {

/// Result of a reduced problem with the exact cone.
struct ConeResult {
  GraspStatus status = GraspStatus::kBudgetSpent;
  int iterations = 0;  ///< Number of planes added or dropped, and of Newton steps.
  /// Error of the answer [no unit]. Optimal: |w - Q f| / |f|. Infeasible: |w| over the least |f| that a solution would
  /// need. Budget spent: |w - Q f| / |f| of the best forces seen.
  double residual = std::numeric_limits<double>::infinity();
};

/// Finds the forces nearest to `bias` inside Coulomb's cones that give the wrench,
///     min 1/2 |f - bias|^2,  Q f = w,  |f_t| <= mu f_n for each contact with its own mu,
/// by the concave problem in six unknowns that is its dual,
///     max over l   w'l - 1/2 |P_K(Q'l + bias)|^2,   gradient w - Q f,   f = P_K(Q'l + bias).
/// Method: semismooth Newton from the optimum without cones. Where it does not converge directly, a dual active set on
/// planes tangent to the cones, each made where a force leaves its cone [after Kelley 1960], until no force is far
/// outside; then Newton from the multiplier found. The planes enclose the cones: where they are infeasible, their
/// multipliers nearly prove that the cones are, too.
///
/// f          Out: the forces if optimal; else unchanged.
/// multiplier Out: if optimal l, with f = P_K(Q'l + bias). If infeasible a direction with w'l > 0 and P_K(Q'l) nearly
///            0: forces that give the wrench would be at least w'l / |P_K(Q'l)| large, here kOutOfReach times |w|, the
///            least without cones. Else unchanged.
/// Accuracy   A residual of 1e-12, or rounding where multipliers are large. Where a wrench is at the border of the
///            feasible ones, the multiplier may not exist but only be approached: 1e-9 is then accepted.
/// Cost       For three contacts usually 3 to 7 Newton steps, and at most 30 of steps and planes in 99 of 100 problems;
///            bounded by 12 steps, three rounds of planes with 8 each, and 40 more at the border, where 100 are usual.
///            Linear in lanes.
///            Does not allocate or throw.
template <int kLanes>
[[nodiscard]] ConeResult solve_exact_cone(const ReducedGrasp<kLanes>& grasp, LaneForces<kLanes>& f,
                                          std::array<double, 6>& multiplier) noexcept;

extern template ConeResult solve_exact_cone<4>(const ReducedGrasp<4>&, LaneForces<4>&, std::array<double, 6>&) noexcept;
extern template ConeResult solve_exact_cone<8>(const ReducedGrasp<8>&, LaneForces<8>&, std::array<double, 6>&) noexcept;

}  // namespace thenar
