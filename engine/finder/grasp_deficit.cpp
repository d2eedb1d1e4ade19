// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/grasp_deficit.h"

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "solvers/dual_active_set.h"
#include "solvers/reduced_grasp.h"

namespace thenar {
namespace {

using Eigen::Index;

constexpr double kGreatestFriction = 10.0;
constexpr double kFrictionStep = 1e-3;

/// The motions l on which no force inside the cones does work, as constraints on l in R^6: -(Q e).l >= 0 for every edge
/// e of the pyramids, or every ray on the cones' surface.
template <int kLanes>
struct ResistedMotions {
  static constexpr int kSize = 8;  // 6, padded to whole registers.
  const ReducedGrasp<kLanes>& grasp;
  FrictionCone cone;

  [[nodiscard]] Constraint<6> most_violated(const ActiveSet<kSize>::Vector& l, double) const {
    const LaneForces<kLanes> along = combine(grasp, {l[0], l[1], l[2], l[3], l[4], l[5]});
    Constraint<6> worst;
    worst.slack = std::numeric_limits<double>::max();
    for (Index i = 0; i < grasp.contacts; ++i) {
      // The edge or ray that does the most work on l.
      const double t1 = along(i, 1);
      const double t2 = along(i, 2);
      double e1 = t1 < 0.0 ? -1.0 : 1.0;
      double e2 = t2 < 0.0 ? -1.0 : 1.0;
      if (const double t = std::hypot(t1, t2); cone == FrictionCone::kExact && t > 0.0) {
        e1 = t1 / t;
        e2 = t2 / t;
      }
      // Rows of length 1 at most.
      const double mu = grasp.cones.mu[i];
      const double n = 1.0 / std::sqrt(1.0 + mu * mu * (e1 * e1 + e2 * e2));
      const double t = n * mu;
      const double slack = -(n * along(i, 0) + t * (e1 * t1 + e2 * t2));
      if (slack >= worst.slack) continue;
      worst.id = static_cast<int>(i);
      worst.slack = slack;
      for (int k = 0; k < 6; ++k) {
        worst.index[k] = k;
        worst.value[k] = -(n * grasp.Q[k](i, 0) + t * (e1 * grasp.Q[k](i, 1) + e2 * grasp.Q[k](i, 2)));
      }
    }
    return worst;
  }
};

/// Computes the least |e| with Q (f + e) = w, f inside the cones: e = Q'l with l the part of w outside the cones'
/// wrenches, the nearest to w of the motions that they resist. In contact axes.
template <int kLanes>
LaneForces<kLanes> missing_forces(const GraspProblem& problem) {
  ReducedGrasp<kLanes> grasp;
  Vector6d twist;
  if (reduce(problem, grasp, twist) == Reduction::kNotFinite) return LaneForces<kLanes>::Zero();
  using Set = ActiveSet<ResistedMotions<kLanes>::kSize>;
  Set set;
  typename Set::Vector l = Set::Vector::Zero();
  for (int k = 0; k < 6; ++k) l[k] = grasp.w[k];
  // A round cone has a face for every direction, and never needs the last: the budget ends with what is left of e below
  // notice.
  std::ignore = project(ResistedMotions<kLanes>{grasp, problem.cone}, set, l);
  return combine(grasp, {l[0], l[1], l[2], l[3], l[4], l[5]});
}

double least_friction(GraspProblem problem) {
  Eigen::VectorXd f(3 * std::ssize(problem.contacts));
  std::vector<ContactGrip> grips(problem.grips.begin(), problem.grips.end());
  problem.grips = grips;
  // Infeasibility is proved or not claimed; what stays without an answer, at little friction, is hard because it is
  // feasible.
  const auto is_feasible = [&](double mu) {
    problem.friction = mu;
    for (ContactGrip& grip : grips) grip.friction = mu;
    return solve_grasp_forces(problem, f).status != GraspStatus::kInfeasible;
  };
  if (is_feasible(0.0)) return 0.0;
  if (!is_feasible(kGreatestFriction)) return std::numeric_limits<double>::infinity();
  double low = 0.0;
  double high = kGreatestFriction;
  while (high - low > kFrictionStep) {
    const double middle = 0.5 * (low + high);
    (is_feasible(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

GraspDeficit explain_infeasible_grasp(const GraspProblem& problem) {
  GraspDeficit deficit;
  const Index n = std::ssize(problem.contacts);
  if (n > 4) {
    deficit.missing_N.leftCols(n) = missing_forces<8>(problem).topRows(n).transpose().matrix();
  } else if (n > 0) {
    deficit.missing_N.leftCols(n) = missing_forces<4>(problem).topRows(n).transpose().matrix();
  }
  deficit.least_friction = least_friction(problem);
  return deficit;
}

}  // namespace thenar
