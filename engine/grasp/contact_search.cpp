#include "engine/grasp/contact_search.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/grasp/finger_travel.h"
#include "engine/grasp/pulp_touch.h"
#include "engine/grasp/small_contacts.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// A face that the pulp there does not look at, to 60 degrees, is not the one that it came through: the far side of
// something thin, or the side of a pressed edge. On the face itself no point of a pulp within the trust looks further
// off.
constexpr double kFarSide = -0.5;

// A sheared point has its own place on the surface looked for, where it has gone so many supports along it, and the
// normal turns by so much on that way.
constexpr double kAside = 0.05, kTurn_rad = 1e-3;
// A foot is held while its point goes no farther than this: then the torus there has the surface's normal to about the
// square of the turn, and its height to the cube of it.
constexpr double kHeld = 0.1, kHeldTurn_rad = 0.01;
// A thin wall has two faces.
constexpr double kSameFace = 0.5;

// A finger that goes less far, in supports, meets what it met.
constexpr double kStays = 0.02;
// Less than this is flat: 5 nm lower a millimetre off.
constexpr double kFlat_per_m = 0.01;

/// `n_O` is out of the object.
FrameContact frame_contact(const Fingertip& tip, const Matrix3d& R_OF, int finger, Index control_point,
                           const Vector3d& p_F, const Vector3d& s_O, const Vector3d& n_O, const SurfaceBend& bend) {
  FrameContact contact;
  contact.finger = finger;
  contact.control_point = control_point;
  contact.p_F = p_F;
  put_on_surface(s_O, n_O, bend, tip, R_OF, contact);
  return contact;
}

/// Whether both name the same control points with the same normals, to a degree.
bool agree(const std::vector<ContactCandidate>& a, const std::vector<ContactCandidate>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const ContactCandidate& of_a, const ContactCandidate& of_b) {
                      return of_a.control_point == of_b.control_point && of_a.normal.dot(of_b.normal) > 0.9998;
                    });
}

/// The search of one finger's pulp.
struct PulpSearch {
  const Model& model;
  const ContactSnapshot& snapshot;
  int finger;
  Isometry3d X_OF;
  double band_m, depth_m;
  ContactSearch& search;

  [[nodiscard]] const Pulp& pulp() const { return model.pulps[finger]; }
  [[nodiscard]] Index most() const { return model.scene.contact.max_per_finger; }

  [[nodiscard]] Vector3d p_O(Index c) const { return X_OF * pulp().control_points_m.col(c); }
  [[nodiscard]] Vector3d u_O(Index c) const { return X_OF.linear() * snapshot.u_m[finger].row(c).transpose(); }
  /// Out of the pulp at rest, and into what it presses.
  [[nodiscard]] Vector3d normal_O(Index c) const { return X_OF.linear() * pulp().control_normals.row(c).transpose(); }

  [[nodiscard]] bool faces_away(const ContactCandidate& c) const {
    return c.normal.dot(normal_O(c.control_point)) > kFarSide;
  }

  /// A pulp reaches around what bends more than itself, and touches that from all sides that it faces.
  [[nodiscard]] bool is_round(const ContactCandidate& c) const {
    return std::max(c.bend.k1_per_m, c.bend.k2_per_m) * model.scene.hand.fingertips[finger].radius_m > 1.0;
  }

  /// How much farther off at rest points may be near as they are deformed: none of a box's, whose faces are flat.
  [[nodiscard]] std::span<const double> widened() const {
    if (model.exact && is_flat(*model.exact)) return {};
    search.moved_m = snapshot.u_m[finger].cwiseAbs2().rowwise().sum().cwiseSqrt();
    return {search.moved_m.data(), static_cast<std::size_t>(search.moved_m.size())};
  }

  /// Points that are near the surface at rest, or as they are deformed. A finger at work has contacts enough near the
  /// surface: what is farther is not left out.
  void find() {
    std::vector<ContactCandidate>& candidates = search.candidates;
    FindingMemory& memory = search.memory[finger];
    if (!memory.known.empty()) widen(widened(), memory);
    find_contacts(pulp().control_points_m, X_OF, model.object, {band_m, depth_m + band_m, pulp().controls()}, memory,
                  candidates);
    if (search.draws_in[finger]) search.plain = candidates;
    std::erase_if(candidates, [&](ContactCandidate& c) { return !place(c); });
    double within_m = model.scene.contact.band_m;
    const auto is_within = [&](const ContactCandidate& c) { return std::min(c.gap_m, c.deformed_gap_m) < within_m; };
    while (within_m < band_m && std::count_if(candidates.begin(), candidates.end(), is_within) < most()) {
      within_m = std::min(2.0 * within_m, band_m);
    }
    std::erase_if(candidates, [&](const ContactCandidate& c) { return !is_within(c); });
    keep_least();
  }

