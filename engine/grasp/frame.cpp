#include "engine/grasp/frame.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// A unit vector t across the unit vector `from`, carried along the great circle from there to `to`. Of opposite ones
/// along any.
Vector3d carry(const Vector3d& t, const Vector3d& from, const Vector3d& to) {
  const double share = 1.0 + from.dot(to);
  return share > 1e-12 ? Vector3d(t - t.dot(to) / share * (from + to)) : t;
}

/// How far a point is over a circle of curvature k that goes through the origin: `over` above the tangent there, and
/// off its normal by a length with this square.
struct OverCircle {
  double gap_m;
  double root;  ///< Its distance from the circle's centre, in radii.
};

/// (R + gap)^2 = (R + over)^2 + off^2, solved for the gap without a difference of large numbers.
OverCircle over_circle(double k_per_m, double over_m, double off_m2) {
  constexpr double kLeast = 1e-12;  // At the centre there is no normal.
  const double a = 2.0 * over_m + k_per_m * (over_m * over_m + off_m2);
  const double root = std::sqrt(std::max(kLeast, 1.0 + k_per_m * a));
  return {a / (1.0 + root), root};
}

}  // namespace

Matrix3d contact_frame(const Vector3d& pulp_normal, const Vector3d& n_F) {
  return axes_of(n_F, carry(pulp_normal.unitOrthogonal(), pulp_normal, n_F));
}

Matrix3d axes_of(const Vector3d& n, const Vector3d& t1) {
  Matrix3d E;
  E.col(0) = n;
  E.col(1) = (t1 - t1.dot(E.col(0)) * E.col(0)).normalized();
  E.col(2) = E.col(0).cross(E.col(1));
  return E;
}

ContactGap contact_gap(const FrameContact& contact, const Isometry3d& X_FO, const Vector3d& u_F, const Vector3d& u_O) {
  const Vector3d n_F = X_FO.linear() * contact.n_O, t_F = X_FO.linear() * contact.t_O;
  const Vector3d way_F = X_FO * (contact.s_O + u_O) - contact.p_F + u_F;  // finger point to surface point
  const double over = n_F.dot(way_F), along = t_F.dot(way_F);
  const Vector3d across_F = way_F - over * n_F - along * t_F;
  // In the plane of n and n x t the ring is a circle, over which the point is `over_ring` with the normal m. In the
  // plane of m and t the tube is one.
  const double k_ring = contact.ring_curvature_per_m, k_tube = contact.curvature_per_m;
  const OverCircle ring = over_circle(k_ring, over, across_F.squaredNorm());
  const OverCircle tube = over_circle(k_tube, ring.gap_m, along * along);
  const Vector3d m_F = ((1.0 + k_ring * over) * n_F + k_ring * across_F) / ring.root;
  return {tube.gap_m, ((1.0 + k_tube * ring.gap_m) * m_F + k_tube * along * t_F).normalized()};
}

Frame::Frame(const Model& model)
    : X_WF(model.fingers(), Isometry3d::Identity()),
      begin(model.fingers() + 1),
      small(model.fingers()),
      softness(model.fingers(), 1.0) {
  contacts.reserve(model.max_contacts);
  if (model.deformable()) left_out.reserve(2 * model.fingers() * model.pulps.front().controls());
  const Index per_finger = model.deformable() ? model.max_contacts / model.fingers() : 0;
  compliance.assign(model.fingers(), SurfaceCompliance(per_finger));
  if (model.soft_object()) object_kernel.setZero(model.max_contacts, model.max_contacts);
  X_WO.setIdentity();
  torque_Nm = q = q_rest = model.scene.hand.at_zero();
  if (model.scene.muscles_act()) {
    muscle_N.setZero(std::ssize(model.scene.hand.muscles));
    bellies = bellies_of(model.scene.hand);
    turning = PerFinger<JointMatrix>(model.fingers());
  }
  wrench.setZero();
}

}  // namespace thenar
