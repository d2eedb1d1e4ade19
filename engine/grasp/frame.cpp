#include "engine/grasp/frame.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// The turn along the great circle from the unit vector `from` to `to`. Of opposite ones any that takes one to the
/// other. Not Eigen's FromTwoVectors, whose singular values for that case take seconds to compile.
Eigen::Quaterniond turn_between(const Vector3d& from, const Vector3d& to) {
  const Vector3d v0 = from.normalized(), v1 = to.normalized();
  const double c = v1.dot(v0);
  Eigen::Quaterniond turn;
  if (c < -1.0 + 1e-12) {
    turn.w() = 0.0;
    turn.vec() = v0.unitOrthogonal();
    return turn;
  }
  const Vector3d axis = v0.cross(v1);
  const double s = std::sqrt((1.0 + c) * 2.0);
  const double over_s = 1.0 / s;
  turn.vec() = axis * over_s;
  turn.w() = s * 0.5;
  return turn;
}

}  // namespace

Matrix3d contact_frame(const Matrix3d& R_WF, const Vector3d& pulp_normal, const Vector3d& n_W) {
  const auto carry = turn_between(pulp_normal, R_WF.transpose() * n_W);
  return axes_of(n_W, R_WF * (carry * pulp_normal.unitOrthogonal()));
}

Matrix3d axes_of(const Vector3d& n, const Vector3d& t1) {
  Matrix3d E;
  E.col(0) = n;
  E.col(1) = (t1 - t1.dot(E.col(0)) * E.col(0)).normalized();
  E.col(2) = E.col(0).cross(E.col(1));
  return E;
}

ContactGap contact_gap(const FrameContact& contact, const Isometry3d& X_FO, const Vector3d& u_F, const Vector3d& u_O) {
  const Vector3d n_F = X_FO.linear() * contact.n_O;
  const Vector3d way_F = X_FO * (contact.s_O + u_O) - contact.p_F + u_F;  // finger point to surface point
  // (R + gap)^2 = (R + plane gap)^2 + tangential way^2, solved for the gap without a difference of large numbers; the
  // sphere's centre lies R n from the surface point.
  const double k = contact.curvature_per_m;
  const double a = 2.0 * n_F.dot(way_F) + k * way_F.squaredNorm();
  return {a / (1.0 + std::sqrt(std::max(0.0, 1.0 + k * a))), (n_F + k * way_F).normalized()};
}

Frame::Frame(const Model& model) {
  contacts.reserve(model.max_contacts);
  if (model.deformable()) left_out.reserve(2 * kFingers * model.pulps.front().controls());
  const Index per_finger = model.deformable() ? model.max_contacts / kFingers : 0;
  compliance.fill(SurfaceCompliance(per_finger));
  if (model.soft_object()) object_kernel.setZero(model.max_contacts, model.max_contacts);
  X_WO.setIdentity();
  X_WF.fill(Isometry3d::Identity());
  softness.fill(1.0);
  torque_Nm.setZero();
  wrench.setZero();
}

}  // namespace thenar
