// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/edge_contacts.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/grasp/small_contacts.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// In roots of a cell's area: an edge has a say within 1.13 of them.
constexpr double kNearEdge = 1.3;
// How far a cell is moved to see how it changes.
constexpr double kStep_m = 1e-6;
// In roots of a cell's area: what is expected to be gone in a frame counts no farther.
constexpr double kFarthest = 0.1;
// What a cell's stiffness grows by on the way of a frame, at most, over itself.
constexpr double kMostGrowth = 0.5;
// Friction may shear a pulp by more than a cell. Then what a cell's depth grows by as its face goes over into a part is
// not all told.
constexpr double kMostSlope = 2.5;
// A cosine: what a cell that comes along N reaches.
constexpr double kStraight = 0.5;
// Of a cell with less than this share nothing is pressed.
constexpr double kLeastPart = 1e-6;

bool is_reached(const CellCover& cover) { return cover.depth_m > 0.0 && cover.share >= kLeastPart; }

/// The own stiffness of a part of a cell over the cell's: a root of its share, as k goes with one over the root of an
/// area, but where the part is so small that a root would rise without a bound. A part aside of the cell's middle is
/// the softer: it is nearer to those of the next cells than the middles of both are, by which they know of each other.
double part_stiffness(const CellCover& cover, double area_m2) {
  constexpr double kSmall = 0.15, kOffMiddle = 3.0;
  const double under = cover.share + kSmall * (1.0 - cover.share);
  return cover.share / (std::sqrt(under) * (1.0 + kOffMiddle * cover.middle_m.squaredNorm() / area_m2));
}

/// The face of a sample where x is over it; where there is a plane of that face already, as of a thin rod that is seen
/// from its end, at the sample.
FacePlane face_below(const Model& model, const Vector3d& x_O, Index sample, std::span<const FacePlane> known) {
  const Vector3d s_O = model.object.cloud().points_m.col(sample);
  if (model.exact) {
    const int face = face_at(*model.exact, s_O, model.object.cloud().normals.col(sample), 0.0);
    if (face >= 0) {
      const bool is_known = std::ranges::find(known, face, &FacePlane::face) != known.end();
      const SurfaceForm foot = foot_on_face(*model.exact, face, is_known ? s_O : x_O, s_O);
      return {foot.normal, foot.point_m, face};
    }
  }
  const SurfaceDistance at = model.object.face_distance(x_O, sample);
  return {at.normal, at.point_m, -1};
}

/// The slope of a depth that the pulp's shear makes steep, as an edge comes: as much of what shear adds as leaves it at
/// kMostSlope.
Vector3d bounded(const Vector3d& slope, const Vector3d& unsheared) {
  const double a = (slope - unsheared).squaredNorm(), b = unsheared.dot(slope - unsheared),
               c = unsheared.squaredNorm() - kMostSlope * kMostSlope;
  return c < 0.0 ? Vector3d(unsheared + (std::sqrt(b * b - a * c) - b) / a * (slope - unsheared)) : unsheared;
}

/// A cell, the faces next to it, and what covers it where it moves.
struct Cell {
  Cell(const Model& model, const EdgeCell& of, EdgeWork& in) : at(of), pulp(model.pulps[of.finger]), work(in) {
    // The planes stay those where it is as it is deformed: of a rim that bends, its forces are across that part of it.
    const Vector3d x_O = at.p_O - at.u_O;
    work.planes.clear();
    work.planes.push_back(face_below(model, x_O, at.sample, {}));
    for (const Index other : model.object.beside(at.sample)) {
      work.planes.push_back(face_below(model, x_O, other, work.planes));
    }
    work.faces.clear();
    for (const FacePlane& face : work.planes) {
      const double facing = -face.n.dot(at.N_O);
      work.faces.push_back({.slope = {face.n.dot(b1), face.n.dot(b2)},
                            .facing = facing,
                            .own_m = face.n.dot(at.u_O - pressed_m * at.N_O) / facing});
    }
  }

