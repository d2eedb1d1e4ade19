// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/edge_ways.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thenar::truth {

using Eigen::AngleAxisd;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<EdgeWay> edge_ways() {
  constexpr double kEdge_m = 10e-3 * std::numbers::sqrt2;
  const Matrix3d flat = Matrix3d::Identity(),
                 on_edge = AngleAxisd(std::numbers::pi / 4.0, Vector3d::UnitZ()).toRotationMatrix(),
                 end_on = AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitY()).toRotationMatrix();
  const BoxShape box{Vector3d(20e-3, 20e-3, 60e-3)};
  const CylinderShape cylinder{10e-3, 20e-3};
  const Mug mug{.radius_m = 20e-3, .height_m = 40e-3, .wall_m = 3e-3, .handle = {}};
  return {
      {"OffAnEdge", box, flat, {10e-3, -6e-3, 0.0}, {10e-3, -14e-3, 0.0}},
      {"OntoAFace", box, flat, {10e-3, -14e-3, 0.7e-3}, {10e-3, -6e-3, 0.7e-3}},
      {"OverACorner", box, flat, {10e-3, -6e-3, -26e-3}, {10e-3, -12e-3, -33e-3}},
      {"AcrossAnEdge", box, on_edge, {kEdge_m, -2e-3, 0.0}, {kEdge_m, 2e-3, 0.0}, true},
      {"AlongAnEdgeToItsEnd", box, on_edge, {kEdge_m, 0.3e-3, -24e-3}, {kEdge_m, 0.3e-3, -34e-3}, true},
      {"OffARim", cylinder, end_on, {10e-3, -4e-3, 1e-3}, {10e-3, -14e-3, 1e-3}},
      {"OffAMugsMouth", mug, flat, {20e-3, 0.0, -8e-3}, {20e-3, 0.0, -26e-3}},
      {"OffAMugsBottom", mug, end_on, {20e-3, 0.0, 14e-3}, {20e-3, 0.0, 24e-3}},
  };
}

Taken take(const EdgeWay& way, double depth_m, Probe probe, double tick_m) {
  constexpr double kClear_m = 0.2e-3;
  probe.shape = way.shape;
  probe.points = 20000;
  const Vector3d out = Vector3d::UnitX(), tip = kProbeRadius_m * out;
  probe.X_WO.linear() = way.R;
  probe.X_WO.translation() = tip + way.from_m + kClear_m * out;
  Loop loop(scene_of(probe));
  Taken taken;
  Vector3d at_m = probe.X_WO.translation(), x_m = at_m, F_N = Vector3d::Zero();
  const std::vector<Vector3d> stops = {tip + way.from_m - depth_m * out, tip + way.to_m - depth_m * out,
                                       tip + way.to_m + kClear_m * out};
  for (std::size_t leg = 0; leg < stops.size(); ++leg) {
    const Vector3d begin_m = at_m;
    const auto ticks = std::lround((stops[leg] - begin_m).norm() / tick_m);
    for (Index k = 1; k <= ticks; ++k) {
      at_m = begin_m + static_cast<double>(k) / static_cast<double>(ticks) * (stops[leg] - begin_m);
      TickInput input;
      input.X_WT = probe.X_WO;
      input.X_WT->translation() = at_m;
      const TickReport report = loop.tick(input);
      const Vector3d force_N = loop.state.load[0].force_N, now_m = loop.state.X_WO.translation();
      taken.work_J -= 0.5 * (force_N + F_N).dot(now_m - x_m);
      taken.stored_J = std::max(taken.stored_J, report.ledger.stored_J);
      taken.injected_J += report.ledger.injected_J;
      taken.dissipated_J += report.ledger.dissipated_J;
      if (leg == 1) {
        taken.largest_N = std::max(taken.largest_N, force_N.norm());
        if (k > 1) taken.step_N = std::max(taken.step_N, (force_N - F_N).norm());
      }
      F_N = force_N;
      x_m = now_m;
    }
  }
  return taken;
}

}  // namespace thenar::truth
