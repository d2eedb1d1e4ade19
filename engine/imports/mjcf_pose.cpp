// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <initializer_list>

namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kNoLength = 1e-10;

Matrix3d of_quaternion(const XmlElement& element) {
  const VectorXd q = *numbers(element, "quat", 4, 4);
  if (!(q.norm() > kNoLength)) refuse(element, "quat: must not be zero");
  return Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

Matrix3d of_axis_and_angle(const XmlElement& element, const MjcfAngles& angles) {
  const VectorXd values = *numbers(element, "axisangle", 4, 4);
  const Vector3d axis = values.head<3>();
  if (!(axis.norm() > kNoLength)) refuse(element, "axisangle: the axis must not be zero");
  return AngleAxisd(angles.unit_rad * values[3], axis.normalized()).toRotationMatrix();
}

Matrix3d of_x_and_y(const XmlElement& element) {
  const VectorXd values = *numbers(element, "xyaxes", 6, 6);
  const Vector3d x = values.head<3>(), y = values.tail<3>();
  const Vector3d z = x.cross(y);
  if (!(x.norm() > kNoLength && z.norm() > kNoLength)) refuse(element, "xyaxes: must be two directions that differ");
  Matrix3d R;
  R.col(0) = x.normalized();
  R.col(2) = z.normalized();
  R.col(1) = Vector3d(R.col(2)).cross(Vector3d(R.col(0)));
  return R;
}

Matrix3d of_euler(const XmlElement& element, const MjcfAngles& angles) {
  const Vector3d euler = *vector3(element, "euler");
  Matrix3d R = Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    const char letter = angles.euler[static_cast<std::size_t>(i)];
    const Matrix3d turn =
        AngleAxisd(angles.unit_rad * euler[i], Vector3d(Vector3d::Unit(std::tolower(letter) - 'x'))).toRotationMatrix();
    R = std::islower(letter) != 0 ? Matrix3d(R * turn) : Matrix3d(turn * R);
  }
  return R;
}

int ways_of(const XmlElement& element, std::initializer_list<const char*> ways) {
  return static_cast<int>(std::ranges::count_if(ways, [&](const char* way) { return element.find(way) != nullptr; }));
}

}  // namespace

MjcfAngles angles_of(const XmlElement& mujoco, const MjcfDefaults& defaults) {
  MjcfAngles angles;
  const std::string unit = defaults.compiler("angle"), sequence = defaults.compiler("eulerseq");
  if (unit == "radian") angles.unit_rad = 1.0;
  if (!unit.empty() && unit != "radian" && unit != "degree") refuse(mujoco, fmt::format("no angle is a '{}'", unit));
  if (!sequence.empty()) angles.euler = sequence;
  const bool is_known = angles.euler.size() == 3 && angles.euler.find_first_not_of("xyzXYZ") == std::string::npos;
  if (!is_known) refuse(mujoco, fmt::format("eulerseq must be three of x, y, z, X, Y, Z, not '{}'", angles.euler));
  return angles;
}

std::optional<MjcfEnds> ends_of(const XmlElement& element, const std::string& type) {
  const auto ends = numbers(element, "fromto", 6, 6);
  if (!ends) return std::nullopt;
  if (type != "capsule" && type != "cylinder" && type != "ellipsoid" && type != "box") {
    refuse(element, fmt::format("fromto: a {} has none, but a capsule, cylinder, ellipsoid or box", type));
  }
  const Vector3d from = ends->head<3>(), to = ends->tail<3>();
  MjcfEnds found{Isometry3d::Identity(), 0.5 * (to - from).norm()};
  if (!(found.half_m > kNoLength)) refuse(element, "fromto: must be two points that differ");
  found.X_FG.translation() = 0.5 * (from + to);
  found.X_FG.linear() = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), from - to).toRotationMatrix();
  return found;
}

void expect_one_orientation(const XmlElement& element) {
  if (ways_of(element, {"quat", "axisangle", "xyaxes", "zaxis", "euler"}) > 1)
    refuse(element, "names two orientations");
}

Isometry3d pose_of(const XmlElement& element, const MjcfAngles& angles) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = vector3(element, "pos").value_or(Vector3d::Zero());
  if (ways_of(element, {"axisangle", "xyaxes", "zaxis", "euler"}) > 1) {
    refuse(element, "names an orientation, and its class one of another kind: write both in one kind");
  }
  if (element.find("quat") != nullptr) X.linear() = of_quaternion(element);
  if (element.find("axisangle") != nullptr) X.linear() = of_axis_and_angle(element, angles);
  if (element.find("xyaxes") != nullptr) X.linear() = of_x_and_y(element);
  if (element.find("euler") != nullptr) X.linear() = of_euler(element, angles);
  if (const auto z = direction(element, "zaxis")) {
    X.linear() = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), *z).toRotationMatrix();
  }
  return X;
}

}  // namespace thenar
