// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/shown_environment.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

struct SolidWords {
  ShownSolid operator()(const HalfSpace&) const { return {"plane", {}}; }
  ShownSolid operator()(const BoxShape& box) const { return {"box", {box.size_m[0], box.size_m[1], box.size_m[2]}}; }
  ShownSolid operator()(const SphereShape& sphere) const { return {"sphere", {sphere.radius_m}}; }
  ShownSolid operator()(const CylinderShape& cylinder) const {
    return {"cylinder", {cylinder.radius_m, cylinder.length_m}};
  }
  ShownSolid operator()(const HoleShape& hole) const { return {"hole", {hole.radius_m, hole.depth_m, hole.chamfer_m}}; }
};

double margin_of(const ShownTouch& touch, double friction) {
  const double f_n = touch.force_N.dot(touch.normal);
  const double f_t = (touch.force_N - f_n * touch.normal).norm();
  return friction > 0.0 ? 1.0 - f_t / (friction * f_n) : kNothing;
}

}  // namespace

ShownSolid shown_solid(const Solid& solid) { return std::visit(SolidWords{}, solid); }

ShownEnvironment shown_environment(const Model& model, const Picture& picture) {
  const std::vector<EnvironmentBody>& bodies = model.scene.environment->bodies;
  const Instant now = instant(picture.snapshot.arm, static_cast<double>(picture.snapshot.tick) * model.scene.step_s);
  const auto count = std::ssize(bodies);
  const auto places = static_cast<Eigen::Index>(std::min(kMostTouches, most_touches(model.scene)));
  ShownEnvironment shown;
  for (const EnvironmentBody& body : bodies) shown.X_WE.push_back(pose(body, now));
  shown.force_N.setZero(3, count);
  shown.mean_m.setZero(3, count);
  shown.point_m.setConstant(3, places, kNothing);
  shown.touch_N.setConstant(3, places, kNothing);
  shown.margin.setConstant(places, kNothing);

  Eigen::VectorXd normal_N = Eigen::VectorXd::Zero(count);
  for (const ShownTouch& touch : picture.touches) {
    const double f_n = touch.force_N.dot(touch.normal);
    normal_N[touch.body] += f_n;
    shown.force_N.col(touch.body) += touch.force_N;
    shown.mean_m.col(touch.body) += f_n * (shown.X_WE[touch.body] * touch.point_E);
  }
  // 0/0 of a body without force is NaN.
  for (Eigen::Index k = 0; k < count; ++k) shown.mean_m.col(k) /= normal_N[k];
  std::vector<ShownTouch> most = picture.touches;
  std::ranges::stable_sort(most, std::ranges::greater(), [](const ShownTouch& touch) { return touch.force_N.norm(); });
  for (Eigen::Index i = 0; i < std::min(places, std::ssize(most)); ++i) {
    shown.point_m.col(i) = shown.X_WE[most[i].body] * most[i].point_E;
    shown.touch_N.col(i) = most[i].force_N;
    shown.margin[i] = margin_of(most[i], bodies[most[i].body].friction);
  }
  return shown;
}

}  // namespace thenar