  /// Whether the finger has gone so far over the object since it was plainly looked at that another look may say
  /// something else.
  [[nodiscard]] bool has_moved() const {
    const FindingMemory& last = search.memory[finger];
    const double way_m = (X_OF * last.centre_m - last.X_SB * last.centre_m).norm();
    const double turn = (X_OF.linear() - last.X_SB.linear()).norm();
    return !(way_m + turn * last.radius_m < kStays * model.object.support_m());
  }

  void keep_least() {
    search.left_out.clear();
    keep_least_gaps(most(), search.candidates, &search.left_out);
  }

  /// Where on the surface a candidate is as it is deformed. False if that is the back of something round.
  [[nodiscard]] bool place(ContactCandidate& c) const {
    c.deformed_gap_m = c.gap_m;
    c.bend = model.object.bend(c.sample);
    c.is_beyond = false;
    if (!c.is_smooth && !is_round(c)) {
      c.is_beyond = faces_away(c);
      return true;
    }
    const Vector3d u = u_O(c.control_point);
    const double bend_per_m = std::max(std::abs(c.bend.k1_per_m), std::abs(c.bend.k2_per_m));
    if (bend_per_m < kFlat_per_m) {  // Its foot may be anywhere on the plane.
      c.deformed_gap_m -= u.dot(c.normal);
      c.is_beyond = faces_away(c);
      return true;
    }
    const Vector3d x_O = p_O(c.control_point) - u;
    if (!move_on_face(x_O, u, c) && !move_on_samples(x_O, u, c)) c.deformed_gap_m -= u.dot(c.normal);
    c.gap_m = c.deformed_gap_m + u.dot(c.normal);
    if (!is_round(c)) {
      c.is_beyond = faces_away(c);
      return true;
    }
    return c.normal.dot(normal_O(c.control_point)) <= 0.0;
  }

  /// Of an object that has exact faces, and away from their edges. The foot is that of x, or of where the point was a
  /// little before.
  [[nodiscard]] bool move_on_face(const Vector3d& x_O, const Vector3d& u, ContactCandidate& c) const {
    if (!model.exact) return false;
    HeldFoot& held = search.feet[finger][c.control_point];
    const double moved_m = (x_O - held.x_O).norm(), support_m = model.object.support_m();
    const bool is_held = moved_m < kHeld * support_m && moved_m * std::abs(held.at.k1_per_m) < kHeldTurn_rad &&
                         held.at.normal.dot(c.normal) > kSameFace;
    if (!is_held) {
      const double aside_m = (u - u.dot(c.normal) * c.normal).norm();
      const int face = face_at(*model.exact, c.point_m, c.normal, support_m + aside_m);
      const bool is_near = face == held.face && moved_m < support_m;
      const Vector3d near_m = is_near ? held.at.point_m : c.point_m;
      held = {x_O, face, {.normal = c.normal}};
      if (face >= 0) held.at = foot_on_face(*model.exact, face, x_O, near_m);
    }
    if (held.face < 0) return false;
    c.deformed_gap_m = height_over(held.at, x_O);
    c.point_m = held.at.point_m;
    c.normal = held.at.normal;
    c.bend = {held.at.t1, held.at.k1_per_m, held.at.k2_per_m};
    return true;
  }

  [[nodiscard]] bool move_on_samples(const Vector3d& x_O, const Vector3d& u, ContactCandidate& c) const {
    const double aside_m = (u - u.dot(c.normal) * c.normal).norm();
    const double bend_per_m = std::max(std::abs(c.bend.k1_per_m), std::abs(c.bend.k2_per_m));
    if (aside_m < kAside * model.object.support_m() || aside_m * bend_per_m < kTurn_rad) return false;
    const Index sample = nearest_sample(x_O, search.known_deformed[finger][c.control_point]);
    if (sample < 0) return false;
    const SurfaceDistance at = model.object.distance_from(x_O, sample);
    if (!at.is_smooth) return false;
    c.deformed_gap_m = at.distance_m;
    c.point_m = at.point_m;
    c.normal = at.normal;
    c.bend = model.object.bend(sample);
    return true;
  }

