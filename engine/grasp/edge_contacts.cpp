#include "engine/grasp/edge_contacts.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/small_contacts.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

// In roots of a cell's area: an edge has a say within 1.13 of them.
constexpr double kNearEdge = 1.3;
// How far a cell is moved to see how it changes.
constexpr double kStep_m = 1e-6;
// A cell that looks at no face at less than 70 degrees (a cosine; cell_cover's kSteep) is not one that they press.
constexpr double kLooks = 0.35;
// What a cell's stiffness grows by on the way of a frame, at most, over itself.
constexpr double kMostGrowth = 0.5;
// Of a cell with less than this share nothing is pressed.
constexpr double kLeastPart = 1e-6;

/// The own stiffness of a part of a cell over the cell's, and how it grows with the part: a root, as k goes with one
/// over the root of an area, but where the part is so small that a root would rise without a bound.
struct PartStiffness {
  explicit PartStiffness(double share) {
    constexpr double kSmall = 0.15;
    const double under = share + kSmall * (1.0 - share);
    value = share / std::sqrt(under);
    slope = (under - 0.5 * (1.0 - kSmall) * share) / (under * std::sqrt(under));
  }
  double value, slope;
};

/// The face of a sample where x is over it.
FacePlane face_below(const Model& model, const Vector3d& x_O, Index sample) {
  const Vector3d s_O = model.object.cloud().points_m.col(sample);
  if (model.exact) {
    const int face = face_at(*model.exact, s_O, model.object.cloud().normals.col(sample), 0.0);
    if (face >= 0) {
      const SurfaceForm foot = foot_on_face(*model.exact, face, x_O, s_O);
      return {foot.normal, foot.point_m};
    }
  }
  const SurfaceDistance at = model.object.face_distance(x_O, sample);
  return {at.normal, at.point_m};
}

/// A cell's cover as its place moves.
struct CoverAt {
  const Model& model;
  const EdgeCell& cell;
  Vector3d b1, b2;
  Vector3d shear_O;  ///< What of u is across N.
  double area_m2;
  EdgeWork& work;

  /// With the control point at x.
  [[nodiscard]] CellCover operator()(const Vector3d& x_O) const {
    // Of samples the planes are those of the cell's first place: how they turn is less than their noise.
    const bool turn = model.exact && !is_flat(*model.exact);
    if (turn || work.planes.empty()) {
      work.planes.clear();
      work.planes.push_back(face_below(model, x_O - cell.u_O, cell.sample));
      for (const Index other : model.object.beside(cell.sample)) {
        work.planes.push_back(face_below(model, x_O - cell.u_O, other));
      }
    }
    work.faces.clear();
    for (const FacePlane& face : work.planes) {
      const double facing = -face.n.dot(cell.N_O);
      work.faces.push_back({.slope = {face.n.dot(b1), face.n.dot(b2)},
                            .facing = facing,
                            .height_m = face.n.dot(x_O - face.point_m),
                            .own_m = face.n.dot(shear_O) / facing});
    }
    return cell_cover(work.faces, area_m2, work.cells);
  }
};

}  // namespace

void find_edges(Model& model) {
  if (!model.deformable()) return;
  double cell_m2 = 0.0;
  for (const Pulp& pulp : model.pulps) cell_m2 = std::max(cell_m2, pulp.area_m2.maxCoeff());
  const double near_m = kNearEdge * std::sqrt(cell_m2) + model.object.support_m();
  if (!model.exact) {
    model.object.find_edges(near_m);
    return;
  }
  const auto face_of = [&](Index i) {
    return face_at(*model.exact, model.object.cloud().points_m.col(i), model.object.cloud().normals.col(i), 0.0);
  };
  model.object.find_edges(near_m, [&](Index i, Index j) {
    const int face = face_of(i);
    return face >= 0 && face == face_of(j);
  });
}