  [[nodiscard]] CellCover cover_after(const Vector3d& way_O) const {
    for (std::size_t i = 0; i < work.faces.size(); ++i) {
      work.faces[i].height_m = work.planes[i].n.dot(at.p_O + way_O - work.planes[i].point_m);
    }
    return cell_cover(work.faces, area_m2, work.cells);
  }

  /// What its depth and its stiffness grow by as it moves on from there.
  struct Slopes {
    Vector3d depth, stiffness_per_m;
  };
  [[nodiscard]] Slopes slopes(const Vector3d& way_O, const CellCover& there) const {
    Slopes slopes;
    const double stiffness = part_stiffness(there, area_m2);
    for (int axis = 0; axis < 3; ++axis) {
      const CellCover moved = cover_after(way_O + kStep_m * Vector3d::Unit(axis));
      slopes.depth[axis] = (moved.depth_m - there.depth_m) / kStep_m;
      slopes.stiffness_per_m[axis] = (part_stiffness(moved, area_m2) - stiffness) / kStep_m;
    }
    return slopes;
  }

  /// That of its depth as if the pulp were not sheared. Afterwards its faces are so, too.
  [[nodiscard]] Vector3d slope_unsheared(const Vector3d& way_O) const {
    for (CellFace& face : work.faces) face.own_m = 0.0;
    return slopes(way_O, cover_after(way_O)).depth;
  }

  /// Whether it is one that some face presses.
  [[nodiscard]] bool looks_at_one() const {
    return std::ranges::any_of(work.faces, [](const CellFace& face) { return face.facing > kSteep; });
  }

  /// What u adds to N.u - d.
  [[nodiscard]] Vector3d grows(const CellCover& cover) const {
    if (cover.own == 0.0) return at.N_O;
    const CellFace& main = work.faces[cover.main];
    return at.N_O - cover.own / main.facing * (main.slope[0] * b1 + main.slope[1] * b2);
  }

  const EdgeCell& at;
  const Pulp& pulp;
  EdgeWork& work;
  double area_m2 = pulp.area_m2[at.control_point], pressed_m = at.N_O.dot(at.u_O);
  Vector3d b1 = at.N_O.unitOrthogonal(), b2 = at.N_O.cross(b1);
};

/// The own compliances of a whole cell, of the pulp and of a soft object [m/N].
struct OwnCompliance {
  double pulp, object;
};

/// The contact of a cell that an edge cuts, which `now` covers, and `then` after the way. False where its depth does
/// not change as it moves.
bool cut_contact(const Cell& cell, const CellCover& now, const CellCover& then, const Vector3d& way_O,
                 const OwnCompliance& own, const Fingertip& tip, const Isometry3d& X_OF, FrameContact& contact) {
  auto [deepens, stiffer_per_m] = cell.slopes(way_O, then);
  if (!(deepens.norm() > 1e-3) || !deepens.allFinite()) return false;
  const bool is_in = is_reached(now);
  // What would be reached from aside is not seen along N.
  if (!is_in && deepens.dot(cell.at.N_O) < kStraight * deepens.norm()) return false;
  if (deepens.norm() > kMostSlope) deepens = bounded(deepens, cell.slope_unsheared(way_O));
  const double length = deepens.norm();
  const double stiffness = part_stiffness(then, cell.area_m2);
  const Vector3d n = deepens / length, grows = cell.grows(then);
  contact.finger = cell.at.finger;
  contact.control_point = cell.at.control_point;
  contact.share = std::min(stiffness, 1.0 - 1e-12);
  contact.covered = then.share;
  contact.lean_O.setZero();
  contact.lean_m_per_N = 0.0;
  if (is_in) {
    // The force that makes it lean is that of the tick before, which was the cell's as it was. On a way on which the
    // cell's part grows out of all proportion, as where an edge comes in, no lean is good for all of it.
    const Vector3d stiffens = stiffer_per_m / stiffness;
    const double grown = std::clamp(1.0 + stiffens.dot(way_O), 0.5, 2.0);
    const double bounded = std::min(1.0, kMostGrowth / std::max(1e-12, stiffens.norm() * way_O.norm()));
    const double gives_m_per_N = (own.pulp / (length * length) + own.object) / stiffness;
    contact.lean_O = 0.5 * gives_m_per_N * grown * bounded * stiffens;
    contact.lean_m_per_N = contact.lean_O.dot(way_O);
  }
  const Vector2d& of_part_m = (is_in ? now : then).middle_m;
  const Vector3d middle_O = cell.at.p_O + of_part_m[0] * cell.b1 + of_part_m[1] * cell.b2;
  // What is to be reached has the gap that closes there.
  const double depth_m = is_in ? now.depth_m : then.depth_m - deepens.dot(way_O);
  const double gap_m = (cell.pressed_m - depth_m) / length;
  contact.p_F = X_OF.inverse() * middle_O;
  contact.press = grows.norm() / length;
  const Vector3d s_O = middle_O + (gap_m - grows.dot(cell.at.u_O) / length) * n;
  put_on_surface(s_O, -n, {}, tip, X_OF.linear(), contact);
  contact.E_F = contact_frame(tip.normal, X_OF.linear().transpose() * grows.normalized());
  return true;
}

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