  [[nodiscard]] Index nearest_sample(const Vector3d& p_O, KnownSample& known) const {
    return find_nearest(model.object, p_O, depth_m + band_m, -1, known).sample;
  }

  /// Past a rim there is the plane of the face, and no object. Within a small way of it the depth is less in
  /// proportion, so that no force begins or ends at once.
  [[nodiscard]] bool is_on_object(const Vector3d& p_O, ContactCandidate& c) const {
    const double below_m = 0.125 * model.object.support_m();
    const Vector3d below_O = p_O - (c.gap_m + below_m) * c.normal;
    const Index sample = nearest_sample(below_O, search.known_below[finger][c.control_point]);
    if (sample < 0) return false;
    const double share = std::min(1.0, -model.object.distance_from(below_O, sample).distance_m / (0.8 * below_m));
    if (share <= 0.0) return false;
    if (c.gap_m < 0.0 && share < 1.0) {
      c.gap_m *= share;
      c.point_m = p_O - c.gap_m * c.normal;
    }
    return true;
  }

  /// A drawn-in point sees its face beside the foot of the point itself, and a curved face has turned on its way there.
  /// Past a rim, where there is no sample of the face, its plane goes on.
  void move_to_foot(const Vector3d& p_O, ContactCandidate& c) const {
    const Index sample = nearest_sample(p_O - c.gap_m * c.normal, search.known_foot[finger][c.control_point]);
    if (sample < 0 || model.object.cloud().normals.col(sample).dot(c.normal) < -kFarSide) return;
    const SurfaceDistance own = model.object.face_distance(p_O, sample);
    c.gap_m = own.distance_m;
    c.point_m = own.point_m;
    c.normal = own.normal;
    c.bend = model.object.bend(sample);
  }

  /// The points themselves, on the faces that the drawn-in ones see: none of those is beyond a wall's middle.
  void find_drawn_in() {
    std::vector<ContactCandidate>& candidates = search.candidates;
    const double reach_m = depth_m + band_m;
    find_contacts(search.drawn_in_m[finger], X_OF, model.object, {reach_m, reach_m + depth_m, pulp().controls()},
                  search.memory_drawn_in[finger], candidates);
    std::erase_if(candidates, [&](ContactCandidate& c) {
      const Vector3d p_O = this->p_O(c.control_point);
      c.bend = model.object.bend(c.sample);
      c.gap_m = c.normal.dot(p_O - c.point_m);
      if (c.gap_m >= reach_m || faces_away(c)) return true;
      move_to_foot(p_O, c);
      c.deformed_gap_m = c.gap_m;
      return c.gap_m >= band_m || !is_on_object(p_O, c);
    });
    keep_least();
  }
};

/// find_fine_samples() of a pulp that is no sphere.
bool find_fine_samples_of_shape(const Model& model, const Isometry3d& X_OF, int finger, double band_m,
                                ContactSearch& search) {
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
    if (!any) search.deepest.assign(pulp.controls(), -1);
    any = true;
    Index c = 0;
    (pulp.control_points_m.colwise() - place.point_m).colwise().squaredNorm().minCoeff(&c);
    Index& deepest = search.deepest[c];
    if (deepest < 0 || place.distance_m < nearest_place(tip, X_FO * model.fine_m.col(deepest)).distance_m) deepest = i;
  }
  return any;
}

/// For each control point the fine sample that is deepest in the pulp, or nearest to it within the band, among those
/// nearer to it than to other control points. False if there is none.
bool find_fine_samples(const Model& model, const Isometry3d& X_OF, int finger, double band_m, ContactSearch& search) {
  if (model.pulps[finger].shape) return find_fine_samples_of_shape(model, X_OF, finger, band_m, search);
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Pulp& pulp = model.pulps[finger];
  const Vector3d centre_O = X_OF * tip.centre_m;
  const double radius_m = tip.radius_m + band_m;
  bool any = false;
  for (Index i = 0; i < model.fine_m.cols(); ++i) {
    const Vector3d way_O = model.fine_m.col(i) - centre_O;
    const double squared = way_O.squaredNorm();
    if (squared >= radius_m * radius_m || squared == 0.0) continue;
    if (!any) search.deepest.assign(pulp.controls(), -1);
    any = true;
    Index c = 0;
    pulp.control_normals.lazyProduct(Vector3d(X_OF.linear().transpose() * way_O)).maxCoeff(&c);
    Index& deepest = search.deepest[c];
    if (deepest < 0 || squared < (model.fine_m.col(deepest) - centre_O).squaredNorm()) deepest = i;
  }
  return any;
}

