#include "engine/grasp_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "engine/surface_display.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kArrow_m_per_N = 10e-3;
const Vector3d kBone(0.86, 0.80, 0.70);
const Vector3d kSkin(0.93, 0.72, 0.62);
const Vector3d kPressed(0.78, 0.10, 0.10);
const Vector3d kObject(0.25, 0.42, 0.62);

/// A small disc of a surface.
struct Surfel {
  Vector3d point_m, normal, color;  // World axes; color red, green, blue in 0 .. 1.
  double radius_m;
};

/// Rows: right, up, towards the eye.
Matrix3d camera(const Model& model, const HandPose& pose) {
  const Hand& hand = model.scene.hand;
  const auto tip = [&](int k) { return Vector3d(pose.distal(hand, k) * hand.fingertips[k].centre_m); };
  const double g = model.scene.gravity.norm();
  const Vector3d up = g > 0.0 ? Vector3d(-model.scene.gravity / g) : Vector3d::UnitZ();
  // The grip axis, thumb to fingers, lies level and across the picture.
  const Vector3d grip = 0.5 * (tip(1) + tip(2)) - tip(0);
  const Vector3d across = (grip - grip.dot(up) * up).stableNormalized();
  const Vector3d level = across.cross(up);
  constexpr double kTurn = 0.55, kRise = 0.45;  // [rad]: both fingers and the top of the object show.
  Matrix3d R;
  R.row(2) = std::cos(kRise) * (std::cos(kTurn) * level + std::sin(kTurn) * across) + std::sin(kRise) * up;
  R.row(0) = up.cross(Vector3d(R.row(2))).normalized();
  R.row(1) = Vector3d(R.row(2)).cross(Vector3d(R.row(0)));
  return R;
}

void add_object(const Model& model, const State& state, std::vector<Surfel>& surfels) {
  const PointCloud& cloud = model.object.cloud();
  for (const Index leaf : model.object.tree().leaves()) {
    const Index i = model.object.tree().nodes()[leaf].representative;
    surfels.push_back({state.X_WO * cloud.points_m.col(i), state.X_WO.linear() * cloud.normals.col(i), kObject, 0.35e-3});
  }
}

void add_bones(const Hand& hand, const HandPose& pose, std::vector<Surfel>& surfels) {
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    const double radius_m = 0.55 * hand.fingertips[segment.finger].radius_m;
    const int rings = static_cast<int>(segment.length_m / 0.5e-3), sides = 36;
    for (int i = 0; i < rings; ++i) {
      for (int j = 0; j < sides; ++j) {
        const double angle = 2.0 * std::numbers::pi * (j + 0.5 * (i % 2)) / sides;
        const Vector3d normal(0.0, std::cos(angle), std::sin(angle));
        const Vector3d along(segment.length_m * i / rings, 0.0, 0.0);
        surfels.push_back({pose.segments[s] * (along + radius_m * normal), pose.segments[s].linear() * normal, kBone, 0.6e-3});
      }
    }
  }
}

/// A fingertip as it is deformed, redder where its surface has moved farther.
void add_pulp(const Pulp& pulp, const Eigen::MatrixX3d& u_m, const Eigen::Isometry3d& X_WF, std::vector<Surfel>& surfels) {
  constexpr double kFullColor_m = 1.5e-3;
  SurfaceDisplay display(pulp);
  const Eigen::Matrix4Xd& moved = display.displace(u_m);
  for (Index i = 0; i < moved.cols(); ++i) {
    const Vector3d d = moved.col(i).head<3>();
    const double share = std::min(1.0, d.norm() / kFullColor_m);
    surfels.push_back({X_WF * (pulp.surface.points_m.col(i) + d), X_WF.linear() * pulp.surface.normals.col(i),
                       (1.0 - share) * kSkin + share * kPressed, 0.45e-3});
  }
}

void add_rigid_tip(const Fingertip& tip, const Eigen::Isometry3d& X_WF, std::vector<Surfel>& surfels) {
  const PointCloud sphere = sample_sphere(tip.radius_m, 2400);
  for (Index i = 0; i < sphere.points_m.cols(); ++i) {
    surfels.push_back({X_WF * (tip.centre_m + sphere.points_m.col(i)), X_WF.linear() * sphere.normals.col(i), kSkin, 0.45e-3});
  }
}

std::vector<Surfel> scene_surfels(const Model& model, const State& state, const HandPose& pose) {
  const Hand& hand = model.scene.hand;
  std::vector<Surfel> surfels;
  add_object(model, state, surfels);
  add_bones(hand, pose, surfels);
  for (int k = 0; k < kFingers; ++k) {
    if (model.deformable()) {
      add_pulp(model.pulps[k], state.u_m[k], pose.distal(hand, k), surfels);
    } else {
      add_rigid_tip(hand.fingertips[k], pose.distal(hand, k), surfels);
    }
  }
  return surfels;
}

template <typename... Args>
void append(std::string& text, const char* format, Args... args) {
  char line[200];
  std::snprintf(line, sizeof line, format, args...);
  text += line;
}

/// Far discs first, each as "x y radius colour" [mm].
std::string painted(std::vector<Surfel> surfels, const Matrix3d& view) {
  std::erase_if(surfels, [&](const Surfel& s) { return view.row(2).dot(s.normal) <= 0.0; });
  std::stable_sort(surfels.begin(), surfels.end(), [&](const Surfel& a, const Surfel& b) {
    return view.row(2).dot(a.point_m) < view.row(2).dot(b.point_m);
  });
  const Vector3d light = view.transpose() * Vector3d(-0.4, 0.7, 0.6).normalized();
  std::string lines;
  for (const Surfel& s : surfels) {
    const Vector3d p = 1e3 * view * s.point_m;
    const Vector3d rgb = 255.0 * (0.45 + 0.55 * std::max(0.0, light.dot(s.normal))) * s.color;
    append(lines, "%.3f %.3f %.3f %d\n", p.x(), p.y(), 1e3 * s.radius_m,
           (static_cast<int>(rgb[0]) << 16) + (static_cast<int>(rgb[1]) << 8) + static_cast<int>(rgb[2]));
  }
  return lines;
}

/// The fingers' forces on the object: arrows that end where they act.
std::string arrows(const State& state, const Matrix3d& view) {
  std::string lines;
  for (const FingerLoad& load : state.load) {
    if (load.normal_N <= 0.0) continue;
    const Vector3d d = 1e3 * kArrow_m_per_N * view * load.force_N;
    const Vector3d p = 1e3 * view * load.centre_m - d;
    append(lines, "%.3f %.3f %.3f %.3f\n", p.x(), p.y(), d.x(), d.y());
  }
  return lines;
}

}  // namespace

std::string grasp_picture_script(const Model& model, const State& state, const std::filesystem::path& file) {
  HandPose pose;
  forward_kinematics(model.scene.hand, state.q, pose);
  const Matrix3d view = camera(model, pose);
  std::string script = "set terminal pngcairo size 1000,760 background rgb 'white'\nset output '" + file.string() + "'\n";
  script += "$discs << EOD\n" + painted(scene_surfels(model, state, pose), view) + "EOD\n";
  script += "$forces << EOD\n" + arrows(state, view) + "EOD\n";
  script +=
      "unset border\nunset tics\nunset key\nset size ratio -1\nset margins 0,0,0,0\n"
      "set style fill solid 1.0 noborder\n"
      "plot $discs using 1:2:3:4 with circles lc rgb variable, "
      "$forces using 1:2:3:4 with vectors lw 4 lc rgb '#107030' filled head size 2.5,20,60 fixed\n";
  return script;
}

}  // namespace thenar
