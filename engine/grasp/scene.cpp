// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/scene.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace thenar {

using Eigen::Index;

namespace {

/// The axes about which a body looks the same at all angles.
struct Revolution {
  static constexpr int kNone = -1, kAll = 3;

  int operator()(const SphereShape&) const { return kAll; }
  int operator()(const CylinderShape&) const { return 2; }
  int operator()(const Mug& mug) const { return mug.handle ? kNone : 2; }
  int operator()(const EllipsoidShape& ellipsoid) const {
    const auto& size_m = ellipsoid.size_m;
    if (size_m[0] == size_m[1]) return size_m[1] == size_m[2] ? kAll : 2;
    return size_m[1] == size_m[2] ? 0 : size_m[0] == size_m[2] ? 1 : kNone;
  }
  int operator()(const SuperquadricShape& shape) const {
    const bool is_round = shape.size_m[0] == shape.size_m[1] && shape.exponents.east_west == 1.0;
    if (!is_round) return kNone;
    return shape.size_m[1] == shape.size_m[2] && shape.exponents.north_south == 1.0 ? kAll : 2;
  }
  int operator()(const BoxShape&) const { return kNone; }
  int operator()(const CloudShape&) const { return kNone; }
};

}  // namespace

Eigen::VectorXd DriveTable::at(double at_s) const {
  const Index last = time_s.size() - 1;
  const Index after = std::upper_bound(time_s.begin(), time_s.end(), at_s) - time_s.begin();
  if (after == 0) return values.col(0);
  if (after > last) return values.col(last);
  const double share = (at_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]);
  return values.col(after - 1) + share * (values.col(after) - values.col(after - 1));
}

std::optional<Solid> solid_of(const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return *box;
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return *sphere;
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) return *cylinder;
  return std::nullopt;
}

std::optional<ExactShape> exact_shape_of(const Shape& shape) {
  return std::visit(
      []<typename Kind>(const Kind& kind) -> std::optional<ExactShape> {
        if constexpr (std::is_same_v<Kind, CloudShape>) {
          return std::nullopt;
        } else {
          return kind;
        }
      },
      shape);
}

double turn_rad(const Shape& shape, const Eigen::Matrix3d& R_goal, const Eigen::Matrix3d& R) {
  const int axis = std::visit(Revolution(), shape);
  if (axis == Revolution::kAll) return 0.0;
  if (axis == Revolution::kNone) return Eigen::AngleAxisd(Eigen::Matrix3d(R_goal.transpose() * R)).angle();
  const Eigen::Vector3d goal = R_goal.col(axis), now = R.col(axis);
  return std::atan2(goal.cross(now).norm(), goal.dot(now));
}

const char* to_string(Phase::Kind kind) {
  switch (kind) {
    case Phase::Kind::kApproach:
      return "approach";
    case Phase::Kind::kClose:
      return "close";
    case Phase::Kind::kLoad:
      return "load";
    case Phase::Kind::kLift:
      return "lift";
    case Phase::Kind::kMove:
      return "move";
    case Phase::Kind::kInsert:
      return "insert";
    case Phase::Kind::kPlace:
      return "place";
    case Phase::Kind::kRelease:
      return "release";
  }
  return "";
}

}  // namespace thenar
