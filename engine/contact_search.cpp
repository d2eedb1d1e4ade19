#include "engine/contact_search.h"

#include <algorithm>

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
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
                        ContactSearch& search, Frame& frame) {
  const Pulp& pulp = model.pulps[finger];
  std::vector<ContactCandidate>& candidates = search.candidates;
  const ContactSettings& contact = model.scene.contact;
  const double widest_m = contact_band_m(model.scene);
  const double depth_m = kTrustPerRadius * model.scene.hand.fingertips[finger].radius_m;
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  // Points far from the surface are the dear ones. A finger at work has contacts enough near it, and a wider band would
  // not change which of them are kept.
  for (double band_m = contact.band_m;; band_m = std::min(2.0 * band_m, widest_m)) {
    find_contacts(pulp.control_points_m, X_OF, model.object, {band_m, depth_m + band_m, contact.max_per_finger},
                  search.memory[finger], candidates);
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

ContactSearch::ContactSearch(const Model& model) {
  if (model.deformable()) candidates.reserve(model.pulps.front().controls());
}

void find_frame_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO, ContactSearch& search,
                         Frame& frame) {
  frame.contacts.clear();
  for (int k = 0; k < kFingers; ++k) {
    frame.begin[k] = frame.size();
    if (model.deformable()) {
      find_pulp_contacts(model, pose, X_WO, k, search, frame);
    } else {
      find_point_contact(model, pose, X_WO, k, frame);
    }
    fill_curvatures(k, frame);
  }
  frame.begin[kFingers] = frame.size();
}

}  // namespace thenar
