// SPDX-License-Identifier: Apache-2.0
// What a fingertip feels of its patch under a growing pull, against Cattaneo and Mindlin: how much of the patch sticks,
// when the rim slips first, and the friction that is felt there.
//   partial_slip_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "bench/cases/random.h"
#include "bench/cases/scene_run.h"
#include "bench/report/figure.h"
#include "engine/grasp/touch.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using nlohmann::ordered_json;

constexpr double kFriction = 0.8;
constexpr double kNoise = 0.05;  // Of each contact's force as it is felt. Which contacts slip is not noisy.
constexpr unsigned kSeed = 21;

double law(double eta) { return std::pow(1.0 - eta, 2.0 / 3.0); }

/// What the thumb feels at one share eta = |T| / (mu N) of what friction can carry.
struct Felt {
  double eta = 0.0;
  Touch touch;
};

/// One drag from no pull to the limit.
struct Drag {
  std::vector<Felt> felt;
  Index contacts = 0;  ///< That carry force when the pull begins.

  /// The first at which eta is as large.
  [[nodiscard]] const Felt& at(double eta) const {
    const auto found = std::ranges::find_if(felt, [&](const Felt& f) { return f.eta >= eta; });
    return found == felt.end() ? felt.back() : *found;
  }
  [[nodiscard]] double first_slip() const {
    const auto slips = std::ranges::find_if(felt, [](const Felt& f) { return f.touch.stick < 1.0; });
    return slips == felt.end() ? 1.0 : slips->eta;
  }
  /// Of the friction that is felt where a rim slips, relative: its mean over the drag, and the mean of its square.
  [[nodiscard]] double friction_error(int power) const {
    double sum = 0.0;
    int slipping = 0;
    for (const Felt& f : felt) {
      if (!(f.touch.stick < 1.0)) continue;
      sum += std::pow(f.touch.friction / kFriction - 1.0, power);
      ++slipping;
    }
    return sum / slipping;
  }
};

/// A block that touches the thumb of configs/pulp_drag.yaml, along `axes_F`, the first of them into the block. The
/// thumb stays, and the block does not turn.
Scene pressed(double normal_N, Index points, const Eigen::Matrix3d& axes_F) {
  Scene scene = load_scene(std::string(THENAR_CONFIGS) + "/pulp_drag.yaml");
  scene.fingertips->leaves = points;
  scene.contact.max_per_finger = points / 2;
  scene.contact.tolerance = 1e-9;
  scene.contact.friction = kFriction;
  scene.fingertips->touch->noise = kNoise;
  scene.task = {};
  scene.joint_viscosity = scene.object.rotation_damping = 1e9;
  scene.control_period_s = scene.step_s;
  const Fingertip& tip = scene.hand.fingertips[0];
  HandPose pose;
  forward_kinematics(scene.hand, scene.posture, pose);
  const Eigen::Isometry3d& X_WF = pose.distal(scene.hand, 0);
  const Eigen::Matrix3d axes = X_WF.linear() * axes_F;
  constexpr double kHalf_m = 10e-3;
  scene.object.X_WO.linear() = axes;
  scene.object.X_WO.translation() = X_WF * tip.centre_m + (tip.radius_m + kHalf_m) * axes.col(0);
  scene.gravity = -normal_N / scene.object.mass_kg * axes.col(0);
  return scene;
}

/// The pull grows in the face from nothing to all that friction can carry, a thousandth in a tick.
Drag drag(double normal_N, Index points, const Eigen::Matrix3d& axes_F) {
  Model model = build_model(pressed(normal_N, points, axes_F));
  const Vector3d into = model.scene.object.X_WO.linear().col(0), along = model.scene.object.X_WO.linear().col(1);
  model.scene.object.X_WO.translation() -= hertz_depth_m(model.pulps[0], normal_N) * into;
  Loop loop(std::move(model));
  loop.run(0.1);
  constexpr int kTicks = 1000;
  Drag result;
  for (int i = 1; i <= kTicks; ++i) {
    TickInput input;
    input.wrench.head<3>() = kFriction * normal_N * i / kTicks * along;
    const TickReport report = loop.tick(input);
    if (i == 1) result.contacts = report.active;
    const FingerLoad& load = loop.state.load[0];
    const double n_N = load.force_N.dot(load.normal);
    const double eta = (load.force_N - n_N * load.normal).norm() / (kFriction * n_N);
    result.felt.push_back({eta, loop.state.touch[0]});
  }
  return result;
}

