// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/grasp_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "collision/shapes.h"
#include "engine/figures/body_picture.h"
#include "engine/figures/gnuplot.h"
#include "engine/figures/surfels.h"
#include "engine/loops/surface_display.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kArrow_m_per_N = 10e-3;
const Vector2d kLabel_mm(19.0, 5.5);  // As large as "1.23 N" is where the whole hand is in the picture.
const Vector3d kPressed(0.78, 0.10, 0.10);
const Vector3d kObject(0.42, 0.58, 0.75);

/// The direction against gravity; z without.
Vector3d upward(const Model& model) {
  const double g = model.scene.gravity.norm();
  return g > 0.0 ? Vector3d(-model.scene.gravity / g) : Vector3d::UnitZ();
}

/// Rows: right, up, towards the eye, which is on one of two sides and turned to one of two ends of the grip axis.
Matrix3d camera(const Model& model, const HandPose& pose, double side, double end) {
  const Hand& hand = model.scene.hand;
  const auto tip = [&](int k) { return Vector3d(pose.distal(hand, k) * hand.fingertips[k].centre_m); };
  const Vector3d up = upward(model);
  // The grip axis, from the fingertip that is farthest from the others, as a thumb is, to the middle of these, lies
  // level and across the picture.
  Vector3d sum = Vector3d::Zero(), grip = Vector3d::Zero();
  for (int k = 0; k < hand.fingers(); ++k) sum += tip(k);
  for (int k = 0; k < hand.fingers() && hand.fingers() > 1; ++k) {
    const Vector3d others = (sum - tip(k)) / (hand.fingers() - 1.0);
    if ((others - tip(k)).norm() > grip.norm()) grip = others - tip(k);
  }
  if (grip.isZero()) grip.setUnit(0);
  const Vector3d across = (grip - grip.dot(up) * up).stableNormalized();
  const Vector3d level = across.cross(up);
  constexpr double kTurn = 0.35, kRise = 0.5;  // [rad]: both fingers and the top of the object show.
  Matrix3d R;
  R.row(2) = std::cos(kRise) * (std::cos(kTurn) * side * level + std::sin(kTurn) * end * across) + std::sin(kRise) * up;
  R.row(0) = up.cross(Vector3d(R.row(2))).normalized();
  R.row(1) = Vector3d(R.row(2)).cross(Vector3d(R.row(0)));
  return R;
}

void add_object(const Model& model, const State& state, std::vector<Surfel>& surfels) {
  constexpr Index kEnough = 40'000;
  const PointCloud& cloud = model.object.cloud();
  const Index stride = 1 + (cloud.points_m.cols() - 1) / kEnough;
  // Discs that cover the surface: the support of its implicit surface is 2.2 sample spacings.
  const double radius_m = 1.0 * model.object.support_m() / 2.2 * std::sqrt(static_cast<double>(stride));
  for (Index i = 0; i < cloud.points_m.cols(); i += stride) {
    surfels.push_back(
        {state.X_WO * cloud.points_m.col(i), state.X_WO.linear() * cloud.normals.col(i), kObject, radius_m});
  }
}

/// A fingertip as it is deformed, redder where its surface has moved farther.
void add_pulp(const Pulp& pulp, const Eigen::MatrixX3d& u_m, const Eigen::Isometry3d& X_WF,
              std::vector<Surfel>& surfels) {
  constexpr double kFullColor_m = 1.5e-3;
  // Discs that cover the surface, also where it is stretched.
  const double spacing_m = std::sqrt(pulp.area_m2.sum() / static_cast<double>(pulp.surface.points_m.cols()));
  const double radius_m = std::max(0.62e-3, 1.1 * spacing_m);
  SurfaceDisplay display(pulp);
  const Eigen::MatrixX3f moved = display.displace(u_m);
  for (Index row = 0; row < moved.rows(); ++row) {
    const Vector3d d = moved.row(row).transpose().cast<double>();
    const Index i = pulp.order[row];
    const double share = std::min(1.0, d.norm() / kFullColor_m);
    surfels.push_back({X_WF * (pulp.surface.points_m.col(i) + d), X_WF.linear() * pulp.surface.normals.col(i),
                       (1.0 - share) * kSkin + share * kPressed, radius_m});
  }
}

void add_fingertip(const Model& model, const State& state, const HandPose& pose, int k, std::vector<Surfel>& surfels) {
  const Fingertip& tip = model.scene.hand.fingertips[k];
  const Eigen::Isometry3d& X_WF = pose.distal(model.scene.hand, k);
  if (model.deformable()) {
    add_pulp(model.pulps[k], state.u_m[k], X_WF, surfels);
  } else {
    add_rigid_pulp(tip, X_WF, surfels);
  }
}

