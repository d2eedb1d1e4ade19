// SPDX-License-Identifier: Apache-2.0
#include "solvers/reduced_grasp.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Cholesky's rows of Q are orthogonal to rounding times the condition of J, which this share of det J / (tr J)^3 keeps
// below 1e4: contacts farther from a line than 1 % of their distances.
constexpr double kWellSpread = 1e-4;
// Contacts that stray from a line by less than this part of their distances are on it: rounding of their coordinates,
// 1e-16, would be 1e-6 of what they stray, and of the forces that balance a torque about the line.
constexpr double kCollinear = 1e-10;
// A torque about that line below this part of the torques at hand is rounding.
constexpr double kConsistent = 1e-9;

/// Points of the contacts, relative to one of them.
template <int kLanes>
using Points = std::array<Lane<kLanes>, 3>;

/// Fills the data that do not depend on the rows of Q; returns the arms of the contacts about the centroid.
template <int kLanes>
Points<kLanes> gather(const GraspProblem& problem, ReducedGrasp<kLanes>& grasp) {
  const Index n = std::ssize(problem.contacts);
  const double over_n = 1.0 / static_cast<double>(n);
  // Lanes without a contact repeat the last one, times 0.
  std::array<const GraspContact*, kLanes> contacts;
  Lane<kLanes> present, friction, internal_force_N;
  for (Index i = 0; i < kLanes; ++i) {
    const Index contact = std::min(i, n - 1);
    contacts[i] = &problem.contacts[contact];
    friction[i] = problem.friction_of(contact);
    internal_force_N[i] = problem.internal_force_of(contact);
    present[i] = i < n ? 1.0 : 0.0;
  }
  Points<kLanes> arms;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      Lane<kLanes> axis;
      for (int i = 0; i < kLanes; ++i) axis[i] = contacts[i]->axes(k, j);
      grasp.axes[k].col(j) = present * axis;
    }
    Lane<kLanes> points;
    for (int i = 0; i < kLanes; ++i) points[i] = contacts[i]->point_m[k];
    points -= problem.centre_m[k];
    grasp.centroid_m[k] = (present * points).sum() * over_n;
    arms[k] = present * (points - grasp.centroid_m[k]);
  }
  grasp.bias.col(0) = internal_force_N * present;
  grasp.bias.col(1).setZero();
  grasp.bias.col(2).setZero();
  grasp.cones = Cones<kLanes>(friction);
  grasp.contacts = n;
  return arms;
}

/// Returns b.(r x f) as a row on f in contact axes: (b x r).f.
template <int kLanes>
LaneForces<kLanes> torque_row(const ReducedGrasp<kLanes>& grasp, const Points<kLanes>& arms, const Vector3d& b) {
  const Lane<kLanes> x = b.y() * arms[2] - b.z() * arms[1];
  const Lane<kLanes> y = b.z() * arms[0] - b.x() * arms[2];
  const Lane<kLanes> z = b.x() * arms[1] - b.y() * arms[0];
  LaneForces<kLanes> row;
  for (int j = 0; j < 3; ++j) {
    row.col(j) = x * grasp.axes[0].col(j) + y * grasp.axes[1].col(j) + z * grasp.axes[2].col(j);
  }
  return row;
}

/// Tests all numbers except the frictions.
bool is_finite(const GraspProblem& problem) {
  bool finite = problem.wrench.allFinite() && problem.centre_m.allFinite();
  for (Index i = 0; i < std::ssize(problem.contacts); ++i) {
    const GraspContact& contact = problem.contacts[i];
    finite = finite && contact.point_m.allFinite() && contact.axes.allFinite() &&
             std::isfinite(problem.internal_force_of(i));
  }
  return finite;
}

/// Returns J by its rows: sum |r|^2 I - r r'.
template <int kLanes>
Matrix3d inertia(const Points<kLanes>& arms) {
  const double xx = arms[0].square().sum();
  const double yy = arms[1].square().sum();
  const double zz = arms[2].square().sum();
  const double xy = (arms[0] * arms[1]).sum();
  const double xz = (arms[0] * arms[2]).sum();
  const double yz = (arms[1] * arms[2]).sum();
  Matrix3d J;
  J << yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy;
  return J;
}

/// Computes B = L^-1 with J = L L'. False if J is too close to singular, or not finite.
bool invert_factor(const Matrix3d& J, Matrix3d& B) {
  // The pivots of Cholesky's method are ratios of the leading minors.
  const double m1 = J(0, 0);
  const double m2 = m1 * J(1, 1) - J(1, 0) * J(1, 0);
  const double c21 = m1 * J(2, 1) - J(2, 0) * J(1, 0);
  const double c20 = J(1, 0) * J(2, 1) - J(1, 1) * J(2, 0);
  const double m3 = c20 * J(2, 0) - c21 * J(2, 1) + m2 * J(2, 2);
  const double trace = J.trace();
  if (!(m3 > kWellSpread * trace * trace * trace)) return false;
  // Row k of L^-1 is that of the minors' cofactors, over the root of two minors.
  const double s2 = 1.0 / std::sqrt(m1 * m2);
  const double s3 = 1.0 / std::sqrt(m2 * m3);
  B << 1.0 / std::sqrt(m1), 0.0, 0.0,  //
      -J(1, 0) * s2, m1 * s2, 0.0,     //
      c20 * s3, -c21 * s3, m2 * s3;
  return true;
}

