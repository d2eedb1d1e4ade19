// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/frame.h"

#include <algorithm>

#include "engine/grasp/local_torus.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

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
  if (contact.fades()) {
    const Vector3d n_F = X_FO.linear() * contact.n_O;
    return {contact.n_O.dot(way) + (contact.press * contact.E_F.col(0) - n_F).dot(u_F), n_F};
  }
  const auto numbers = [](const Vector3d& v) { return lanes::VectorOf<double>{v[0], v[1], v[2]}; };
  const auto [gap_m, n_O] = gap_to(LocalTorus<double>{numbers(contact.n_O), numbers(contact.t_O),
                                                      contact.curvature_per_m, contact.ring_curvature_per_m},
                                   numbers(way));
  return {gap_m, X_FO.linear() * Vector3d(n_O[0], n_O[1], n_O[2])};
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
