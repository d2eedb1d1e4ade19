// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <string_view>

#include "engine/scenes/describe.h"

/// Rotations of a scene, and the ways to write them.
namespace thenar {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;
using enum Dimension;

namespace {

/// Returns the turns about the fixed axes, one after the other in this order.
Matrix3d turned(const Vector3d& angles_rad, std::string_view order) {
  Matrix3d R = Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) R = AngleAxisd(angles_rad[i], Vector3d::Unit(order[i] - 'x')) * R;
  return R;
}

void describe_axis_and_angle(Visitor& v, Matrix3d& rotation) {
  std::optional<Vector3d> axis;
  std::optional<double> angle_rad;
  describe_direction(v, {"axis", kNone, "", "(With angle.)", "The axis that it turns about, of any length but zero."},
                     axis);
  v.key({"angle", kAngle, "", "(With axis.)", "By how much it turns about the axis, by the right-hand rule."},
        angle_rad);
  if (axis && angle_rad) rotation = AngleAxisd(*angle_rad, *axis).toRotationMatrix();
  if (axis && !angle_rad) v.refuse("angle", "is missing: by how much it turns about the axis");
  if (angle_rad && !axis) v.refuse("axis", "is missing: what the angle is about");
}

void describe_euler(Visitor& v, Matrix3d& rotation) {
  std::optional<Vector3d> euler_rad;
  std::string order = "xyz";
  v.key({"euler", kAngle, "", "(Or axis and angle, or quaternion.)",
         "Three turns about fixed axes, one after the other: extrinsic Euler angles, in the order xyz roll, pitch and "
         "yaw as in URDF."},
        euler_rad);
  if (v.when(euler_rad.has_value())) {
    const std::vector<std::string> orders{"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"};
    v.choice({"order", kNone, "xyz | xzy | yxz | yzx | zxy | zyx", "xyz",
              "The axes of the three turns of euler, the first one first."},
             order, orders);
  } else if (v.has("order")) {
    v.refuse("order", "is that of euler: name that, too");
  }
  if (euler_rad) rotation = turned(*euler_rad, order);
}

void describe_quaternion(Visitor& v, Matrix3d& rotation) {
  std::optional<Vector4d> wxyz;
  v.key({"quaternion", kNone, "", "(Or axis and angle, or euler.)", "A quaternion w, x, y, z, of any length but zero."},
        wxyz);
  if (!wxyz) return;
  if (wxyz->norm() > 0.0) {
    const Vector4d q = wxyz->normalized();
    rotation = Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  } else {
    v.refuse("quaternion", "must not be zero");
  }
}

/// Returns false for a map that has no rotation.
bool describe_as_map(Visitor& v, Matrix3d& rotation) {
  describe_axis_and_angle(v, rotation);
  describe_euler(v, rotation);
  describe_quaternion(v, rotation);
  if (!v.reads()) return true;
  int forms = 0;
  for (const char* form : {"axis", "euler", "quaternion"}) {
    if (v.has(form) && ++forms > 1) v.refuse(form, "only one of axis with angle, euler and quaternion may be given");
  }
  return forms > 0;
}

}  // namespace

void describe_rotation(Visitor& v, const KeyRow& row, Matrix3d& rotation) {
  bool has_form = true;
  v.value_or_map(row, rotation, false, [&] { has_form = describe_as_map(v, rotation); });
  if (!has_form) v.refuse(row.name, "needs one of axis with angle, euler, quaternion");
}

void describe_rotation(Visitor& v, const KeyRow& row, std::optional<Matrix3d>& rotation) {
  if (!v.is_there(row.name, rotation.has_value())) return rotation.reset();
  Matrix3d now = rotation.value_or(Matrix3d::Identity());
  describe_rotation(v, row, now);
  rotation = now;
}

void describe_pose(Visitor& v, const KeyRow& position, const KeyRow& rotation, Eigen::Isometry3d& X) {
  Vector3d position_m = X.translation();
  Matrix3d R = X.linear();
  v.key(position, position_m);
  describe_rotation(v, rotation, R);
  X.translation() = position_m;
  X.linear() = R;
}

}  // namespace thenar
