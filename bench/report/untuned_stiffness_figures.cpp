// SPDX-License-Identifier: Apache-2.0
// How well the predicted stiffness of grasps that nobody tuned agrees with probes.
//   untuned_stiffness_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <exception>
#include <string>
#include <vector>

#include "bench/cases/untuned_grasps.h"
#include "bench/report/figure.h"
#include "bench/report/touch_runs.h"
#include "engine/models/build_model.h"
#include "engine/stiffness/stiffness_probe.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr int kLeaves = 320;
constexpr double kAt_s = 1.0, kBar = 0.02;

/// One grasp: what was predicted and measured, or why nothing could be.
struct Untuned {
  std::string name, lack;
  PredictedStiffness predicted;
  Rest rest;
  MeasuredStiffness measured;

  [[nodiscard]] bool is_known() const { return lack.empty(); }
  [[nodiscard]] double error() const { return compliance_error(measured.C_O, predicted.K_O.inverse()); }
  /// The largest relative difference of a stiffness with all other motions held.
  [[nodiscard]] double held_error() const {
    return (measured.K_O.diagonal().array() / predicted.K_O.diagonal().array() - 1.0).abs().maxCoeff();
  }
};

Untuned studied(std::uint64_t seed) {
  Untuned one;
  try {
    UntunedGrasp grasp = untuned_grasp(seed, kLeaves);
    one.name = grasp.name;
    const Model model = build_model(std::move(grasp.scene));
    GraspAt at(model, kAt_s, Acting::kMuscles);
    one.rest = let_rest(at, {});
    one.predicted = predict_stiffness(at.run);
    if (const auto measured = probe_stiffness(at, one.predicted, {})) {
      one.measured = *measured;
    } else {
      one.lack = "turns away by itself";
    }
  } catch (const std::exception&) {
    one.lack = "no grasp";
  }
  return one;
}

std::string doubt_of(const Untuned& one) {
  if (!one.rest.reached) return "does not rest";
  return one.predicted.uncertain > kBar ? fmt::format("{} contacts slide or nearly do", one.predicted.near_sliding)
                                        : "-";
}

/// Free stiffnesses, predicted and measured, along axes or about them.
ordered_json panel_of(const std::string& name, const std::vector<Untuned>& all, int first_axis) {
  struct Point {
    double predicted, measured;
  };
  std::vector<Point> sure, doubtful;
  double low = 1e9, high = 0.0;
  for (const Untuned& one : all) {
    if (!one.is_known()) continue;
    const Matrix6d C = one.predicted.K_O.inverse();
    for (int axis = first_axis; axis < first_axis + 3; ++axis) {
      const Point point{1.0 / C(axis, axis), 1.0 / one.measured.C_O(axis, axis)};
      (doubt_of(one) == "-" ? sure : doubtful).push_back(point);
      low = std::min(low, point.predicted);
      high = std::max(high, point.predicted);
    }
  }
  ordered_json curves = ordered_json::array();
  for (auto* points : {&sure, &doubtful}) {
    std::ranges::sort(*points, {}, &Point::predicted);
    std::vector<double> x, y;
    for (const Point& point : *points) {
      x.push_back(point.predicted);
      y.push_back(point.measured);
    }
    curves.push_back(plain_curve(points == &sure ? "trusted" : "told not to be trusted", x, y));
  }
  curves.push_back(theory_curve("as predicted", {low, high}, {low, high}));
  return {{"name", name}, {"curves", curves}};
}

void add_untuned(ordered_json& part, bool quick) {
  const int wanted = quick ? 3 : 20, seeds = quick ? 5 : 40;
  std::vector<Untuned> all(seeds);
  tbb::parallel_for(0, seeds, [&](int i) { all[i] = studied(static_cast<std::uint64_t>(i) + 1); });
  ordered_json rows = ordered_json::array();
  std::vector<Untuned> shown;
  int passed = 0, trusted = 0, trusted_passed = 0;
  for (int i = 0; i < seeds && std::ssize(shown) < wanted; ++i) {
    const Untuned& one = all[i];
    if (!one.is_known()) continue;
    shown.push_back(one);
    const std::string doubt = doubt_of(one);
    const bool passes = one.error() < kBar && one.held_error() < kBar;
    passed += passes ? 1 : 0;
    trusted += doubt == "-" ? 1 : 0;
    trusted_passed += passes && doubt == "-" ? 1 : 0;
    rows.push_back({i + 1, one.name, 1e3 * one.rest.moved_m, one.predicted.sliding, 100.0 * one.held_error(),
                    100.0 * one.error(), doubt});
  }
  const std::string caption = fmt::format(
      "Grasps that the finder makes of five objects with three to five fingers, with random press, mass and stiffness "
      "asked for, all by the seed; those without a grasp or without a rest are left out. Predictions are at rest, "
      "after "
      "excitations stop at {:g} s. {} of {} agree within {:g} % in stiffnesses and compliances; of the {} that the "
      "program trusts, {}.",
      kAt_s, passed, std::ssize(shown), 100.0 * kBar, trusted, trusted_passed);
  ordered_json& table =
      add_figure(part, "table", "untuned_stiffness", "Grasps that nobody tuned", caption, "A run each.");
  table["columns"] = {"seed",
                      "grasp",
                      "moved until it rested [mm]",
                      "contacts that slide",
                      "stiffnesses differ by [%]",
                      "compliances differ by [%]",
                      "told"};
  table["rows"] = rows;
  const ordered_json panels = {panel_of("along axes [N/m]", shown, 0), panel_of("about axes [N m/rad]", shown, 3)};
  add_run_curves(part, "untuned_stiffness_map", "Predicted against measured", caption,
                 "predicted stiffness, all other motions free", "measured", panels);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "untuned_stiffness", "Stiffness of grasps that nobody tuned",
                  "The predicted stiffness of a grasp against probes of the simulation.", {add_untuned});
}
