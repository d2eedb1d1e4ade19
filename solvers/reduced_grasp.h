// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

#include "solvers/grasp_problem.h"

namespace thenar {

/// Forces this many times the least without cones count as no solution. They occur where W^d lies 1e-8 of its size
/// inside the feasible wrenches, far less than the accuracy of its data; the rounding of a certificate is 1e-13.
inline constexpr double kOutOfReach = 1e8;

/// One number per contact, side by side, so that one instruction works on several. Lanes without a contact are 0.
template <int kLanes>
using Lane = Eigen::Array<double, kLanes, 1>;

/// Forces in contact axes: columns n, t1, t2, a row a contact.
template <int kLanes>
using LaneForces = Eigen::Array<double, kLanes, 3>;

/// The friction cones of contacts side by side, with the divisors of projections. Lanes without a contact have any
/// cone, as they bear no force.
template <int kLanes>
struct Cones {
  Lane<kLanes> mu;
  Lane<kLanes> one_cut;   ///< 1 / (1 + mu^2)
  Lane<kLanes> both_cut;  ///< 1 / (1 + 2 mu^2)

  Cones() = default;
  explicit Cones(const Lane<kLanes>& friction)
      : mu(friction), one_cut(1.0 / (1.0 + mu * mu)), both_cut(1.0 / (1.0 + 2.0 * mu * mu)) {}
};

/// A grasp problem in contact axes, the rows of its grasp map made orthonormal: with R R' = G G' the equations
/// G f = W^d are Q f = w, Q = R^-1 G and w = R^-1 W^d. The remaining problem is
///     min 1/2 |f - bias|^2,  Q f = w,  f_i in K_i.
/// Where the contacts cannot give some torque (two contacts, collinear ones), the last rows of Q are zero, and w too.
/// |w| is the size of the least forces that give the wrench without cones.
template <int kLanes>
struct ReducedGrasp {
  std::array<LaneForces<kLanes>, 6> Q;
  int rank = 6;  ///< Rows of Q that are not zero.
  std::array<double, 6> w;
  LaneForces<kLanes> bias;  ///< -c: each contact's lambda in column n.
  Cones<kLanes> cones;
  Eigen::Index contacts = 0;

  // The inverse map. About the centroid R^-1 = [1/sqrt(n) I, 0; C, B].
  std::array<LaneForces<kLanes>, 3> axes;  ///< World x, y, z of every contact's n, t1, t2.
  Eigen::Vector3d centroid_m;              ///< From the problem's centre.
  Eigen::Matrix3d B, C;
};

/// Outcome of a reduction.
enum class Reduction {
  kDone,
  kUnreachable,  ///< The wrench has a torque that no forces at the contacts give; `twist` is the axis.
  kNotFinite,    ///< The problem has an infinity or a NaN.
};

/// Reduces a problem of 1 to kLanes contacts (4 or 8). About the centroid of the contacts G G' = diag(n I, J), J their
/// inertia with unit masses. Cholesky's factor of J gives R; where contacts are nearly on a line, the axes of J and
/// Gram-Schmidt on the rows do, and a line's own axis is left out.
///
/// Requires  contact frames orthonormal to rounding.
/// twist     Out: for kUnreachable a motion that no contact resists and on which W^d does work; see infeasibility_gap.
/// Accuracy  Q Q' = I to 1e-12. Q itself is that of contact points moved by rounding: errors in forces are 1e-16 over
///           the distance of the contacts from a line as a share of those between them. Below 1e-10 they are on a line.
/// Cost      100 multiply-adds for four contacts; near a line some 3000. Does not allocate or throw. Problems that are
///           not finite return kNotFinite, or kDone with NaN in w, Q or the bias; frictions kNotFinite.
template <int kLanes>
[[nodiscard]] Reduction reduce(const GraspProblem& problem, ReducedGrasp<kLanes>& grasp, Vector6d& twist) noexcept;

/// Returns the motion l = R^-T `multiplier` about the problem's centre, world axes: G'l = Q' multiplier.
template <int kLanes>
[[nodiscard]] Vector6d twist_of(const ReducedGrasp<kLanes>& grasp, const std::array<double, 6>& multiplier) noexcept;

/// Returns Q' multiplier.
template <int kLanes>
[[nodiscard]] LaneForces<kLanes> combine(const ReducedGrasp<kLanes>& grasp, const std::array<double, 6>& multiplier) {
  LaneForces<kLanes> f = multiplier[0] * grasp.Q[0];
  for (int k = 1; k < 6; ++k) f += multiplier[k] * grasp.Q[k];
  return f;
}

/// Returns Q f.
template <int kLanes>
[[nodiscard]] std::array<double, 6> reduced_wrench(const ReducedGrasp<kLanes>& grasp, const LaneForces<kLanes>& f) {
  std::array<double, 6> w;
  for (int k = 0; k < 6; ++k) w[k] = (grasp.Q[k] * f).sum();
  return w;
}

/// Returns the nearest forces inside the pyramids |f_t1|, |f_t2| <= mu f_n.
///
/// With the normal force x the tangential ones are cut to mu x, and x is where x - n = mu sum (|t| - mu x)_+. As a
/// function of x the difference of both sides is the least of four rising lines (either |t| cut or not): its zero is
/// the greatest of theirs.
template <int kLanes>
[[nodiscard]] LaneForces<kLanes> nearest_in_pyramids(const Cones<kLanes>& cones, const LaneForces<kLanes>& f) {
  const Lane<kLanes>& mu = cones.mu;
  const Lane<kLanes> t1 = f.col(1).abs();
  const Lane<kLanes> t2 = f.col(2).abs();
  LaneForces<kLanes> nearest;
  nearest.col(0) = f.col(0)
                       .max((f.col(0) + mu * t1.max(t2)) * cones.one_cut)
                       .max((f.col(0) + mu * (t1 + t2)) * cones.both_cut)
                       .max(0.0);
  const Lane<kLanes> bound = mu * nearest.col(0);
  nearest.col(1) = f.col(1).max(-bound).min(bound);
  nearest.col(2) = f.col(2).max(-bound).min(bound);
  return nearest;
}

/// Returns the nearest forces inside the cones |f_t| <= mu f_n.
template <int kLanes>
[[nodiscard]] LaneForces<kLanes> nearest_in_cones(const Cones<kLanes>& cones, const LaneForces<kLanes>& f) {
  const Lane<kLanes>& mu = cones.mu;
  const Lane<kLanes> t = (f.col(1).square() + f.col(2).square()).sqrt();
  LaneForces<kLanes> nearest;
  nearest.col(0) = f.col(0).max((f.col(0) + mu * t) * cones.one_cut).max(0.0);
  // Without tangential force there is nothing to cut, and 0/0 to avoid.
  const Lane<kLanes> cut = (mu * nearest.col(0)).min(t) / t.max(std::numeric_limits<double>::min());
  nearest.col(1) = f.col(1) * cut;
  nearest.col(2) = f.col(2) * cut;
  return nearest;
}

/// Writes the forces in world axes, three per contact.
template <int kLanes>
void to_world(const ReducedGrasp<kLanes>& grasp, const LaneForces<kLanes>& f, Eigen::Ref<Eigen::VectorXd> f_W) {
  for (int k = 0; k < 3; ++k) {
    const Lane<kLanes> f_k = (grasp.axes[k] * f).rowwise().sum();
    for (Eigen::Index i = 0; i < grasp.contacts; ++i) f_W[3 * i + k] = f_k[i];
  }
}

}  // namespace thenar
