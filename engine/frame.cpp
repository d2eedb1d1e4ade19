#include "engine/frame.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

void add_contact(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger, Index control_point,
                 const Vector3d& p_F, const Vector3d& s_O, const Vector3d& n_O, Frame& frame) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Matrix3d& R_WF = pose.distal(model.scene.hand, finger).linear();
  const Matrix3d E_W = contact_frame(R_WF, tip.normal, X_WO.linear() * n_O);
  frame.contacts.push_back({finger, control_point, p_F, s_O, n_O, 0.0, R_WF.transpose() * E_W});
}

void find_pulp_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger,
                        std::vector<ContactCandidate>& candidates, Frame& frame) {
  const Pulp& pulp = model.pulps[finger];
  const ContactSettings& contact = model.scene.contact;
  const double widest_m = contact_band_m(model.scene);
  const double depth_m = kTrustPerRadius * model.scene.hand.fingertips[finger].radius_m;
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  // Points far from the surface are the dear ones. A finger at work has contacts enough near it, and a wider band would
  // not change which of them are kept.
  for (double band_m = contact.band_m;; band_m = std::min(2.0 * band_m, widest_m)) {
    find_contacts(pulp.surface, pulp.tree, X_OF, model.object, {band_m, depth_m + band_m, contact.max_per_finger},
                  candidates);
    if (std::ssize(candidates) == contact.max_per_finger || band_m >= widest_m) break;
  }
  for (const ContactCandidate& c : candidates) {
    add_contact(model, pose, X_WO, finger, c.control_point, pulp.control_points_m.col(c.control_point), c.point_m,
                -c.normal, frame);
  }
}

void find_point_contact(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger, Frame& frame) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  const double band_m = contact_band_m(model.scene);
  const double reach_m = tip.radius_m + band_m + model.object.support_m();
  const auto nearest = model.object.distance(X_OF * tip.centre_m, reach_m);
  if (!nearest || nearest->distance_m - tip.radius_m >= band_m) return;
  const Vector3d n_F = X_OF.linear().transpose() * -nearest->normal;
  add_contact(model, pose, X_WO, finger, 0, tip.centre_m + tip.radius_m * n_F, nearest->point_m, -nearest->normal,
              frame);
}

/// The curvature of the object's surface at each contact of a finger, from how normals turn among its contacts: on a
/// sphere n_j - n_i = -(s_j - s_i) / R exactly. Normals of another face (more than 45 degrees off) do not count.
void fill_curvatures(int finger, Frame& frame) {
  constexpr double kSameFace = 0.7;
  for (Index i = frame.begin[finger]; i < frame.size(); ++i) {
    FrameContact& contact = frame.contacts[i];
    double turn = 0.0, way = 0.0;
    for (Index j = frame.begin[finger]; j < frame.size(); ++j) {
      const FrameContact& other = frame.contacts[j];
      if (other.n_O.dot(contact.n_O) < kSameFace) continue;
      const Vector3d step = other.s_O - contact.s_O;
      turn -= step.dot(other.n_O - contact.n_O);
      way += step.squaredNorm();
    }
    contact.curvature_per_m = way > 0.0 ? turn / way : 0.0;
  }
}

}  // namespace

Matrix3d contact_frame(const Matrix3d& R_WF, const Vector3d& pulp_normal, const Vector3d& n_W) {
  const auto carry = Eigen::Quaterniond::FromTwoVectors(pulp_normal, R_WF.transpose() * n_W);
  return axes_of(n_W, R_WF * (carry * pulp_normal.unitOrthogonal()));
}

Matrix3d axes_of(const Vector3d& n, const Vector3d& t1) {
  Matrix3d E;
  E.col(0) = n.normalized();
  E.col(1) = (t1 - t1.dot(E.col(0)) * E.col(0)).normalized();
  E.col(2) = E.col(0).cross(E.col(1));
  return E;
}

ContactGap contact_gap(const FrameContact& contact, const Isometry3d& X_FO, const Vector3d& u_F) {
  const Vector3d n_F = X_FO.linear() * contact.n_O;
  const Vector3d way_F = X_FO * contact.s_O - contact.p_F + u_F;  // finger point to surface point
  // (R + gap)^2 = (R + plane gap)^2 + tangential way^2, solved for the gap without a difference of large numbers; the
  // sphere's centre lies R n from the surface point.
  const double k = contact.curvature_per_m;
  const double a = 2.0 * n_F.dot(way_F) + k * way_F.squaredNorm();
  return {a / (1.0 + std::sqrt(std::max(0.0, 1.0 + k * a))), (n_F + k * way_F).normalized()};
}

Frame::Frame(const Model& model) {
  contacts.reserve(model.max_contacts);
  const Index per_finger = model.deformable() ? model.max_contacts / kFingers : 0;
  for (MatrixXd& C : compliance) C.setZero(3 * per_finger, 3 * per_finger);
  X_WO.setIdentity();
  X_WF.fill(Isometry3d::Identity());
  torque_Nm.setZero();
  wrench.setZero();
}

void find_frame_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO,
                         std::vector<ContactCandidate>& candidates, Frame& frame) {
  frame.contacts.clear();
  for (int k = 0; k < kFingers; ++k) {
    frame.begin[k] = frame.size();
    if (model.deformable()) {
      find_pulp_contacts(model, pose, X_WO, k, candidates, frame);
    } else {
      find_point_contact(model, pose, X_WO, k, frame);
    }
    fill_curvatures(k, frame);
  }
  frame.begin[kFingers] = frame.size();
}

void fill_compliance(const Model& model, Frame& frame) {
  if (!model.deformable()) return;
  for (int k = 0; k < kFingers; ++k) {
    const Pulp& pulp = model.pulps[k];
    const Vector3d S(1.0, pulp.tangential, pulp.tangential);
    for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
      const FrameContact& cj = frame.contacts[j];
      const Matrix3d E_j_S = cj.E_F * S.asDiagonal();
      for (Index i = frame.begin[k]; i <= j; ++i) {
        const FrameContact& ci = frame.contacts[i];
        const Matrix3d C_ij =
            pulp.kernel(ci.control_point, cj.control_point) * (S.asDiagonal() * (ci.E_F.transpose() * E_j_S));
        const Index row = 3 * (i - frame.begin[k]), column = 3 * (j - frame.begin[k]);
        frame.compliance[k].block<3, 3>(row, column) = C_ij;
        frame.compliance[k].block<3, 3>(column, row) = C_ij.transpose();
      }
    }
  }
}

}  // namespace thenar