/// How much of the surfels from `begin` on, and of the first `end`, is in front of all others: squares of the picture.
std::size_t visible(const std::vector<Surfel>& surfels, std::size_t end, std::size_t begin, const Matrix3d& view) {
  constexpr double kSquare_m = 1.5e-3;
  struct Front {
    double towards_m = -1e9;
    bool counts = false;
  };
  std::map<std::pair<long, long>, Front> squares;
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const Vector3d at = view * surfels[i].point_m;
    Front& front = squares[{std::lround(at.x() / kSquare_m), std::lround(at.y() / kSquare_m)}];
    if (at.z() > front.towards_m) front = {at.z(), i < end || i >= begin};
  }
  return static_cast<std::size_t>(std::ranges::count_if(squares, [](const auto& one) { return one.second.counts; }));
}

/// The lines of the bodies around the object, where they are now.
void add_environment(const Model& model, const State& state, const Matrix3d& view, std::vector<Surfel>& surfels) {
  if (!model.scene.environment) return;
  const Instant now = instant(state.arm, static_cast<double>(state.tick) * model.scene.step_s);
  for (const EnvironmentBody& body : model.scene.environment->bodies) {
    add_outline(body.shape, pose(body, now), state.X_WO.translation(), view.row(2).transpose(), surfels);
  }
}

/// The fingers' forces on the object: arrows that end where they act, with their size and its place.
std::string arrows(const State& state, const Matrix3d& view) {
  std::vector<Vector2d> labels;  // [mm], each clear of the others; from the top downwards
  std::string lines;
  for (const FingerLoad& load : state.load) {
    if (load.normal_N <= 0.0) continue;
    const Vector3d d = 1e3 * kArrow_m_per_N * view * load.force_N;
    const Vector3d p = 1e3 * view * load.centre_m - d;
    Vector2d label(p.x() + 8.0, p.y() + (d.x() < 0.0 ? -3.0 : 4.0));
    // Below those that it would cover: each moves it once at most, and below the higher ones it stays.
    for (const Vector2d& other : labels) {
      const Vector2d apart = (other - label).cwiseAbs();
      if (apart.x() < kLabel_mm.x() && apart.y() < kLabel_mm.y()) label.y() = other.y() - kLabel_mm.y();
    }
    labels.push_back(label);
    std::ranges::sort(labels, [](const Vector2d& a, const Vector2d& b) { return a.y() > b.y(); });
    lines += fmt::format("{:.3f} {:.3f} {:.3f} {:.3f} {:.3f} {:.3f} \"{:.2f} N\"\n", p.x(), p.y(), d.x(), d.y(),
                         label.x(), label.y(), load.force_N.norm());
  }
  return lines;
}

