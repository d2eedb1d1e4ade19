// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/patch_values.h"

#include <Eigen/Core>
#include <numbers>
#include <utility>

#include "bench/cases/pads.h"
#include "bench/cases/scene_run.h"

namespace thenar {

PatchValues patch_values(Scene scene, double duration_s) {
  Loop loop(std::move(scene));
  PatchValues values = PatchValues::Zero(4, loop.model.fingers());
  while (static_cast<double>(loop.state.tick) * loop.model.scene.step_s < duration_s * (1.0 - 1e-9)) {
    const TickReport tick = loop.tick();
    for (int k = 0; k < loop.model.fingers(); ++k) {
      values(0, k) += tick.patch[k].slip_m;
      values(1, k) += std::abs(tick.patch[k].spin_rad);
      values(2, k) = tick.patch[k].margin;
      values(3, k) = 0.0;
      for (const PatchPoint& point : loop.work.patches.of_finger(k)) {
        values(3, k) += loop.state.load[k].normal.dot(point.r_W.cross(point.f_W));
      }
    }
  }
  return values;
}

Eigen::Vector4d relative_errors(const PatchValues& values, const PatchValues& reference) {
  return (values - reference).rowwise().norm().cwiseQuotient(reference.rowwise().norm());
}

Scene turned_ball() {
  Pads pads = pads_round(SphereShape{25e-3}, 25e-3);
  pads.friction = 0.5;
  pads.depth_m = 1.6e-3;
  Scene scene = scene_of(pads);
  scene.gravity.setZero();
  scene.contact.tolerance = 1e-9;
  scene.contact.max_sweeps = 1000;
  scene.task.spring = Spring{3000.0, 3.0};
  scene.task.translate = Move{Eigen::Vector3d::UnitZ(), 0.6e-3, 0.02, 0.1};
  scene.task.rotate = Move{Eigen::Vector3d::UnitX(), std::numbers::pi / 45.0, 0.02, 0.1};
  return scene;
}

Scene with_controls(Scene scene, Eigen::Index controls) {
  scene.fingertips->leaves = controls;
  scene.fingertips->points = controls * 15 / 2;
  scene.contact.max_per_finger = controls / 8;
  return scene;
}

}  // namespace thenar
