// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/carry_over.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixX3d;
using Eigen::Vector3d;

namespace {

constexpr double kSamePoint_m2 = 1e-18;  // distance squared

Index nearest(const Matrix3Xd& points, const Vector3d& x) {
  Index i = 0;
  (points.colwise() - x).colwise().squaredNorm().minCoeff(&i);
  return i;
}

/// Shepard's interpolation from the four nearest control points; at one of them, its own value.
Vector3d interpolate(const Matrix3Xd& points, const MatrixX3d& values, const Vector3d& x) {
  Eigen::VectorXd squared_m2 = (points.colwise() - x).colwise().squaredNorm();
  Vector3d sum = Vector3d::Zero();
  double weights = 0.0;
  for (Index n = 0; n < std::min<Index>(4, points.cols()); ++n) {
    Index i = 0;
    const double distance_m2 = squared_m2.minCoeff(&i);
    if (distance_m2 < kSamePoint_m2) return values.row(i).transpose();
    sum += values.row(i).transpose() / distance_m2;
    weights += 1.0 / distance_m2;
    squared_m2[i] = std::numeric_limits<double>::infinity();
  }
  return sum / weights;
}

/// Gives forces to the nearest control points, sorted; `add` puts one to another of the same control point.
template <typename Force, typename Add>
void carry(const Model& from, const Model& to, const std::vector<Force>& old, Add add, std::vector<Force>& carried) {
  for (Force force : old) {
    const Vector3d x = from.pulps[force.finger].control_points_m.col(force.control_point);
    force.control_point = nearest(to.pulps[force.finger].control_points_m, x);
    const auto same = [&](const Force& other) { return id_of(other) == id_of(force); };
    const auto known = std::find_if(carried.begin(), carried.end(), same);
    if (known == carried.end()) {
      carried.push_back(force);
    } else {
      add(force, *known);
    }
  }
  std::sort(carried.begin(), carried.end(), [](const Force& a, const Force& b) { return id_of(a) < id_of(b); });
}

}  // namespace

std::int64_t same_time(const Model& from, std::int64_t tick, const Model& to) {
  return std::llround(static_cast<double>(tick) * from.scene.step_s / to.scene.step_s);
}

State carry_over(const Model& from, const State& state, const Model& to) {
  State carried(to);
  std::vector<ContactForce> room = std::move(carried.contact_forces);  // As large as that model's frames.
  const MuscleVector none = carried.pull_N;
  static_cast<Snapshot&>(carried) = state;
  if (carried.pull_N.size() != none.size()) carried.pull_N = none;
  carried.contact_forces = std::move(room);
  if (!to.scene.muscles_act()) carried.muscle_N.resize(0);
  carried.tick = same_time(from, state.tick, to);
  carried.environment_forces = state.environment_forces;
  if (!to.deformable()) {
    carried.forces.assign(state.forces.begin(), state.forces.end());
    for (ContactForce& force : carried.forces) force.held_J = 0.0;
    return carried;
  }
  carried.pulp_energy_J = state.pulp_energy_J;
  carried.object_energy_J = state.object_energy_J;
  for (std::size_t k = 0; k < to.pulps.size(); ++k) {
    const Matrix3Xd& points = to.pulps[k].control_points_m;
    for (Index i = 0; i < points.cols(); ++i) {
      carried.u_m[k].row(i) = interpolate(from.pulps[k].control_points_m, state.u_m[k], points.col(i)).transpose();
    }
  }
  carry(
      from, to, state.forces,
      [](const ContactForce& force, ContactForce& sum) {
        sum.f_C += force.f_C;
        sum.held_J += force.held_J;
      },
      carried.forces);
  carry(
      from, to, state.object_loads,
      [](const ObjectLoad& load, ObjectLoad& sum) {
        sum.w_O += load.w_O;
        sum.area_m2 += load.area_m2;
      },
      carried.object_loads);
  return carried;
}

}  // namespace thenar
