#include "engine/grasp/frame.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// How a point stands to a circle of curvature k that goes through the origin, from which it is `over_m` above the
/// tangent and off the normal by a length with this square: (R + gap)^2 = (R + over)^2 + off^2, solved for the gap
/// without a difference of large numbers.
struct OverCircle {
  OverCircle(double k_per_m, double over_m, double off_m2) {
    constexpr double kLeast = 1e-12;  // At the centre there is no normal.
    const double a = 2.0 * over_m + k_per_m * (over_m * over_m + off_m2);
    root = std::sqrt(std::max(kLeast, 1.0 + k_per_m * a));
    gap_m = a / (1.0 + root);
  }
  double root;  ///< Its distance from the circle's centre, in radii.
  double gap_m;
};

}  // namespace

Matrix3d contact_frame(const Vector3d& pulp_normal, const Vector3d& n_F) {
  const Vector3d t = pulp_normal.unitOrthogonal();
  const double share = 1.0 + pulp_normal.dot(n_F);
  // Of opposite normals along any great circle.
  if (!(share > 1e-12)) return axes_of(n_F, t);
  // Of length one and across n, as t is across the other.
  const Vector3d t1 = t - t.dot(n_F) / share * (pulp_normal + n_F);
  // Of nearly opposite normals the share has few digits, so that the axes are made orthonormal again.
  if (share < 1e-3) return axes_of(n_F, t1);
  Matrix3d E;
  E.col(0) = n_F;
  E.col(1) = t1;
  E.col(2) = n_F.cross(t1);
  return E;
}

Matrix3d axes_of(const Vector3d& n, const Vector3d& t1) {
  Matrix3d E;
  E.col(0) = n;
  E.col(1) = (t1 - t1.dot(E.col(0)) * E.col(0)).normalized();
  E.col(2) = E.col(0).cross(E.col(1));
  return E;
}

ContactGap contact_gap(const FrameContact& contact, const Isometry3d& X_FO, const Vector3d& u_F, const Vector3d& u_O) {
  // From the finger point to the surface point.
  const Vector3d way = contact.s_O + u_O - X_FO.linear().transpose() * (contact.p_F - u_F - X_FO.translation());
  const double k_ring = contact.ring_curvature_per_m, k_tube = contact.curvature_per_m;
  if (contact.fades()) {
    const Vector3d n_F = X_FO.linear() * contact.n_O;
    return {contact.n_O.dot(way) + (contact.press * contact.E_F.col(0) - n_F).dot(u_F), n_F};
  }
  const double over = contact.n_O.dot(way);
  if (k_tube == 0.0) return {over, X_FO.linear() * contact.n_O};
  // In the plane of n and n x t the ring is a circle, over which the point is `gap_m` with the normal m. In the plane
  // of m and t the tube is one.
  const double along = contact.t_O.dot(way);
  double gap_m = over;
  Vector3d m = contact.n_O;
  if (k_ring != 0.0) {
    const Vector3d across = way - over * contact.n_O - along * contact.t_O;
    const OverCircle ring(k_ring, over, across.squaredNorm());
    gap_m = ring.gap_m;
    const double part = 1.0 / ring.root;
    m = part * (1.0 + k_ring * over) * contact.n_O + part * k_ring * across;
  }
  const OverCircle tube(k_tube, gap_m, along * along);
  const double part = 1.0 / tube.root;
  const Vector3d n_O = part * (1.0 + k_tube * gap_m) * m + part * k_tube * along * contact.t_O;
  return {tube.gap_m, X_FO.linear() * n_O};
}

double area_of(const Model& model, const FrameContact& contact) {
  if (contact.area_m2 > 0.0) return contact.area_m2;
  // The share is of stiffness, which goes with the root of an area.
  return contact.share * contact.share * model.pulps[contact.finger].area_m2[contact.control_point];
}

double covered_share(const Model& model, const FrameContact& contact) {
  if (!(contact.area_m2 > 0.0)) return contact.covered;
  return std::min(1.0, contact.area_m2 / model.pulps[contact.finger].area_m2[contact.control_point]);
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
  if (model.scene.has_muscles()) muscle_N.setZero(std::ssize(model.scene.hand.muscles));
  if (model.scene.muscles_act()) {
    bellies = bellies_of(model.scene.hand);
    turning = PerFinger<JointMatrix>(model.fingers());
  }
  wrench.setZero();
}

}  // namespace thenar
