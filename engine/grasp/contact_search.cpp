#include "engine/grasp/contact_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "engine/grasp/edge_contacts.h"
#include "engine/grasp/finger_travel.h"
#include "engine/grasp/pulp_touch.h"
#include "engine/grasp/small_contacts.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// A face that the pulp there does not look at, to 60 degrees, is not the one that it came through, but the far side of
// something thin. On the face itself no point of a pulp within the trust looks further off.
constexpr double kFarSide = -0.5;
// What a face's normal turns by at most (a cosine's change) from the sample that is before a point to its foot.
constexpr double kTurned = 0.3;

// A sheared point has its own place on the surface looked for, where it has gone so many supports along it, and the
// normal turns by so much on that way.
constexpr double kAside = 0.05, kTurn_rad = 1e-3;
// A foot is held while its point goes no farther than this: then the torus there has the surface's normal to about the
// square of the turn, and its height to the cube of it.
constexpr double kHeld = 0.1, kHeldTurn_rad = 0.01;
// A thin wall has two faces.
constexpr double kSameFace = 0.5;

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
  /// surface: what is farther is not left out. Whether any is beyond the middle of something, with room or without.
  [[nodiscard]] bool find() {
    std::vector<ContactCandidate>& candidates = search.candidates;
    FindingMemory& memory = search.memory[finger];
    if (!memory.known.empty()) widen(widened(), memory);
    find_contacts(pulp().control_points_m, X_OF, model.object, {band_m, depth_m + band_m, pulp().controls()}, memory,
                  candidates);
    std::erase_if(candidates, [&](ContactCandidate& c) { return !place(c); });
    double within_m = model.scene.contact.band_m;
    const auto is_within = [&](const ContactCandidate& c) { return std::min(c.gap_m, c.deformed_gap_m) < within_m; };
    while (within_m < band_m && std::count_if(candidates.begin(), candidates.end(), is_within) < most()) {
      within_m = std::min(2.0 * within_m, band_m);
    }
    std::erase_if(candidates, [&](const ContactCandidate& c) { return !is_within(c); });
    const bool beyond = std::ranges::any_of(candidates, &ContactCandidate::is_beyond);
    keep_least();
    return beyond;
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
    // On a soft object feet are where loads act, and go on evenly.
    const bool is_held = !model.soft_object() && moved_m < kHeld * support_m &&
                         moved_m * std::abs(held.at.k1_per_m) < kHeldTurn_rad &&
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

  /// Whether a finger that has these candidates may have cells that an edge cuts.
  [[nodiscard]] bool is_at_edge() const {
    KnownSample& known = search.known_ball[finger];
    const auto is_beside = [&](Index sample) { return !model.object.beside(sample).empty(); };
    if (std::ranges::any_of(search.candidates, is_beside, &ContactCandidate::sample)) return true;
    // A tip or a rib may be between control points.
    const double reach_m = outer_radius_m(model.scene.hand.fingertips[finger]) + band_m;
    const Vector3d centre_O = X_OF * model.scene.hand.fingertips[finger].centre_m;
    for (Index i = 0; i < model.fine_edges_m.cols(); ++i) {
      if ((model.fine_edges_m.col(i) - centre_O).squaredNorm() < reach_m * reach_m) return true;
    }
    if (!search.candidates.empty() || model.object.bounds().exteriorDistance(centre_O) > reach_m) return false;
    const PulpBall ball = touching_ball(model.scene.hand.fingertips[finger], model.object, X_OF);
    const Index nearest =
        find_nearest(model.object, X_OF * ball.centre_m, ball.radius_m + band_m, known.sample, known).sample;
    return nearest >= 0 && is_beside(nearest);
  }

  /// A control point against the face of a sample; of an exact face place() finds the foot.
  [[nodiscard]] ContactCandidate on_face(Index c, Index sample) const {
    const Vector3d p = p_O(c), s = model.object.cloud().points_m.col(sample);
    const Vector3d n = model.object.cloud().normals.col(sample);
    if (model.exact && face_at(*model.exact, s, n, 0.0) >= 0) return {c, n.dot(p - s), p - n.dot(p - s) * n, n, sample};
    const SurfaceDistance face = model.object.face_distance(p, sample);
    return {c, face.distance_m, face.point_m, face.normal, sample};
  }

  /// The contact of a cell that no edge cuts, with the face of this sample: the one that was found, if it is of that
  /// face.
  [[nodiscard]] std::optional<ContactCandidate> whole_cell(Index c, Index sample, const ContactCandidate* found) const {
    const Vector3d n = model.object.cloud().normals.col(sample);
    if (found && found->is_smooth && !found->is_beyond && found->normal.dot(n) > kSameFace) return *found;
    // The face that is before it, unless that is seen from behind.
    if (n.dot(normal_O(c)) > kFarSide + kTurned) return std::nullopt;
    ContactCandidate whole = on_face(c, sample);
    if (!place(whole) || std::min(whole.gap_m, whole.deformed_gap_m) >= band_m) return std::nullopt;
    // What is farther in is seen from the pulp's other side.
    if (whole.gap_m < -model.scene.hand.fingertips[finger].radius_m) return std::nullopt;
    return whole;
  }

  /// How often a finger will have gone the way since the last frame again, when this frame is half used.
  [[nodiscard]] double ways_to_go() const {
    const auto ticks = static_cast<double>(snapshot.tick - search.tick_then);
    const bool is_next =
        search.tick_then >= 0 && ticks > 0.0 && ticks * model.scene.step_s < 2.5 * model.scene.control_period_s;
    return is_next ? 0.5 * (ticks + 1.0) / ticks + model.scene.control_delay_s / (ticks * model.scene.step_s) : 0.0;
  }

  /// Sees the object along the normals of the pulp, from its inside, where no face of the object hides another: each
  /// control point touches the face before it, from whichever side it came, and cells at edges what is in them.
  void find_along_normals() {
    const Pulp& pulp = this->pulp();
    const PulpBall ball = touching_ball(model.scene.hand.fingertips[finger], model.object, X_OF);
    const std::optional<SurfaceForm> nearest = nearest_surface(
        model, X_OF * ball.centre_m, ball.radius_m + band_m + model.object.support_m(), search.known_ball[finger]);
    if (!nearest) return;
    const double back_m = std::clamp(ball.radius_m - nearest->distance_m, 0.0, depth_m);
    const double reach_m = back_m + band_m + model.object.support_m() + std::sqrt(pulp.area_m2[0]);
    const double softness = thenar::softness(pulp.material, snapshot.load[finger].normal_N);
    const Isometry3d& X_then = search.X_OF_then[finger];
    const double ways = ways_to_go();
    auto found = search.candidates.begin();
    for (Index c = 0; c < pulp.controls(); ++c) {
      while (found != search.candidates.end() && found->control_point < c) ++found;
      const bool is_found = found != search.candidates.end() && found->control_point == c;
      EdgeCell cell{finger, c, p_O(c), normal_O(c), u_O(c)};
      const Vector3d before_O = cell.p_O - back_m * cell.N_O;
      if (ways > 0.0) cell.way_O = ways * (cell.p_O - X_then * pulp.control_points_m.col(c));
      cell.sample = find_nearest(model.object, before_O, reach_m, -1, search.known_before[finger][c]).sample;
      if (cell.sample < 0) continue;
      FrameContact contact;
      const AtEdge is = model.object.beside(cell.sample).empty()
                            ? AtEdge::kWhole
                            : edge_contact(model, X_OF, cell, softness, band_m, search.edges, contact);
      if (is == AtEdge::kWhole) {
        const auto whole = whole_cell(c, cell.sample, is_found ? &*found : nullptr);
        if (!whole || whole->is_beyond) continue;
        contact = frame_contact(model.scene.hand.fingertips[finger], X_OF.linear(), finger, c,
                                pulp.control_points_m.col(c), whole->point_m, whole->normal, whole->bend);
      } else if (is == AtEdge::kFree) {
        continue;
      }
      search.contacts.push_back(contact);
    }
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
  const Fingertip& tip = model.scene.hand.fingertips[finger];
  const double depth_m = kTrustPerRadius * tip.radius_m;
  PulpSearch pulp{model,  snapshot, finger, X_WO.inverse() * pose.distal(model.scene.hand, finger),
                  band_m, depth_m,  search};
  const bool beyond = pulp.find();
  if (beyond || pulp.is_at_edge()) {
    search.contacts.clear();
    pulp.find_along_normals();
    take_nearest(model, pulp.X_OF.inverse(), search.contacts, frame);
  } else {
    for (const ContactCandidate& c : search.candidates) {
      frame.contacts.push_back(frame_contact(tip, pulp.X_OF.linear(), finger, c.control_point,
                                             pulp.pulp().control_points_m.col(c.control_point), c.point_m, c.normal,
                                             c.bend));
    }
    add_left_out(model, pulp.X_OF.linear(), finger, search, frame);
  }
  const auto contacts = std::span<const FrameContact>(frame.contacts).subspan(frame.begin[finger]);
  if (!beyond) {
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
      known_deformed(model.fingers()),
      feet(model.fingers()),
      known_before(model.fingers()),
      known_ball(model.fingers()),
      X_OF_then(model.fingers(), Isometry3d::Identity()) {
  small.known = PerFinger<KnownSample>(model.fingers());
  if (!model.deformable()) return;
  const Index controls = model.pulps.front().controls();
  candidates.reserve(controls);
  left_out.reserve(controls);
  for (int k = 0; k < model.fingers(); ++k) {
    known_deformed[k].resize(controls);
    if (model.exact) feet[k].resize(controls);
    known_before[k].resize(controls);
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
  for (int k = 0; k < model.fingers(); ++k) {
    search.X_OF_then[k] = snapshot.X_WO.inverse() * pose.distal(model.scene.hand, k);
  }
  search.tick_then = snapshot.tick;
}

}  // namespace thenar