bool has_edges_for_cells(const Model& model, Index sample) {
  const auto beside = model.object.beside(sample);
  if (beside.empty()) return false;
  const auto normal = [&](Index i) { return model.object.cloud().normals.col(i); };
  Vector3d mean = normal(sample);
  for (const Index other : beside) mean += normal(other);
  mean.normalize();
  const auto is_seen = [&](Index i) { return normal(i).dot(mean) > kSteep; };
  return is_seen(sample) || std::ranges::any_of(beside, is_seen);
}

AtEdge edge_contact(const Model& model, const Isometry3d& X_OF, EdgeCell& of, double softness, double band_m,
                    EdgeWork& work, FrameContact& contact) {
  const Cell cell(model, of, work);
  const auto take_whole = [&](std::size_t main) {
    if (main > 0) of.sample = model.object.beside(of.sample)[main - 1];
    return AtEdge::kWhole;
  };
  const CellCover now = cell.cover_after(Vector3d::Zero());
  if (now.own == 1.0) return take_whole(now.main);
  const Fingertip& tip = model.scene.hand.fingertips[of.finger];
  // What a point sees farther in than the pulp's radius is seen from the pulp's other side.
  if (!cell.looks_at_one() || !(now.depth_m > -band_m && now.depth_m < tip.radius_m)) return AtEdge::kFree;
  const double most_m = kFarthest * std::sqrt(cell.area_m2), far_m = of.way_O.norm();
  const bool is_in = is_reached(now);
  Vector3d way_O = far_m > most_m ? Vector3d(most_m / far_m * of.way_O) : of.way_O;
  if (!is_in) {
    // It may be reached while the frame is used: then it is as deep as that, at most.
    way_O = (std::min(now.depth_m + band_m, most_m) - now.depth_m) * of.N_O;
  }
  // How it changes, and its compliance, are those of the end of the way: taken at its begin, they would lag behind.
  const CellCover then = way_O.isZero(0.0) ? now : cell.cover_after(way_O);
  if (!is_in && then.own == 1.0) return take_whole(then.main);
  if (then.share < kLeastPart) return AtEdge::kFree;
  OwnCompliance own{softness * cell.pulp.kernel(of.control_point, of.control_point), 0.0};
  if (model.soft_object()) {
    own.object = half_space_kernel(*model.scene.object.compliance, 0.0, cell.area_m2, cell.area_m2);
  }
  return cut_contact(cell, now, then, way_O, own, tip, X_OF, contact) ? AtEdge::kCut : AtEdge::kFree;
}

}  // namespace thenar
