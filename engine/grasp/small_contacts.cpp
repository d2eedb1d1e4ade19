// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/small_contacts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// In spacings of control points: a patch that is narrower is Hertz's, a wider one is theirs. Lines of control points
// bear better than one of them, so that a long patch counts as wider than its lesser semi-axis.
constexpr double kNarrow = 0.65, kWide = 0.97;
// The object's curvature over the pulp's: what is flatter is left to whole cells, as coarse as they may be.
constexpr double kFlat = 0.5, kRound = 1.0;
// In radii of the object: a depth from which on it is a paraboloid for the most part, and all of it.
constexpr double kHangsOver = 0.5, kOverhangs = 1.1;
// A sharper place is an edge.
constexpr double kEdge_per_m = 1e4;
// A cell with less of its area in the patch bears nothing.
constexpr double kLeastShare = 1e-3;

double rise(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// The object where it is deepest in the pulp, in whose axes it is n z + t1 y1 + t2 y2 from there; object frame.
struct Patch {
  Vector3d s_O, n_O, t1, t2;
  Vector2d object_per_m;  ///< The object's curvatures along t1 and t2.
  Vector2d gap_per_m;     ///< And those of the gap.
  double depth_m = 0.0;
  SmallPatch is;

  [[nodiscard]] Vector2d aside(const Vector3d& x_O) const { return {t1.dot(x_O - s_O), t2.dot(x_O - s_O)}; }
  /// How far the undeformed bodies overlap there.
  [[nodiscard]] double depth_at(const Vector2d& y) const { return depth_m - 0.5 * gap_per_m.dot(y.cwiseAbs2()); }
  [[nodiscard]] Vector3d on_paraboloid(const Vector2d& y) const {
    return s_O + y[0] * t1 + y[1] * t2 - 0.5 * object_per_m.dot(y.cwiseAbs2()) * n_O;
  }
  /// The semi-axes of where they overlap by more than half of the most: Hertz's, of a ball.
  [[nodiscard]] Vector2d semi_axes_m() const { return (depth_m / gap_per_m.array()).sqrt(); }
};

/// A finger's pulp against the object.
struct PressedPulp {
  const Model& model;
  const Fingertip& tip;
  const Pulp& pulp;
  const Eigen::MatrixX3d& u_F;
  const Isometry3d& X_OF;

  [[nodiscard]] Vector3d u_O(Index c) const { return X_OF.linear() * u_F.row(c).transpose(); }

  /// How far the pulp is sheared along its surface where it faces along m (both object axes): a mean over the control
  /// points around.
  [[nodiscard]] Vector3d shear_O(const Vector3d& m_O) const {
    const Vector3d m_F = X_OF.linear().transpose() * m_O;
    const double spacing_m = std::sqrt(pulp.area_m2.mean()), widest = 2.25 * spacing_m * spacing_m;
    Vector3d sum = Vector3d::Zero();
    double weights = 0.0;
    for (Index c = 0; c < pulp.controls(); ++c) {
      const double squared_m2 = 2.0 * tip.radius_m * tip.radius_m * (1.0 - pulp.control_normals.row(c).dot(m_F));
      if (squared_m2 >= widest) continue;
      const double weight = std::pow(1.0 - squared_m2 / widest, 2);
      sum += weight * u_F.row(c).transpose();
      weights += weight;
    }
    if (!(weights > 0.0)) return sum;
    const Vector3d u_O = X_OF.linear() * sum / weights;
    return u_O - u_O.dot(m_O) * m_O;
  }

  /// Where the object is deepest in the ball that the pulp is like there, or will be as it goes on by `travel_m`.
  [[nodiscard]] std::optional<Patch> patch_of(const Vector3d& centre_O, double radius_m, double travel_m,
                                              KnownSample& known) const {
    const auto at = nearest_surface(model, centre_O, radius_m + travel_m + model.object.support_m(), known);
    if (!at || !(at->distance_m > 0.0)) return std::nullopt;  // None, or the ball's centre is in the object.
    const double depth_m = radius_m - at->distance_m, spacing_m = std::sqrt(pulp.area_m2.mean());
    Patch patch;
    patch.depth_m = depth_m + travel_m;
    patch.is = small_patch(*at, radius_m, spacing_m, patch.depth_m);
    if (!patch.is) return std::nullopt;
    patch.is.overhang = small_patch(*at, radius_m, spacing_m, depth_m).overhang;
    patch.s_O = at->point_m;
    patch.n_O = at->normal;
    patch.t1 = at->t1;
    patch.t2 = at->normal.cross(at->t1);
    patch.object_per_m = {at->k1_per_m, at->k2_per_m};
    patch.gap_per_m = relative_per_m(*at, radius_m);
    const double inside = share_inside(patch, known.sample, patch.semi_axes_m().maxCoeff() + spacing_m);
    patch.is.narrow *= inside;
    patch.is.overhang *= inside;
    return patch;
  }

  /// 1 of a patch that no edge is near to, within `near_m`; 0 at an edge.
  [[nodiscard]] double share_inside(const Patch& patch, Index sample, double near_m) const {
    if (!model.exact) return model.object.distance_from(patch.s_O, sample).is_smooth ? 1.0 : 0.0;
    constexpr int kSteps = 16;
    int steps = kSteps;
    while (steps > 0 && face_at(*model.exact, patch.s_O, patch.n_O, near_m * steps / kSteps) < 0) --steps;
    return rise(steps, 0.0, kSteps);
  }

  /// Whether the samples leave it open that a patch is small: most are not, and need no formula.
  [[nodiscard]] bool may_be_small(const Vector3d& centre_O, double radius_m, double travel_m,
                                  KnownSample& known) const {
    constexpr double kSure = 0.8;
    const double reach_m = radius_m + travel_m + model.object.support_m();
    const Index sample = find_nearest(model.object, centre_O, reach_m, known.sample, known).sample;
    if (sample < 0) return false;
    const SurfaceBend& bend = model.object.bend(sample);
    return std::max(bend.k1_per_m, bend.k2_per_m) * radius_m > kSure * kFlat;
  }

  /// The finger's patch, if it is small.
  [[nodiscard]] std::optional<Patch> patch(double travel_m, KnownSample& known) const {
    const PulpBall ball = touching_ball(tip, model.object, X_OF);
    const Vector3d centre_O = X_OF * ball.centre_m;
    if (!may_be_small(centre_O, ball.radius_m, travel_m, known)) return std::nullopt;
    const std::optional<Patch> at_rest = patch_of(centre_O, ball.radius_m, travel_m, known);
    if (!at_rest) return std::nullopt;
    return patch_of(centre_O - shear_O(-at_rest->n_O), ball.radius_m, travel_m, known);
  }

  /// How a control point lies on the patch as the pulp is sheared.
  [[nodiscard]] Vector2d aside(const Patch& patch, Index c) const {
    return patch.aside(X_OF * pulp.control_points_m.col(c) - u_O(c));
  }

  /// The place of the pulp's surface at rest that is nearest to a point beside it; distal frame.
  [[nodiscard]] Vector3d on_pulp(const Vector3d& x_F) const {
    if (tip.shape) return thenar::nearest_place(tip, x_F).point_m;
    return tip.centre_m + tip.radius_m * (x_F - tip.centre_m).normalized();
  }
};

/// The control points that face the object and may have a part of the patch.
void find_cells(const PressedPulp& pressed, const Patch& patch, std::vector<PatchCell>& cells) {
  const double cell_m = std::sqrt(pressed.pulp.area_m2.maxCoeff());
  const Vector2d far_m = patch.semi_axes_m() * std::numbers::sqrt2 + Vector2d::Constant(cell_m);
  const Vector3d inward_F = pressed.X_OF.linear().transpose() * patch.n_O;
  cells.clear();
  for (Index c = 0; c < pressed.pulp.controls(); ++c) {
    if (pressed.pulp.control_normals.row(c).dot(inward_F) >= 0.0) continue;
    const Vector2d y = pressed.aside(patch, c);
    if ((y.cwiseAbs().array() < far_m.array()).all()) cells.push_back({.control_point = c, .y = y});
  }
}

/// Gives every place of the patch to the control point next to it.
void share(const Patch& patch, std::span<PatchCell> cells) {
  constexpr int kPlaces = 128;
  // The rim of the patch is where the overlap is a half of the most; from 0.65 to 0.35 of it a place counts less and
  // less.
  constexpr double kRim = 0.15, kReach = 1.0 + 2.0 * kRim;
  const Vector2d reach_m = std::sqrt(kReach) * patch.semi_axes_m();
  const double place_m2 = std::numbers::pi * reach_m.prod() / kPlaces;
  for (int k = 0; k < kPlaces; ++k) {
    const double r = std::sqrt((k + 0.5) / kPlaces), angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * k;
    const Vector2d y = r * reach_m.cwiseProduct(Vector2d(std::cos(angle), std::sin(angle)));
    const double counts = std::clamp(0.5 + 0.5 * (patch.depth_at(y) / patch.depth_m - 0.5) / kRim, 0.0, 1.0);
    const auto next =
        std::ranges::min_element(cells, {}, [&](const PatchCell& cell) { return (cell.y - y).squaredNorm(); });
    next->share_m2 += counts * place_m2;
    next->moment_m3 += counts * place_m2 * (y - next->y);
  }
}

}  // namespace

