// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/fine_contacts.h"

#include <algorithm>

#include "engine/grasp/pulp_touch.h"
#include "engine/grasp/small_contacts.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// find_fine_samples() of a pulp that is no sphere.
bool find_fine_samples_of_shape(const Model& model, const Isometry3d& X_OF, int finger, double band_m,
                                FineContacts& work) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Pulp& pulp = model.pulps[finger];
  const Isometry3d X_FO = X_OF.inverse();
  const double reach_m = tip.shape->outer_radius_m() + band_m;
  bool any = false;
  for (Index i = 0; i < model.fine_m.cols(); ++i) {
    const Vector3d s_F = X_FO * model.fine_m.col(i);
    if ((s_F - tip.centre_m).squaredNorm() >= reach_m * reach_m) continue;
    const PulpPlace place = nearest_place(tip, s_F);
    if (place.distance_m >= band_m) continue;
    if (!any) work.deepest.assign(pulp.controls(), -1);
    any = true;
    Index c = 0;
    (pulp.control_points_m.colwise() - place.point_m).colwise().squaredNorm().minCoeff(&c);
    Index& deepest = work.deepest[c];
    if (deepest < 0 || place.distance_m < nearest_place(tip, X_FO * model.fine_m.col(deepest)).distance_m) deepest = i;
  }
  return any;
}

/// For each control point the fine sample that is deepest in the pulp, or nearest to it within the band, among those
/// nearer to it than to other control points. False if there is none.
bool find_fine_samples(const Model& model, const Isometry3d& X_OF, int finger, double band_m, FineContacts& work) {
  if (model.pulps[finger].shape) return find_fine_samples_of_shape(model, X_OF, finger, band_m, work);
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Pulp& pulp = model.pulps[finger];
  const Vector3d centre_O = X_OF * tip.centre_m;
  const double radius_m = tip.radius_m + band_m;
  bool any = false;
  for (Index i = 0; i < model.fine_m.cols(); ++i) {
    const Vector3d way_O = model.fine_m.col(i) - centre_O;
    const double squared = way_O.squaredNorm();
    if (squared >= radius_m * radius_m || squared == 0.0) continue;
    if (!any) work.deepest.assign(pulp.controls(), -1);
    any = true;
    Index c = 0;
    pulp.control_normals.lazyProduct(Vector3d(X_OF.linear().transpose() * way_O)).maxCoeff(&c);
    Index& deepest = work.deepest[c];
    if (deepest < 0 || squared < (model.fine_m.col(deepest) - centre_O).squaredNorm()) deepest = i;
  }
  return any;
}

}  // namespace

void take_nearest(const Model& model, const Isometry3d& X_FO, std::vector<FrameContact>& contacts, Frame& frame) {
  const auto gap_m = [&](const FrameContact& contact) { return contact_gap(contact, X_FO, Vector3d::Zero()).gap_m; };
  const auto end = contacts.begin() + std::min(std::ssize(contacts), model.scene.contact.max_per_finger);
  if (end != contacts.end()) {
    std::nth_element(contacts.begin(), end, contacts.end(),
                     [&](const FrameContact& a, const FrameContact& b) { return gap_m(a) < gap_m(b); });
  }
  std::sort(contacts.begin(), end,
            [](const FrameContact& a, const FrameContact& b) { return a.control_point < b.control_point; });
  frame.contacts.insert(frame.contacts.end(), contacts.begin(), end);
  frame.left_out.insert(frame.left_out.end(), end, contacts.end());
}

[[gnu::flatten]] void add_fine_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger,
                                        double band_m, FineContacts& work, Frame& frame) {
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  if (!find_fine_samples(model, X_OF, finger, band_m, work)) return;
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d X_FO = X_OF.inverse();
  const auto gap_m = [&](const FrameContact& contact) { return contact_gap(contact, X_FO, Vector3d::Zero()).gap_m; };
  const auto first = frame.contacts.begin() + frame.begin[finger];
  work.contacts.assign(first, frame.contacts.end());
  frame.contacts.erase(first, frame.contacts.end());
  auto found = work.contacts.begin();
  const auto known = work.contacts.size();
  for (Index c = 0; c < std::ssize(work.deepest); ++c) {
    if (work.deepest[c] < 0) continue;
    const Vector3d s_O = model.fine_m.col(work.deepest[c]);
    const Vector3d s_F = X_FO * s_O;
    Vector3d n_F = (s_F - tip.centre_m).normalized(), p_F = tip.centre_m + tip.radius_m * n_F;
    if (tip.shape) {
      const PulpPlace place = nearest_place(tip, s_F);
      n_F = place.normal;
      p_F = place.point_m;
    }
    const FrameContact fine = frame_contact(tip, X_OF.linear(), finger, c, p_F, s_O, -(X_OF.linear() * n_F), {});
    const auto end = work.contacts.begin() + static_cast<std::ptrdiff_t>(known);
    while (found != end && found->control_point < c) ++found;
    if (found == end || found->control_point != c) {
      work.contacts.push_back(fine);
    } else if (gap_m(fine) < gap_m(*found)) {
      *found = fine;
    }
  }
  take_nearest(model, X_FO, work.contacts, frame);
}

}  // namespace thenar