/// Computes the rows of the torques where contacts are nearly on a line. The axes of the inertia are in order of
/// decreasing moment; each row is made orthogonal to those before it, and B and C with it. False if the wrench has a
/// torque about an axis without moment.
template <int kLanes>
[[gnu::noinline]] bool reduce_near_line(const Points<kLanes>& arms, const GraspProblem& problem, const Vector3d& force,
                                        const Vector3d& torque, ReducedGrasp<kLanes>& grasp, Vector3d& powerless) {
  double largest_m = 0.0;
  for (const GraspContact& contact : problem.contacts) {
    largest_m = std::max(largest_m, contact.point_m.cwiseAbs().maxCoeff());
  }
  const Matrix3d J = inertia<kLanes>(arms);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(J);
  // Contacts at one point differ by the rounding of their coordinates.
  const double rounding_m = 16.0 * std::numeric_limits<double>::epsilon() * largest_m;
  const double least_arm = std::max(kCollinear * std::sqrt(0.5 * J.trace()), rounding_m);
  const double torque_scale = problem.wrench.tail<3>().norm() + grasp.centroid_m.norm() * force.norm();

  grasp.rank = 3;
  grasp.B.setZero();
  grasp.C.setZero();
  bool within_reach = true;
  for (int k = 3; k < 6; ++k) {
    const Vector3d axis = axes.eigenvectors().col(5 - k);
    // The moment by distances, not by axis'J axis: for contacts nearly on the axis this keeps the digits that the
    // differences in J lose.
    const LaneForces<kLanes> row = torque_row<kLanes>(grasp, arms, axis);
    const double arm = std::sqrt(row.square().sum());
    if (!(arm > least_arm)) {
      grasp.Q[k].setZero();
      grasp.w[k] = 0.0;
      const double about_axis = axis.dot(torque);
      if (within_reach && std::abs(about_axis) > kConsistent * torque_scale) {
        within_reach = false;
        powerless = about_axis > 0.0 ? axis : Vector3d(-axis);
      }
      continue;
    }
    ++grasp.rank;
    grasp.Q[k] = row / arm;
    grasp.B.row(k - 3) = axis.transpose() / arm;
    // Rounding of the angle with other rows grows as the arm shrinks, to 1e-6. Twice is enough: the first pass makes it
    // small, the second takes what is left of that.
    for (int pass = 0; pass < 2; ++pass) {
      for (int j = 0; j < k; ++j) {
        const double part = (grasp.Q[k] * grasp.Q[j]).sum();
        grasp.Q[k] -= part * grasp.Q[j];
        if (j < 3) {
          grasp.C(k - 3, j) -= part / std::sqrt(static_cast<double>(grasp.contacts));
        } else {
          grasp.B.row(k - 3) -= part * grasp.B.row(j - 3);
          grasp.C.row(k - 3) -= part * grasp.C.row(j - 3);
        }
      }
      const double length = std::sqrt(grasp.Q[k].square().sum());
      grasp.Q[k] /= length;
      grasp.B.row(k - 3) /= length;
      grasp.C.row(k - 3) /= length;
    }
    grasp.w[k] = grasp.B.row(k - 3).dot(torque) + grasp.C.row(k - 3).dot(force);
  }
  return within_reach;
}

}  // namespace

// Inlined as a whole, but for what is rare: a tenth of the time.
template <int kLanes>
[[gnu::flatten]] Reduction reduce(const GraspProblem& problem, ReducedGrasp<kLanes>& grasp, Vector6d& twist) noexcept {
  const Points<kLanes> arms = gather<kLanes>(problem, grasp);
  // The friction of one contact does not reach the forces of the others, as all other numbers do.
  if (!grasp.cones.mu.allFinite()) return Reduction::kNotFinite;
  const Vector3d force = problem.wrench.head<3>();
  const Vector3d torque = problem.wrench.tail<3>() - grasp.centroid_m.cross(force);
  const double share = 1.0 / std::sqrt(static_cast<double>(grasp.contacts));
  for (int k = 0; k < 3; ++k) {
    grasp.Q[k] = share * grasp.axes[k];
    grasp.w[k] = share * force[k];
  }
  if (invert_factor(inertia<kLanes>(arms), grasp.B)) {
    grasp.rank = 6;
    grasp.C.setZero();
    for (int k = 0; k < 3; ++k) {
      grasp.Q[3 + k] = torque_row<kLanes>(grasp, arms, grasp.B.row(k));
      grasp.w[3 + k] = grasp.B.row(k).dot(torque);
    }
    return Reduction::kDone;
  }

  if (!is_finite(problem)) return Reduction::kNotFinite;
  Vector3d powerless;
  if (reduce_near_line<kLanes>(arms, problem, force, torque, grasp, powerless)) return Reduction::kDone;
  // A turn about the axis through the centroid.
  twist.head<3>() = grasp.centroid_m.cross(powerless);
  twist.tail<3>() = powerless;
  return Reduction::kUnreachable;
}

template <int kLanes>
Vector6d twist_of(const ReducedGrasp<kLanes>& grasp, const std::array<double, 6>& multiplier) noexcept {
  const double share = 1.0 / std::sqrt(static_cast<double>(grasp.contacts));
  const Vector3d l_force(multiplier[0], multiplier[1], multiplier[2]);
  const Vector3d l_torque(multiplier[3], multiplier[4], multiplier[5]);
  const Vector3d turning = grasp.B.transpose() * l_torque;
  Vector6d twist;
  twist.head<3>() = share * l_force + grasp.C.transpose() * l_torque + grasp.centroid_m.cross(turning);
  twist.tail<3>() = turning;
  return twist;
}

template Reduction reduce<4>(const GraspProblem&, ReducedGrasp<4>&, Vector6d&) noexcept;
template Reduction reduce<8>(const GraspProblem&, ReducedGrasp<8>&, Vector6d&) noexcept;
template Vector6d twist_of<4>(const ReducedGrasp<4>&, const std::array<double, 6>&) noexcept;
template Vector6d twist_of<8>(const ReducedGrasp<8>&, const std::array<double, 6>&) noexcept;

}  // namespace thenar
