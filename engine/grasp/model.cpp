// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/environment/minimum_jerk.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// The part of the move's amount that is done.
double amount_at(const Move& move, double time_s) {
  return minimum_jerk((time_s - move.from_s) / move.over_s) * move.amount;
}

/// Its derivative by time.
double speed_at(const Move& move, double time_s) {
  return minimum_jerk_rate((time_s - move.from_s) / move.over_s) / move.over_s * move.amount;
}

/// Of the arm along its axis [m/s^2]: the second derivative of A e(s) sin(w s), s the time since it began, e the square
/// of a sine that rises over the first swing and falls over the last.
double acceleration(const Arm& arm, double time_s) {
  const double s = time_s - arm.from_s;
  if (s <= 0.0 || s >= arm.over_s) return 0.0;
  const double w = 2.0 * std::numbers::pi * arm.frequency_Hz;
  const double ramp_s = std::min(1.0 / arm.frequency_Hz, 0.5 * arm.over_s);
  const double to_end_s = std::min(s, arm.over_s - s), v = 0.5 * std::numbers::pi / ramp_s;
  double e = 1.0, de = 0.0, dde = 0.0;
  if (to_end_s < ramp_s) {
    e = std::pow(std::sin(v * to_end_s), 2);
    de = (s < arm.over_s - s ? 1.0 : -1.0) * v * std::sin(2.0 * v * to_end_s);
    dde = 2.0 * v * v * std::cos(2.0 * v * to_end_s);
  }
  return arm.amplitude_m * ((dde - e * w * w) * std::sin(w * s) + 2.0 * de * w * std::cos(w * s));
}

constexpr double kRounding_s = 1e-9;

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
  if (const auto& move = scene.task.translate) X_WT.translate(amount_at(*move, time_s) * move->axis);
  if (const auto& move = scene.task.rotate) {
    X_WT.rotate(Eigen::AngleAxisd(amount_at(*move, time_s), move->axis));
  }
  return X_WT;
}

Vector6d Model::target_velocity(double time_s) const {
  Vector6d velocity = Vector6d::Zero();
  const Eigen::Matrix3d& axes = scene.object.X_WO.linear();
  if (const auto& move = scene.task.translate) {
    velocity.head<3>() = speed_at(*move, time_s) * (axes * move->axis);
  }
  if (const auto& move = scene.task.rotate) {
    velocity.tail<3>() = speed_at(*move, time_s) * (axes * move->axis);
  }
  return velocity;
}

Vector3d Model::gravity(double time_s) const {
  if (!scene.task.arm) return scene.gravity;
  const Arm& arm = *scene.task.arm;
  return scene.gravity - acceleration(arm, time_s) * (scene.object.X_WO.linear() * arm.axis);
}

double Model::friction(double time_s) const {
  double friction = scene.contact.friction;
  for (const FrictionStep& step : scene.task.friction) {
    if (time_s >= step.from_s - kRounding_s) friction = step.friction;
  }
  return friction;
}

bool Model::loads_vary() const { return scene.task.arm || (scene.task.push && scene.task.push->rise_s > 0.0); }

Vector6d Model::weight(const Isometry3d& X_WO, const Vector3d& gravity) const {
  Vector6d wrench;
  wrench.head<3>() = scene.object.mass_kg * gravity;
  wrench.tail<3>() = (X_WO.linear() * scene.object.centre_of_mass_m).cross(Vector3d(wrench.head<3>()));
  return wrench;
}

Vector6d Model::external_wrench(double time_s, const Isometry3d& X_WO) const {
  Vector6d wrench = weight(X_WO, gravity(time_s));
  const auto& push = scene.task.push;
  if (!push || time_s < push->from_s || time_s >= push->from_s + push->over_s) return wrench;
  const Eigen::Matrix3d& axes = scene.object.X_WO.linear();
  const double share = push->rise_s > 0.0 ? std::min(1.0, (time_s - push->from_s) / push->rise_s) : 1.0;
  const Vector3d force_N = share * (axes * push->force_N);
  wrench.head<3>() += force_N;
  wrench.tail<3>() += (X_WO.linear() * push->at_m).cross(force_N) + share * (axes * push->moment_Nm);
  return wrench;
}

}  // namespace thenar