std::optional<SurfaceForm> nearest_surface(const Model& model, const Vector3d& x_O, double reach_m,
                                           KnownSample& known) {
  const Index sample = find_nearest(model.object, x_O, reach_m, known.sample, known).sample;
  if (sample < 0) return std::nullopt;
  const SurfaceDistance at = model.object.distance_from(x_O, sample);
  if (model.exact) return nearest_place(*model.exact, x_O, at.point_m);
  const SurfaceBend& bend = model.object.bend(sample);
  return SurfaceForm{at.distance_m, at.point_m, at.normal, bend.t1, bend.k1_per_m, bend.k2_per_m};
}

void put_on_surface(const Vector3d& s_O, const Vector3d& n_O, const SurfaceBend& bend, const Fingertip& tip,
                    const Matrix3d& R_OF, FrameContact& contact) {
  contact.s_O = s_O;
  contact.n_O = -n_O;
  contact.E_F = contact_frame(tip.normal, R_OF.transpose() * contact.n_O);
  contact.t_O.setZero();
  contact.curvature_per_m = contact.ring_curvature_per_m = 0.0;
  const Vector3d across = bend.t1 - bend.t1.dot(n_O) * n_O;
  if (!(across.squaredNorm() > 0.5)) return;  // That of another face.
  contact.t_O = across.normalized();
  contact.curvature_per_m = bend.k1_per_m;
  contact.ring_curvature_per_m = bend.k2_per_m;
  if (std::abs(bend.k1_per_m) >= std::abs(bend.k2_per_m)) return;
  std::swap(contact.curvature_per_m, contact.ring_curvature_per_m);
  contact.t_O = contact.n_O.cross(contact.t_O);
}