/// Drags in several directions, on several places of the pulp.
struct Pressing {
  Index points = 0;
  double normal_N = 0.0;
  int orientations = 0;
  std::vector<Drag> drags = {};

  /// Mean of a number of each drag.
  template <typename Number>
  [[nodiscard]] double mean(Number&& number) const {
    double sum = 0.0;
    for (const Drag& drag : drags) sum += number(drag);
    return sum / static_cast<double>(drags.size());
  }
  template <typename Number>
  [[nodiscard]] double deviation(Number&& number) const {
    const double middle = mean(number);
    return std::sqrt(mean([&](const Drag& drag) { return std::pow(number(drag) - middle, 2); }));
  }
  template <typename Number>
  [[nodiscard]] double most(Number&& number) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const Drag& drag : drags) most = std::max(most, number(drag));
    return most;
  }
};

std::vector<Pressing> press_all(bool quick) {
  std::vector<Pressing> all;
  for (const double N : {0.5, 1.34, 4.0}) {
    for (const auto& [points, orientations] : {std::pair(320, 12), {640, quick ? 4 : 12}, {1280, 4}}) {
      if (quick && points == 1280) continue;
      all.push_back({points, N, orientations});
      all.back().drags.resize(orientations);
    }
  }
  // The longest first, so that all threads end at about the same time.
  std::vector<std::pair<std::size_t, int>> jobs;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (int k = 0; k < all[i].orientations; ++k) jobs.emplace_back(i, k);
  }
  std::ranges::stable_sort(jobs, std::greater{},
                           [&](const auto& job) { return std::pair(all[job.first].points, all[job.first].normal_N); });
  tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t j) {
    const auto [i, k] = jobs[j];
    Random random(kSeed + k);  // The same orientations for all.
    const Eigen::Matrix3d axes = random.frame_about(random.direction());
    all[i].drags[k] = drag(all[i].normal_N, all[i].points, axes);
  });
  return all;
}

double contacts_of(const Drag& drag) { return static_cast<double>(drag.contacts); }

const std::vector<double> kTold = {0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8};

double stick_error(const Drag& drag) {
  double sum = 0.0;
  for (const double eta : kTold) sum += drag.at(eta).touch.stick - law(drag.at(eta).eta);
  return sum / static_cast<double>(kTold.size());
}

/// Mean square, where eta is told by what sticks.
double square_of_eta(const Drag& drag) {
  double sum = 0.0;
  for (const double eta : kTold) {
    sum += std::pow(1.0 - std::pow(drag.at(eta).touch.stick, 1.5) - drag.at(eta).eta, 2);
  }
  return sum / static_cast<double>(kTold.size());
}

