// SPDX-License-Identifier: Apache-2.0
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
// A contact is held while its point goes no farther than this, in supports, and the surface's normal turns by no more,
// on an exact face or on samples: then the torus there has the surface's normal to about the square of the turn, where
// its curvature is exact.
constexpr double kHeldOnFace = 0.1, kHeldTurnOnFace_rad = 0.01, kHeld = kAside, kHeldTurn_rad = kTurn_rad;
// It is forgotten this far off, in bands: at one it would come and go.
constexpr double kHeldBands = 2.0;
// A thin wall has two faces.
constexpr double kSameFace = 0.5;

// Less than this is flat: 5 nm lower a millimetre off.
constexpr double kFlat_per_m = 0.01;

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

  /// True if the pulp's normal there and the surface's outward normal have at most this cosine.
  [[nodiscard]] bool faces(Index c, const Vector3d& normal, double largest_cosine) const {
    return normal.dot(normal_O(c)) <= largest_cosine;
  }
  /// See NearPoint.
  [[nodiscard]] bool is_beyond(Index c, const Vector3d& normal, bool is_round) const {
    return !is_round && !faces(c, normal, kFarSide);
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
    FindingMemory& memory = search.memory[finger];
    if (!memory.known.empty()) widen(widened(), memory);
    held().reserve(pulp().controls());  // A copy has room for what it holds alone.
    const bool all_hold = look_again(memory);
    find_contacts(pulp().control_points_m, X_OF, model.object, {band_m, depth_m + band_m, pulp().controls()}, memory,
                  search.candidates);
    if (!all_hold || !search.candidates.empty()) merge(memory);
    choose_near();
    return std::ranges::any_of(search.near, &NearPoint::is_beyond);
  }

  [[nodiscard]] std::vector<HeldContact>& held() const { return search.held[finger]; }

  [[nodiscard]] NearPoint near_point(const HeldContact& held, const Vector3d& p_O, const Vector3d& x_O) const {
    const FrameContact& contact = held.contact;
    const Vector3d way = x_O - held.x_O;
    const double over = contact.n_O.dot(way), along = contact.t_O.dot(way);
    const double across2 = way.squaredNorm() - over * over - along * along;
    const double bent_m = 0.5 * (contact.curvature_per_m * along * along + contact.ring_curvature_per_m * across2);
    const double deformed_gap_m = held.deformed_gap_m - over + bent_m;
    const double gap_m = held.gap_m - contact.n_O.dot(p_O - held.p_O) + bent_m;
    const bool is_hidden = is_beyond(contact.control_point, -contact.n_O, held.is_round);
    return {gap_m, std::min(gap_m, deformed_gap_m), is_hidden, &held};
  }

  /// Finds where the held contacts are near. Marks those that hold no longer, and wakes their control points: false if
  /// there are any.
  [[nodiscard]] bool look_again(FindingMemory& memory) const {
    bool all = true;
    search.near.clear();
    for (HeldContact& held : this->held()) {
      const Index c = held.contact.control_point;
      const Vector3d p = p_O(c), u = u_O(c), x = p - u;
      search.near.push_back(near_point(held, p, x));
      const double free_m2 = held.free_m * held.free_m;
      const bool is_seen = !held.is_round || faces(c, -held.contact.n_O, 0.0);
      if ((p - held.p_O).squaredNorm() < free_m2 && (x - held.x_O).squaredNorm() < free_m2 && is_seen &&
          search.near.back().least_m < kHeldBands * (band_m + u.norm())) {
        continue;
      }
      held.free_m = -1.0;
      wake(c, memory);
      all = false;
    }
    return all;
  }

  /// Puts the candidates among the contacts that hold, and forgets what holds no longer.
  void merge(FindingMemory& memory) const {
    auto at = held().begin();
    bool in_place = true;
    for (ContactCandidate& candidate : search.candidates) {
      const Index c = candidate.control_point;
      while (at != held().end() && at->contact.control_point < c) ++at;
      const bool is_known = at != held().end() && at->contact.control_point == c;
      int face = -1;
      if (!place(candidate, is_known ? &*at : nullptr, face)) continue;
      const HeldContact made{
          frame_contact(model.scene.hand.fingertips[finger], X_OF.linear(), finger, c, pulp().control_points_m.col(c),
                        candidate.point_m, candidate.normal, candidate.bend),
          p_O(c),
          p_O(c) - u_O(c),
          candidate.gap_m,
          candidate.deformed_gap_m,
          free_m(candidate),
          candidate.sample,
          face,
          candidate.is_smooth,
          is_round(candidate)};
      if (is_known) {
        *at = made;
      } else {
        at = held().insert(at, made);
        in_place = false;
      }
      if (at->free_m > 0.0) let_sleep(c, memory);
      if (in_place) search.near[at - held().begin()] = near_point(*at, at->p_O, at->x_O);
    }
    const auto forgotten = std::erase_if(held(), [](const HeldContact& one) { return one.free_m < 0.0; });
    if (in_place && forgotten == 0) return;
    search.near.clear();
    for (const HeldContact& one : held()) {
      const Vector3d p = p_O(one.contact.control_point);
      search.near.push_back(near_point(one, p, p - u_O(one.contact.control_point)));
    }
  }

  /// How far a candidate's point may go until its contact no longer holds.
  [[nodiscard]] double free_m(const ContactCandidate& c) const {
    // What a plane would be off by: of this the torus knows the most.
    const double error_m = model.scene.contact.distance_error_m;
    // On a soft object contacts are where loads act, and go on evenly.
    if (!c.is_smooth || model.soft_object() || !(error_m > 0.0)) return 0.0;
    const bool on_face = model.exact.has_value();
    const double bend_per_m = std::max(kFlat_per_m, c.bend.most_per_m());
    return std::min({(on_face ? kHeldOnFace : kHeld) * model.object.support_m(),
                     (on_face ? kHeldTurnOnFace_rad : kHeldTurn_rad) / bend_per_m,
                     std::sqrt(2.0 * error_m / bend_per_m)});
  }

  /// Sorts out the points in the band, those first that there is room for.
  void choose_near() const {
    std::vector<NearPoint>& near = search.near;
    double within_m = model.scene.contact.band_m;
    const auto is_within = [&](const NearPoint& point) { return point.least_m < within_m; };
    while (within_m < band_m && std::ranges::count_if(near, is_within) < most()) {
      within_m = std::min(2.0 * within_m, band_m);
    }
    std::erase_if(near, [&](const NearPoint& point) { return !is_within(point); });
    search.room = static_cast<std::size_t>(std::min(std::ssize(near), most()));
    const auto end = near.begin() + static_cast<std::ptrdiff_t>(search.room);
    if (end == near.end()) return;
    std::nth_element(near.begin(), end, near.end());
    std::sort(near.begin(), end, [](const NearPoint& a, const NearPoint& b) { return a.held < b.held; });
  }

  [[nodiscard]] std::span<const NearPoint> with_room() const { return std::span(search.near).first(search.room); }
  [[nodiscard]] std::span<const NearPoint> without_room() const { return std::span(search.near).subspan(search.room); }

  /// Sets the axes that a held contact has now.
  void set_axes(FrameContact& contact) const {
    contact.E_F = contact_frame(model.scene.hand.fingertips[finger].normal, X_OF.linear().transpose() * contact.n_O);
  }

  /// Where on the surface a candidate is as it is deformed. False if that is the back of something round.
  /// `then` is its contact of the frame before, if any; `face` is set to the exact face that it is on.
  [[nodiscard]] bool place(ContactCandidate& c, const HeldContact* then, int& face) const {
    c.deformed_gap_m = c.gap_m;
    c.bend = model.object.bend(c.sample);
    if (!c.is_smooth && !is_round(c)) return true;
    const Vector3d u = u_O(c.control_point);
    const double bend_per_m = std::max(std::abs(c.bend.k1_per_m), std::abs(c.bend.k2_per_m));
    if (bend_per_m < kFlat_per_m) {  // Its foot may be anywhere on the plane.
      c.deformed_gap_m -= u.dot(c.normal);
      return true;
    }
    const Vector3d x_O = p_O(c.control_point) - u;
    if (!move_on_face(x_O, u, then, c, face) && !move_on_samples(x_O, u, c)) c.deformed_gap_m -= u.dot(c.normal);
    c.gap_m = c.deformed_gap_m + u.dot(c.normal);
    return !is_round(c) || faces(c.control_point, c.normal, 0.0);
  }

  /// Of an object that has exact faces, and away from their edges.
  [[nodiscard]] bool move_on_face(const Vector3d& x_O, const Vector3d& u, const HeldContact* then, ContactCandidate& c,
                                  int& face) const {
    if (!model.exact) return false;
    const double support_m = model.object.support_m(), aside_m = (u - u.dot(c.normal) * c.normal).norm();
    face = face_at(*model.exact, c.point_m, c.normal, support_m + aside_m);
    if (face < 0) return false;
    const bool is_near = then != nullptr && then->face == face && (x_O - then->x_O).norm() < support_m;
    const SurfaceForm at = foot_on_face(*model.exact, face, x_O, is_near ? then->contact.s_O : c.point_m);
    c.deformed_gap_m = at.distance_m;
    c.point_m = at.point_m;
    c.normal = at.normal;
    c.bend = {at.t1, at.k1_per_m, at.k2_per_m};
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
    const auto is_near_edge = [&](const NearPoint& near) { return is_beside(near.held->sample); };
    if (std::ranges::any_of(with_room(), is_near_edge)) return true;
    // A tip or a rib may be between control points.
    const double reach_m = outer_radius_m(model.scene.hand.fingertips[finger]) + band_m;
    const Vector3d centre_O = X_OF * model.scene.hand.fingertips[finger].centre_m;
    for (Index i = 0; i < model.fine_edges_m.cols(); ++i) {
      if ((model.fine_edges_m.col(i) - centre_O).squaredNorm() < reach_m * reach_m) return true;
    }
    if (search.room > 0 || model.object.bounds().exteriorDistance(centre_O) > reach_m) return false;
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
  [[nodiscard]] std::optional<FrameContact> whole_cell(Index c, Index sample, const NearPoint* found) const {
    const Vector3d n = model.object.cloud().normals.col(sample);
    if (found && found->held->is_smooth && !found->is_beyond && found->held->contact.n_O.dot(n) < -kSameFace) {
      FrameContact contact = found->held->contact;
      set_axes(contact);
      return contact;
    }
    // The face that is before it, unless that is seen from behind.
    if (n.dot(normal_O(c)) > kFarSide + kTurned) return std::nullopt;
    ContactCandidate whole = on_face(c, sample);
    int face = -1;
    if (!place(whole, nullptr, face) || is_beyond(c, whole.normal, is_round(whole)) ||
        std::min(whole.gap_m, whole.deformed_gap_m) >= band_m) {
      return std::nullopt;
    }
    // What is farther in is seen from the pulp's other side.
    if (whole.gap_m < -model.scene.hand.fingertips[finger].radius_m) return std::nullopt;
    return frame_contact(model.scene.hand.fingertips[finger], X_OF.linear(), finger, c, pulp().control_points_m.col(c),
                         whole.point_m, whole.normal, whole.bend);
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
    auto found = with_room().begin();
    for (Index c = 0; c < pulp.controls(); ++c) {
      while (found != with_room().end() && found->control_point() < c) ++found;
      const bool is_found = found != with_room().end() && found->control_point() == c;
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
        const std::optional<FrameContact> whole = whole_cell(c, cell.sample, is_found ? &*found : nullptr);
        if (!whole) continue;
        contact = *whole;
      } else if (is == AtEdge::kFree) {
        continue;
      }
      search.contacts.push_back(contact);
    }
  }
};

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
    for (const NearPoint& near : pulp.with_room()) pulp.set_axes(frame.contacts.emplace_back(near.held->contact));
    for (const NearPoint& near : pulp.without_room()) frame.left_out.push_back(near.held->contact);
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
  add_fine_contacts(model, pose, X_WO, finger, band_m, search.fine, frame);
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
      held(model.fingers()),
      known_before(model.fingers()),
      known_ball(model.fingers()),
      X_OF_then(model.fingers(), Isometry3d::Identity()) {
  small.known = PerFinger<KnownSample>(model.fingers());
  if (!model.deformable()) return;
  const Index controls = model.pulps.front().controls();
  candidates.reserve(controls);
  near.reserve(controls);
  for (int k = 0; k < model.fingers(); ++k) {
    known_deformed[k].resize(controls);
    held[k].reserve(controls);
    known_before[k].resize(controls);
  }
  contacts.reserve(controls + model.scene.contact.max_per_finger);
  moved_m.resize(controls);
  small.cells.reserve(controls);
  small.contacts.reserve(controls);
  fine.deepest.reserve(controls);
  fine.contacts.reserve(controls + model.scene.contact.max_per_finger);
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