FrameContact frame_contact(const Fingertip& tip, const Matrix3d& R_OF, int finger, Index control_point,
                           const Vector3d& p_F, const Vector3d& s_O, const Vector3d& n_O, const SurfaceBend& bend) {
  FrameContact contact;
  contact.finger = finger;
  contact.control_point = control_point;
  contact.p_F = p_F;
  put_on_surface(s_O, n_O, bend, tip, R_OF, contact);
  return contact;
}

Vector2d relative_per_m(const SurfaceForm& object, double radius_m) {
  return Vector2d(object.k1_per_m, object.k2_per_m).array() + 1.0 / radius_m;
}

SmallPatch small_patch(const SurfaceForm& object, double radius_m, double spacing_m, double depth_m) {
  const Vector2d gap_per_m = relative_per_m(object, radius_m);
  const double roundest_per_m = std::max(object.k1_per_m, object.k2_per_m);
  if (!(depth_m > 0.0 && gap_per_m.minCoeff() > 0.0) || roundest_per_m > kEdge_per_m) return {};
  const Vector2d axes_m = (depth_m / gap_per_m.array()).sqrt();
  const double width_m = std::pow(axes_m.minCoeff(), 0.75) * std::pow(axes_m.maxCoeff(), 0.25);
  return {(1.0 - rise(width_m / spacing_m, kNarrow, kWide)) * rise(roundest_per_m * radius_m, kFlat, kRound),
          rise(depth_m * roundest_per_m, kHangsOver, kOverhangs)};
}