/// Hands a finger's contacts to the frame, as many of least gap as there is room for.
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

/// The reverse pass: fine samples in the pulp, or near it, become contacts of the control points that they passed by,
/// unless those are deeper contacts themselves. The normal is the pulp's: a tip has none.
[[gnu::flatten]] void add_fine_contacts(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger,
                                        double band_m, ContactSearch& search, Frame& frame) {
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  if (!find_fine_samples(model, X_OF, finger, band_m, search)) return;
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d X_FO = X_OF.inverse();
  const auto gap_m = [&](const FrameContact& contact) { return contact_gap(contact, X_FO, Vector3d::Zero()).gap_m; };
  const auto first = frame.contacts.begin() + frame.begin[finger];
  search.contacts.assign(first, frame.contacts.end());
  frame.contacts.erase(first, frame.contacts.end());
  auto found = search.contacts.begin();
  const auto known = search.contacts.size();
  for (Index c = 0; c < std::ssize(search.deepest); ++c) {
    if (search.deepest[c] < 0) continue;
    const Vector3d s_O = model.fine_m.col(search.deepest[c]);
    const Vector3d s_F = X_FO * s_O;
    Vector3d n_F = (s_F - tip.centre_m).normalized(), p_F = tip.centre_m + tip.radius_m * n_F;
    if (tip.shape) {
      const PulpPlace place = nearest_place(tip, s_F);
      n_F = place.normal;
      p_F = place.point_m;
    }
    const FrameContact fine = frame_contact(tip, X_OF.linear(), finger, c, p_F, s_O, -(X_OF.linear() * n_F), {});
    const auto end = search.contacts.begin() + static_cast<std::ptrdiff_t>(known);
    while (found != end && found->control_point < c) ++found;
    if (found == end || found->control_point != c) {
      search.contacts.push_back(fine);
    } else if (gap_m(fine) < gap_m(*found)) {
      *found = fine;
    }
  }
  take_nearest(model, X_FO, search.contacts, frame);
}

/// What there was no room for.
void add_left_out(const Model& model, const Matrix3d& R_OF, int finger, const ContactSearch& search, Frame& frame) {
  const Pulp& pulp = model.pulps[finger];
  for (const ContactCandidate& c : search.left_out) {
    frame.left_out.push_back(frame_contact(model.scene.hand.fingertips[finger], R_OF, finger, c.control_point,
                                           pulp.control_points_m.col(c.control_point), c.point_m, c.normal, c.bend));
  }
}

void find_pulp_contacts(const Model& model, const HandPose& pose, const ContactSnapshot& snapshot, int finger,
                        double band_m, ContactSearch& search, Frame& frame) {
  const Isometry3d& X_WO = snapshot.X_WO;
  const double depth_m = kTrustPerRadius * model.scene.hand.fingertips[finger].radius_m;
  PulpSearch pulp{model,  snapshot, finger, X_WO.inverse() * pose.distal(model.scene.hand, finger),
                  band_m, depth_m,  search};
  // In a wall that is thinner than the press the plain look is dear, and only says when it may be gone back to.
  const bool looks = !search.draws_in[finger] || pulp.has_moved();
  if (looks) pulp.find();
  const bool beyond = looks && std::ranges::any_of(search.candidates, &ContactCandidate::is_beyond);
  const bool draws_in = beyond || search.draws_in[finger];
  // At an edge the two ways of looking differ: a finger goes back to the plain one where they agree, without a step.
  if (draws_in) {
    pulp.find_drawn_in();
    if (looks) {
      std::erase_if(search.plain, [&](const auto& c) { return c.gap_m >= band_m; });
      search.draws_in[finger] = beyond || !agree(search.plain, search.candidates);
    }
  }
  for (const ContactCandidate& c : search.candidates) {
    frame.contacts.push_back(frame_contact(model.scene.hand.fingertips[finger], pulp.X_OF.linear(), finger,
                                           c.control_point, pulp.pulp().control_points_m.col(c.control_point),
                                           c.point_m, c.normal, c.bend));
  }
  add_left_out(model, pulp.X_OF.linear(), finger, search, frame);
  const auto contacts = std::span<const FrameContact>(frame.contacts).subspan(frame.begin[finger]);
  if (!beyond && !search.draws_in[finger]) {
    frame.small[finger] = add_small_contacts(model, snapshot, pulp.X_OF, finger, band_m, contacts, search.small);
  }
  if (frame.small[finger]) {
    frame.contacts.resize(frame.begin[finger]);
    take_nearest(model, pulp.X_OF.inverse(), search.small.contacts, frame);
    return;
  }
  add_fine_contacts(model, pose, X_WO, finger, band_m, search, frame);
}