AtEdge edge_contact(const Model& model, const Isometry3d& X_OF, EdgeCell& cell, double softness, double band_m,
                    EdgeWork& work, FrameContact& contact) {
  const Pulp& pulp = model.pulps[cell.finger];
  const double own_m2 = pulp.area_m2[cell.control_point], pressed_m = cell.N_O.dot(cell.u_O);
  const Vector3d b1 = cell.N_O.unitOrthogonal(), b2 = cell.N_O.cross(b1);
  const CoverAt cover_at{model, cell, b1, b2, cell.u_O - pressed_m * cell.N_O, own_m2, work};
  work.planes.clear();
  const CellCover cover = cover_at(cell.p_O);
  if (cover.own == 1.0) {
    if (cover.main > 0) cell.sample = model.object.beside(cell.sample)[cover.main - 1];
    return AtEdge::kWhole;
  }
  const bool looks_at_it = std::ranges::any_of(work.faces, [](const CellFace& face) { return face.facing > kLooks; });
  const double deepest_m = kTrustPerRadius * pulp.radius_m + band_m;
  if (!looks_at_it || !(cover.depth_m > -band_m && cover.depth_m < deepest_m)) return AtEdge::kFree;
  if (cover.share < kLeastPart) return AtEdge::kFree;
  // How it changes, and its compliance, are those of the end of the way: taken at its begin, they would lag behind.
  const Vector3d end_O = cell.p_O + cell.way_O;
  const CellCover then = cell.way_O.isZero(0.0) ? cover : cover_at(end_O);
  if (then.share < kLeastPart) return AtEdge::kFree;
  // What u adds to N.u - d.
  Vector3d grows = cell.N_O;
  if (then.own > 0.0) {
    const CellFace& main = work.faces[then.main];
    grows -= then.own / main.facing * (main.slope[0] * b1 + main.slope[1] * b2);
  }
  Vector3d deepens, widens;
  for (int axis = 0; axis < 3; ++axis) {
    const CellCover moved = cover_at(end_O + kStep_m * Vector3d::Unit(axis));
    deepens[axis] = (moved.depth_m - then.depth_m) / kStep_m;
    widens[axis] = (moved.share - then.share) / kStep_m;
  }
  const double length = deepens.norm();
  if (!(length > 1e-3) || !std::isfinite(length)) return AtEdge::kFree;
  const PartStiffness stiffness(then.share);
  const double own = softness * pulp.kernel(cell.control_point, cell.control_point);
  const Vector3d n = deepens / length;
  contact.finger = cell.finger;
  contact.control_point = cell.control_point;
  contact.share = std::min(stiffness.value, 1.0 - 1e-12);
  // The force that makes it lean is that of the tick before, which was the cell's as it was. On a way on which the
  // cell's part grows out of all proportion, as where an edge comes in, no lean is good for all of it.
  const Vector3d stiffens = stiffness.slope / stiffness.value * widens;
  const double grown = std::clamp(1.0 + stiffens.dot(cell.way_O), 0.5, 2.0);
  const double bounded = std::min(1.0, kMostGrowth / std::max(1e-12, stiffens.norm() * cell.way_O.norm()));
  contact.lean_O = 0.5 * own / (stiffness.value * length * length) * grown * bounded * stiffens;
  contact.lean_m_per_N = contact.lean_O.dot(cell.way_O);
  const Vector3d middle_O = cell.p_O + cover.middle_m[0] * b1 + cover.middle_m[1] * b2;
  const double gap_m = (pressed_m - cover.depth_m) / length;
  contact.p_F = X_OF.inverse() * middle_O;
  contact.press = grows.norm() / length;
  const Vector3d s_O = middle_O + (gap_m - grows.dot(cell.u_O) / length) * n;
  const Fingertip& tip = model.scene.hand.fingertips[cell.finger];
  put_on_surface(s_O, -n, {}, tip, X_OF.linear(), contact);
  contact.E_F = contact_frame(tip.normal, X_OF.linear().transpose() * grows.normalized());
  return AtEdge::kCut;
}

}  // namespace thenar
