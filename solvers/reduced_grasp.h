#pragma once

#include <Eigen/Core>
#include <array>

namespace thenar {

/// One number a contact, contacts side by side, so that one instruction works on several. Lanes without a contact are 0.
template <int kLanes>
using Lane = Eigen::Array<double, kLanes, 1>;

/// Forces in contact axes: columns n, t1, t2, a row a contact.
template <int kLanes>
using LaneForces = Eigen::Array<double, kLanes, 3>;

/// A grasp problem in contact axes, the rows of its grasp map made orthonormal: with R R' = G G' the equations
/// G f = W^d are Q f = w, Q = R^-1 G and w = R^-1 W^d. What remains to find is
///     min 1/2 |f - bias|^2,  Q f = w,  f_i in K_i.
/// Where the contacts cannot give some torque (two contacts, collinear ones), the row of Q is zero, and w too.
template <int kLanes>
struct ReducedGrasp {
  std::array<LaneForces<kLanes>, 6> Q;
  std::array<double, 6> w;
  LaneForces<kLanes> bias;  ///< -c: lambda in column n of each contact.
  double friction = 0.0;
  Eigen::Index contacts = 0;
};

}  // namespace thenar