SmallPatch add_small_contacts(const Model& model, const ContactSnapshot& snapshot, const Isometry3d& X_OF, int finger,
                              double band_m, std::span<const FrameContact> contacts, SmallContacts& small) {
  // Nothing flat is round, and the published kernel knows no areas.
  const bool is_flat = model.exact && thenar::is_flat(*model.exact);
  if (is_flat || model.pulps[finger].material.kernel == PulpKernel::kGaussian) return {};
  const PressedPulp pressed{model, model.scene.hand.fingertips[finger], model.pulps[finger], snapshot.u_m[finger],
                            X_OF};
  const std::optional<Patch> patch = pressed.patch(band_m - model.scene.contact.band_m, small.known[finger]);
  if (!patch || !patch->is) return {};
  const double reach_m = outer_radius_m(pressed.tip) + band_m;

  find_cells(pressed, *patch, small.cells);
  if (small.cells.empty()) return {};
  share(*patch, small.cells);

  std::vector<FrameContact>& all = small.contacts;
  all.clear();
  auto found = contacts.begin();
  for (const PatchCell& cell : small.cells) {
    const Index c = cell.control_point;
    while (found != contacts.end() && found->control_point < c) all.push_back(*found++);
    const bool is_known = found != contacts.end() && found->control_point == c;
    const FrameContact known = is_known ? *found++ : FrameContact{};
    if (known.fades()) {
      all.push_back(known);
      continue;
    }
    const double own_m2 = pressed.pulp.area_m2[c];
    // As an even pressure on a disc, whose middle goes as deep as Hertz's.
    constexpr double kOfDisc = 0.882;
    const double area_m2 = (1.0 - patch->is.narrow) * own_m2 + patch->is.narrow * kOfDisc * cell.share_m2;
    if (area_m2 < kLeastShare * own_m2 || (!is_known && cell.share_m2 < kLeastShare * own_m2)) continue;

    FrameContact contact = known;
    contact.finger = finger;
    contact.control_point = c;
    contact.area_m2 = area_m2;
    contact.p_F = pressed.pulp.control_points_m.col(c);
    if (patch->is.narrow > 0.0 && cell.share_m2 > 0.0) {
      const Vector2d off_m = patch->is.narrow / cell.share_m2 * cell.moment_m3;
      const Vector3d off_O = off_m[0] * patch->t1 + off_m[1] * patch->t2;
      contact.p_F = pressed.on_pulp(contact.p_F + X_OF.linear().transpose() * off_O);
    }
    const Vector3d x_O = X_OF * contact.p_F - pressed.u_O(c);
    Vector3d s_O = patch->on_paraboloid(patch->aside(x_O)), n_O = patch->n_O;
    SurfaceBend bend;
    const auto at = patch->is.overhang < 1.0 ? nearest_surface(model, x_O, reach_m, small.known[finger]) : std::nullopt;
    if (at) {
      s_O = (1.0 - patch->is.overhang) * at->point_m + patch->is.overhang * s_O;
      n_O = ((1.0 - patch->is.overhang) * at->normal + patch->is.overhang * n_O).normalized();
      bend = {at->t1, (1.0 - patch->is.overhang) * at->k1_per_m, (1.0 - patch->is.overhang) * at->k2_per_m};
    }
    put_on_surface(s_O, n_O, bend, pressed.tip, X_OF.linear(), contact);
    all.push_back(contact);
  }
  all.insert(all.end(), found, contacts.end());
  return patch->is;
}

}  // namespace thenar
