#include "engine/control/pose_loop.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "engine/control/control.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double pose_rate(const Model& model) {
  const Scene& scene = model.scene;
  const State start(model);
  HandPose pose;
  forward_kinematics(scene.hand, start.q, pose);
  Matrix6d B = Matrix6d::Zero(), K = Matrix6d::Zero();
  B.diagonal().head<3>().setConstant(scene.object.translation_damping);
  B.diagonal().tail<3>().setConstant(scene.object.rotation_damping);
  K.diagonal().head<3>().setConstant(scene.control->position.p);
  K.diagonal().tail<3>().setConstant(scene.control->rotation.p);
  if (const auto& centre = scene.control->centre_m) {
    Matrix6d to_centre = Matrix6d::Identity();
    const Vector3d lever_m = start.X_WO.linear() * *centre;
    for (int axis = 0; axis < 3; ++axis) to_centre.col(3 + axis).head<3>() = Vector3d::Unit(axis).cross(lever_m);
    K = to_centre.transpose().lazyProduct(K.lazyProduct(to_centre).eval()).eval();
  }
  for (int k = 0; k < model.fingers(); ++k) {
    const Vector3d point_m = finger_contact(model, pose, start, k).point_m;
    const Matrix3d JJ = damped(squared(finger_jacobian(scene.hand, pose, k, point_m)));
    const Vector3d lever_m = point_m - start.X_WO.translation();
    Eigen::Matrix<double, 3, 6> at;  // The point's velocity for the object's.
    at.leftCols<3>().setIdentity();
    for (int axis = 0; axis < 3; ++axis) at.col(3 + axis) = Vector3d::Unit(axis).cross(lever_m);
    B += scene.viscosity(k) * at.transpose() * JJ.ldlt().solve(at);
  }
  return Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d>(K, B, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

double loop_delay_s(const Scene& scene) {
  return scene.control->feedback_delay_s + scene.control_delay_s + 0.5 * scene.control_period_s;
}

void Swings::Course::add(double now, double least) {
  const double on = way * (now - far);
  if (way == 0 && std::abs(now - far) > least) way = now > far ? 1 : -1;
  if (way != 0 && on >= 0.0) far = now;
  if (!(on < -0.1 * least)) return;
  // It reverses. For an angle, which has no sign, two swings are one: there and back.
  const double size = std::abs(far - turned);
  wider = one_before > 0.0 && size > least && size > kWider * kWider * one_before ? wider + 1 : 0;
  if (wider == 0) first = size;
  one_before = last;
  last = size;
  turned = far;
  far = now;
  way = -way;
}

std::optional<Swings::Swing> Swings::add(const Vector3d& off_m, double off_rad) {
  for (int i = 0; i < 4; ++i) {
    const bool turns = i == 3;
    Course& course = courses_[i];
    course.add(turns ? off_rad : off_m[i], turns ? kLeast_rad : kLeast_m);
    if (course.wider >= kOnEnd && course.last > kGrown * course.first) return Swing{turns, course.last};
  }
  return std::nullopt;
}

}  // namespace thenar