// A hollow that is hardly wider than the ball: less is as narrow to it.
constexpr double kLeastOffset = 0.1;

void find_point_contact(const Model& model, const HandPose& pose, const Isometry3d& X_WO, int finger, double band_m,
                        ContactSearch& search, Frame& frame) {
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const Isometry3d X_OF = X_WO.inverse() * pose.distal(model.scene.hand, finger);
  const PulpBall ball = touching_ball(tip, model.object, X_OF);
  const std::optional<SurfaceForm> nearest = nearest_surface(
      model, X_OF * ball.centre_m, ball.radius_m + band_m + model.object.support_m(), search.small.known[finger]);
  if (!nearest || nearest->distance_m - ball.radius_m >= band_m) return;
  const Vector3d n_F = X_OF.linear().transpose() * -nearest->normal;
  // The ball's centre goes over the surface that is offset by its radius; its contact, fixed in the finger, likewise.
  const auto offset = [&](double k_per_m) { return k_per_m / std::max(kLeastOffset, 1.0 + k_per_m * ball.radius_m); };
  frame.contacts.push_back(frame_contact(tip, X_OF.linear(), finger, 0, ball.centre_m + ball.radius_m * n_F,
                                         nearest->point_m, nearest->normal,
                                         {nearest->t1, offset(nearest->k1_per_m), offset(nearest->k2_per_m)}));
}

}  // namespace

ContactSearch::ContactSearch(const Model& model)
    : memory(model.fingers()),
      memory_drawn_in(model.fingers()),
      draws_in(model.fingers()),
      known_deformed(model.fingers()),
      feet(model.fingers()),
      known_foot(model.fingers()),
      known_below(model.fingers()),
      drawn_in_m(model.fingers()) {
  small.known = PerFinger<KnownSample>(model.fingers());
  if (!model.deformable()) return;
  const Index controls = model.pulps.front().controls();
  candidates.reserve(controls);
  left_out.reserve(controls);
  plain.reserve(controls);
  for (int k = 0; k < model.fingers(); ++k) {
    const Pulp& pulp = model.pulps[k];
    const double depth_m = kTrustPerRadius * model.scene.hand.fingertips[k].radius_m;
    drawn_in_m[k] = pulp.control_points_m - depth_m * pulp.control_normals.transpose();
    known_deformed[k].resize(controls);
    if (model.exact) feet[k].resize(controls);
    known_foot[k].resize(controls);
    known_below[k].resize(controls);
  }
  contacts.reserve(controls + model.scene.contact.max_per_finger);
  moved_m.resize(controls);
  small.cells.reserve(controls);
  small.contacts.reserve(controls);
  deepest.reserve(controls);
}

void find_frame_contacts(const Model& model, const HandPose& pose, const ContactSnapshot& snapshot,
                         ContactSearch& search, Frame& frame) {
  const PerFinger<double> travel_m = finger_travel_m(model, pose, snapshot, frame);
  frame.contacts.clear();
  frame.left_out.clear();
  for (int k = 0; k < model.fingers(); ++k) {
    frame.begin[k] = frame.size();
    frame.small[k] = {};
    const double band_m = model.scene.contact.band_m + travel_m[k];
    if (model.deformable()) {
      find_pulp_contacts(model, pose, snapshot, k, band_m, search, frame);
    } else {
      find_point_contact(model, pose, snapshot.X_WO, k, band_m, search, frame);
    }
  }
  frame.begin[model.fingers()] = frame.size();
}

}  // namespace thenar
