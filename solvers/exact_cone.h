#pragma once

#include <array>
#include <limits>

#include "solvers/grasp_problem.h"
#include "solvers/reduced_grasp.h"

namespace thenar {

/// How a reduced problem with the exact cone ended.
struct ConeResult {
  GraspStatus status = GraspStatus::kBudgetSpent;
  int iterations = 0;  ///< Planes taken up or dropped, and Newton steps.
  /// How far the answer is from its proof [no unit]. Optimal: |w - Q f| / |f|. Infeasible: |w| over the least |f| that
  /// a solution would need. Budget spent: |w - Q f| / |f| of the best forces seen.
  double residual = std::numeric_limits<double>::infinity();
};

/// Finds the forces nearest `bias` that give the wrench inside Coulomb's cones,
///     min 1/2 |f - bias|^2,  Q f = w,  |f_t| <= mu f_n for each contact with its own mu,
/// by the concave problem in six unknowns that is its dual,
///     max over l   w'l - 1/2 |P_K(Q'l + bias)|^2,   gradient w - Q f,   f = P_K(Q'l + bias).
/// Method: semismooth Newton from the optimum without cones. Where it does not go straight, a dual active set on planes
/// that touch the cones, each made where a force leaves its cone [after Kelley 1960], until no force is far outside;
/// then Newton from the multiplier found there. Planes contain the cones: where they leave no forces, their multipliers
/// are all but a proof for the cones, too.
///
/// f          Out: the forces, if optimal; else left as they were.
/// multiplier Out: if optimal l, with f = P_K(Q'l + bias). If infeasible a direction with w'l > 0 and P_K(Q'l) nearly
///            0: forces that give the wrench would be at least w'l / |P_K(Q'l)| large, here kOutOfReach times |w|, the
///            least without cones. Else left as it was.
/// Accuracy   A residual of 1e-12, or rounding where multipliers are large. Where a wrench is at the border of what the
///            contacts can give there may be no multiplier at all, only better and better ones: 1e-9 is then accepted.
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