/// Which way is down, and how long 20 mm are, at the left of what is drawn.
std::string gauge(const Model& model, const std::vector<Surfel>& surfels, const Matrix3d& view) {
  Vector2d low = Vector2d::Constant(1e9), high = -low;
  for (const Surfel& surfel : surfels) {
    const Vector2d at = 1e3 * (view * surfel.point_m).head<2>();
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Vector2d down = -16.0 * (view * upward(model)).head<2>(), from(low.x() - 8.0, high.y());
  std::string script = fmt::format(
      "set arrow 1 from {0:.3f},{1:.3f} rto 20,0 heads size 1.2,90 lw 2 lc rgb '#555555'\n"
      "set label 2 '20 mm' at {2:.3f},{3:.3f} center tc rgb '#555555'\n$corners << EOD\n{4:.3f} {3:.3f}\n"
      "{4:.3f} {5:.3f}\nEOD\n",
      from.x(), low.y() - 6.0, from.x() + 10.0, low.y() - 11.0, from.x() - 4.0, from.y());
  if (model.scene.gravity.isZero()) return script;
  return script + fmt::format(
                      "set arrow 2 from {0:.3f},{1:.3f} rto {2:.3f},{3:.3f} lw 3 lc rgb '#555555' filled head size "
                      "3,20,60 fixed\nset label 3 'g' at {4:.3f},{5:.3f} left tc rgb '#555555'\n",
                      from.x(), from.y(), down.x(), down.y(), from.x() + 3.0, from.y() - 6.0);
}

/// How the picture is shared out: the grasp at the left, the pulps at the right, below each other or, if these are more
/// than three, two in a row. Places are shares of the picture's width and height.
struct Layout {
  bool narrow = true;  ///< One column of pulps.
  int width_px = 900, rows = 3;
  double grasp_end = 0.66;

  explicit Layout(int pulps) : narrow(pulps <= 3) {
    if (narrow) return;
    width_px = 1120;
    rows = (pulps + 1) / 2;
    grasp_end = 0.57;
  }

  /// "set lmargin ..." of the k-th pulp of all.
  [[nodiscard]] std::string margins(int k) const {
    const double left = narrow ? 0.70 : 0.585 + 0.21 * (k % 2), right = narrow ? 0.98 : left + 0.195;
    const double pitch = narrow ? 0.325 : 0.93 / rows, height = narrow ? 0.26 : pitch - 0.07;
    const double top = narrow ? 0.95 - pitch * k : 0.88 - pitch * (k / 2);
    return fmt::format(
        "set lmargin at screen {:.4g}\nset rmargin at screen {:.4g}\nset bmargin at screen {:.4g}\n"
        "set tmargin at screen {:.4g}\n",
        left, right, top - height, top);
  }
};

/// The whole grasp, at the left of the picture; `view` becomes the one in which most of object and fingertips is seen.
std::string grasp_panel(const Model& model, const State& state, const HandPose& pose, const Layout& layout,
                        Matrix3d& view) {
  std::vector<Surfel> surfels;
  add_object(model, state, surfels);
  const std::size_t object_end = surfels.size();
  add_bones(model.scene.hand, pose, surfels);
  const std::size_t tips_begin = surfels.size();
  for (int k = 0; k < model.fingers(); ++k) add_fingertip(model, state, pose, k, surfels);
  std::size_t most = 0;
  for (const double side : {1.0, -1.0}) {
    for (const double end : {1.0, -1.0}) {
      const Matrix3d candidate = camera(model, pose, side, end);
      const std::size_t seen = visible(surfels, object_end, tips_begin, candidate);
      if (seen > most) view = candidate;
      most = std::max(most, seen);
    }
  }
  std::string script = gauge(model, surfels, view);
  add_environment(model, state, view, surfels);
  return script + fmt::format(
                      "$grasp << EOD\n{}EOD\n$forces << EOD\n{}EOD\n"
                      "set lmargin at screen 0.02\nset rmargin at screen {}\nset bmargin at screen 0.01\nset tmargin "
                      "at screen 0.99\n"
                      "plot $grasp {}, $forces using 1:2:3:4 with vectors lw 4 lc rgb '#107030' filled head size "
                      "2.5,20,60 fixed, "
                      "$forces using 5:6:7 with labels font ',14' textcolor rgb '#107030', $corners using 1:2 with "
                      "dots lc rgb 'white'\nunset arrow\n",
                      painted(surfels, view), arrows(state, view), layout.grasp_end, kDiscs);
}

/// A deformed fingertip as the object sees it, at the right.
std::string fingertip_panel(const Model& model, const State& state, const HandPose& pose, int k, const Matrix3d& view,
                            const Layout& layout) {
  const Fingertip& tip = model.scene.hand.fingertips[k];
  const Vector3d n = state.load[k].normal_N > 0.0 ? state.load[k].normal
                                                  : Vector3d(pose.distal(model.scene.hand, k).linear() * tip.normal);
  Matrix3d from_object;
  from_object.row(2) = n;
  from_object.row(0) = Vector3d(view.row(1)).cross(n).stableNormalized();
  from_object.row(1) = n.cross(Vector3d(from_object.row(0)));
  std::vector<Surfel> surfels;
  add_fingertip(model, state, pose, k, surfels);
  return fmt::format("$tip << EOD\n{}EOD\n{}set title {} offset 0,-0.8\nplot $tip {}\n", painted(surfels, from_object),
                     layout.margins(k), gnuplot_string(tip.finger + (layout.narrow ? ", seen from the object" : "")),
                     kDiscs);
}

}  // namespace

std::string grasp_picture_script(const Model& model, const State& state) {
  HandPose pose;
  forward_kinematics(model.scene.hand, state.q, pose);
  Matrix3d view = Matrix3d::Identity();
  const Layout layout(model.deformable() ? model.fingers() : 0);
  std::string script = fmt::format(
      "set terminal pngcairo size {},700 font 'Helvetica,13' background rgb 'white'\n"
      "unset border\nunset tics\nunset key\nset size ratio -1\nset offsets 1,1,1,1\nset style fill solid 1.0 noborder\n"
      "set multiplot\n",
      layout.width_px);
  if (!layout.narrow) script += "set label 1 'The pulps, seen from the object' at screen 0.785,0.965 center\n";
  script += grasp_panel(model, state, pose, layout, view) + "unset label\n";
  for (int k = 0; model.deformable() && k < model.fingers(); ++k)
    script += fingertip_panel(model, state, pose, k, view, layout);
  return script + "unset multiplot\n";
}

}  // namespace thenar