void add_curves(ordered_json& part, const std::vector<Pressing>& all) {
  std::string found;
  ordered_json panels = ordered_json::array();
  for (const Pressing& pressing : all) {
    if (pressing.normal_N != 1.34) continue;
    std::vector<double> x, mean, low, high, law_y;
    for (int i = 1; i < 50; ++i) {
      const double eta = 0.02 * i;
      const auto stick = [&](const Drag& drag) { return drag.at(eta).touch.stick; };
      const double middle = pressing.mean(stick), spread = pressing.deviation(stick);
      x.push_back(eta);
      mean.push_back(middle);
      low.push_back(std::max(0.0, middle - spread));
      high.push_back(std::min(1.0, middle + spread));
      law_y.push_back(law(eta));
    }
    ordered_json measured = plain_curve("measured, with its standard deviation", x, mean);
    measured["low"] = low;
    measured["high"] = high;
    panels.push_back(
        {{"name", fmt::format("{} control points, {:.0f} in the patch", pressing.points, pressing.mean(contacts_of))},
         {"curves", {measured, theory_curve("Cattaneo and Mindlin: (1 - η)^(2/3)", x, law_y)}}});
    found +=
        fmt::format("{} {:+.3f} with {} points", found.empty() ? "" : ",", pressing.mean(stick_error), pressing.points);
  }
  ordered_json& figure = add_figure(
      part, "curves", "stick", "How much of a patch sticks",
      fmt::format("A pulp under 1.34 N is dragged along a face until it slides, friction {}; the share of the loaded "
                  "area that sticks over the share η = |T| / (μ N) of what friction can carry. Between η of 0.2 and "
                  "0.8 the mean is off the law by{}. How the control points lie in one patch is chance, and "
                  "each slips as a whole: so the mean has steps, and scatter that shrinks with their number.",
                  kFriction, found),
      "Deterministic drags in 4 to 12 random directions on as many places of the pulp.");
  figure["x"] = {{"label", "share η of what friction can carry"}, {"log", false}};
  figure["y"] = {{"label", "share of the area that sticks"}, {"log", false}};
  figure["panels"] = panels;
}

void add_table(ordered_json& part, const std::vector<Pressing>& all) {
  double latest = 0.0, worst = 0.0;
  ordered_json rows = ordered_json::array();
  for (const Pressing& pressing : all) {
    const auto slips = [](const Drag& drag) { return drag.first_slip(); };
    const double bias = pressing.mean([](const Drag& drag) { return drag.friction_error(1); });
    const double rms = std::sqrt(pressing.mean([](const Drag& drag) { return drag.friction_error(2); }));
    latest = std::max(latest, pressing.most(slips));
    worst = std::max(worst, rms);
    rows.push_back({pressing.normal_N, pressing.points, std::round(pressing.mean(contacts_of)), pressing.orientations,
                    fmt::format("{:.3f}", pressing.mean(stick_error)),
                    fmt::format("{:.3f}", std::sqrt(pressing.mean(square_of_eta))),
                    fmt::format("{:.2f}", pressing.mean(slips)), fmt::format("{:.2f}", pressing.most(slips)),
                    fmt::format("{:.2f}", 100.0 * bias), fmt::format("{:.1f}", 100.0 * rms)});
  }
  ordered_json& figure = add_figure(
      part, "table", "stick_errors", "What partial slip says of load and friction",
      fmt::format(
          "The same under other loads. The error of stick is its mean off the law, that of η the root mean "
          "square where η is taken from how many points stick, 1 - stick^1.5, both for η from 0.2 to 0.8. The "
          "rim slips first at η of {:.2f} at the latest, long before the patch slides at 1. With Coulomb's law in "
          "every point the friction that is felt there is exact; with {:g} % of noise in each contact's force "
          "the root mean square of its error is {:.1f} % at most.",
          latest, 100.0 * kNoise, 100.0 * worst),
      "Deterministic drags as above.");
  figure["columns"] = {"load [N]",        "control points",      "in the patch",
                       "drags",           "mean error of stick", "rms error of η",
                       "first slip at η", "the latest",          "error of felt friction: mean [%]",
                       "rms [%]"};
  figure["rows"] = rows;
}

void partial_slip(ordered_json& part, bool quick) {
  const std::vector<Pressing> all = press_all(quick);
  add_curves(part, all);
  add_table(part, all);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "partial_slip", "What fingertips feel",
                  "With Coulomb's law in every point of a patch its rim slips first, and what sticks shrinks as "
                  "Cattaneo and Mindlin say of an elastic half space. A fingertip feels how much sticks, and the "
                  "friction where it slips.",
                  {partial_slip});
}
