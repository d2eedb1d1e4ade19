#include "engine/grasp/model.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// From 0 to 1 with no velocity and acceleration at both ends.
double minimum_jerk(const Move& move, double time_s) {
  const double s = std::clamp((time_s - move.from_s) / move.over_s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

}  // namespace

bool Model::control_is_due(std::int64_t tick) const {
  // A period that ends at a step's start, but for rounding, ends there.
  const auto periods = [&](std::int64_t t) {
    return std::floor(static_cast<double>(t) * scene.step_s / scene.control_period_s + 1e-6);
  };
  return tick == 0 || periods(tick) > periods(tick - 1);
}

Isometry3d Model::target(double time_s) const {
  Isometry3d X_WT = scene.object.X_WO;
  if (const auto& move = scene.task.translate) X_WT.translate(minimum_jerk(*move, time_s) * move->amount * move->axis);
  if (const auto& move = scene.task.rotate) {
    X_WT.rotate(Eigen::AngleAxisd(minimum_jerk(*move, time_s) * move->amount, move->axis));
  }
  return X_WT;
}

Vector6d Model::weight(const Isometry3d& X_WO) const {
  Vector6d wrench;
  wrench.head<3>() = scene.object.mass_kg * scene.gravity;
  wrench.tail<3>() = (X_WO.linear() * scene.object.centre_of_mass_m).cross(Vector3d(wrench.head<3>()));
  return wrench;
}

Vector6d Model::external_wrench(double time_s, const Isometry3d& X_WO) const {
  Vector6d wrench = weight(X_WO);
  const auto& push = scene.task.push;
  if (!push || time_s < push->from_s || time_s >= push->from_s + push->over_s) return wrench;
  const Eigen::Matrix3d& axes = scene.object.X_WO.linear();
  const Vector3d force_N = axes * push->force_N;
  wrench.head<3>() += force_N;
  wrench.tail<3>() += (X_WO.linear() * push->at_m).cross(force_N) + axes * push->moment_Nm;
  return wrench;
}

}  // namespace thenar
