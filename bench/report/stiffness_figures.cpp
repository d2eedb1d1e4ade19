// SPDX-License-Identifier: Apache-2.0
// What stiffness muscles can give a grasp, and at which effort: the front, ways that are not on it, and where it ends.
//   stiffness_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/figure.h"
#include "bench/report/outcome_map.h"
#include "bench/report/touch_runs.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/stiffness/object_stiffness.h"
#include "engine/stiffness/stiffness_probe.h"
#include "engine/stiffness/stiffness_range.h"
#include "engine/stiffness/stiffness_report.h"

namespace thenar {
namespace {

using Eigen::VectorXd;
using nlohmann::ordered_json;

// --- ways to co-contract --------------------------------------------------------------------------------------------

/// All muscles at this activation at least, and the least forces for what is then left of the torques.
std::optional<VectorXd> raised(const Eigen::MatrixXd& H, const VectorXd& tau, const VectorXd& limit,
                               double activation) {
  const VectorXd base = activation * limit, left = tau - H * base, room = limit - base;
  VectorXd f(limit.size());
  if (solve_muscle_forces({H, left, room}, f).status != MuscleStatus::kOptimal) return std::nullopt;
  return VectorXd(base + f);
}

std::optional<StiffForces> raised(const StiffGrasp& grasp, double activation) {
  auto f = raised(grasp.problem.H, grasp.problem.tau, grasp.problem.limit, activation);
  return f ? std::optional(with_stiffness(grasp, *std::move(f), activation)) : std::nullopt;
}

/// The activation at which that takes this effort, or as much as there is.
double raised_activation(const StiffGrasp& grasp, double effort_N) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (low + high);
    const auto found = raised(grasp, middle);
    (found && found->effort_N() <= effort_N ? low : high) = middle;
  }
  return low;
}

/// Whether all postures are as stiff as the solver keeps them.
bool keeps_postures(const StiffGrasp& grasp, const VectorXd& f) {
  const StiffMuscleProblem problem = grasp.problem;
  for (int k = 0; k < std::ssize(problem.joints); ++k) {
    const int n = problem.joints[k];
    const Eigen::MatrixXd K = finger_stiffness(problem, k, f, 0.0).topLeftCorner(n, n);
    if (K.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() < problem.kappa) return false;
  }
  return true;
}

/// The multiple of K that forces give in every direction; no number where a posture gives way.
double multiple_of(const Matrix6d& K, const std::optional<Matrix6d>& K_object) {
  if (!K_object) return kNone;
  const Matrix6d even = 0.5 * (*K_object + K_object->transpose());
  return Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d>(even, K).eigenvalues()[0];
}

// --- effort over stiffness ------------------------------------------------------------------------------------------

/// A grasp whose effort is drawn over its stiffness.
struct Case {
  std::string name, scene;
  Texts changes;
  double translation_N_per_m, rotation_Nm_per_rad;  ///< What is asked for once.
};

constexpr double kAt_s = 2.6;  // What a run lacked while it began, it then has asked for again.

std::string asked(double translation_N_per_m, double rotation_Nm_per_rad) {
  const std::string t = fmt::format("{:.6g} N/m", translation_N_per_m);
  const std::string r = fmt::format("{:.6g} N*m/rad", rotation_Nm_per_rad);
  return fmt::format("{{translation: [{0}, {0}, {0}], rotation: [{1}, {1}, {1}]}}", t, r);
}

Model model_of(const Case& c, double multiple) {
  Texts changes = c.changes;
  changes.push_back(fmt::format("control.muscles={{stiffness: 23.4, object_stiffness: {}}}",
                                asked(multiple * c.translation_N_per_m, multiple * c.rotation_Nm_per_rad)));
  return build_model(coarse_scene(c.scene, changes));
}

/// Stiffness as what is asked for in translation, and effort.
struct Points {
  std::vector<double> x_N_per_m, effort_N;

  void add(double x, double effort) {
    x_N_per_m.push_back(x);
    effort_N.push_back(effort);
  }
};

/// What a run that asks for this multiple has: stiffness by probes, effort by the muscles' forces.
std::pair<double, double> measured(const Case& c, double multiple) {
  const Model model = model_of(c, multiple);
  const GraspAt grasp(model, kAt_s, Acting::kMuscles);
  const PredictedStiffness predicted = predict_stiffness(grasp.run);
  // What rests does not feel viscosities, and a percent of the way is less than a marker.
  const auto probed = probe_stiffness(grasp, predicted, {.rest = 5e-3, .viscosity = 0.02});
  const auto& wanted = *model.scene.control->muscles->object_stiffness;
  const Matrix6d K = wanted_stiffness(wanted, Eigen::Isometry3d::Identity()) / multiple;
  const double has = probed && probed->is_finite ? multiple_of(K, probed->K_O) : kNone;
  return {has, grasp.run.state.muscle_N.norm()};
}

/// A front, ways that have the same torques, and runs; and what is to be said of them.
struct Front {
  Points front, all_muscles, pattern, runs;
  bool least_stands = false;  ///< With the least forces that have these torques.
  double least_N = 0.0, end_N_per_m = 0.0, most_N = 0.0;
  double off_stiffness = 0.0;  ///< The largest share by which a run's stiffness is off what it asks for,
  double off_effort = 0.0;     ///< and its effort off the front's there.
  std::string end;
};

/// The front's effort at a stiffness, between its points.
double at(const Points& front, double x) {
  const auto after = std::ranges::upper_bound(front.x_N_per_m, x) - front.x_N_per_m.begin();
  const auto i = std::clamp<std::ptrdiff_t>(after, 1, std::ssize(front.x_N_per_m) - 1);
  const double share = (x - front.x_N_per_m[i - 1]) / (front.x_N_per_m[i] - front.x_N_per_m[i - 1]);
  return front.effort_N[i - 1] + share * (front.effort_N[i] - front.effort_N[i - 1]);
}

/// Points of forces that depend on a number, from 0 on, while there are any.
template <typename ForcesOf>
Points sampled(const StiffGrasp& grasp, const Case& c, double step, const ForcesOf& forces_of) {
  Points points;
  for (double t = 0.0;; t += step) {
    const std::optional<StiffForces> found = forces_of(t);
    if (!found) return points;
    const double multiple = multiple_of(grasp.K_scene, found->K_object);
    if (multiple >= 0.0 && keeps_postures(grasp, found->forces_N))
      points.add(multiple * c.translation_N_per_m, found->effort_N());
  }
}

Front front_of(const Case& c, bool quick) {
  const Model model = model_of(c, 0.5);
  GraspRun run(model);
  while (run.time_s() < kAt_s - 0.5 * model.scene.step_s) run.tick();
  StiffGrasp grasp(run);
  grasp.K_scene *= 2.0;
  const StiffEnd end = stiff_end(grasp, grasp.K_scene);
  const std::optional<StiffForces> least = least_forces(grasp);
  Front all;
  if (!end.most || !least) throw std::runtime_error(c.name + ": no forces of its muscles make it stand");
  constexpr int kPoints = 24;
  for (int i = 0; i <= kPoints; ++i) {
    const double left = 1.0 - static_cast<double>(i) / kPoints;  // Closer together where it is steep.
    const auto found = stiff_forces(grasp, grasp.K_scene, (1.0 - left * left) * end.near->asked);
    if (found) all.front.add(found->asked * c.translation_N_per_m, found->effort_N());
  }
  const VectorXd first = stiff_forces(grasp, grasp.K_scene, 0.0)->forces_N - least->forces_N;
  all.all_muscles = sampled(grasp, c, 0.002, [&](double activation) { return raised(grasp, activation); });
  all.pattern = sampled(grasp, c, 0.1, [&](double t) -> std::optional<StiffForces> {
    const VectorXd f = least->forces_N + t * first;
    if ((f - grasp.problem.limit).maxCoeff() > 0.0 || f.minCoeff() < -1e-9) return std::nullopt;
    return with_stiffness(grasp, f, t);
  });
  all.least_N = least->effort_N();
  all.least_stands = least->is_stable();
  all.most_N = end.near->effort_N();
  all.end_N_per_m = end.most->asked * c.translation_N_per_m;
  all.end = end_in_words(model.scene.hand, end.beyond);
  const std::vector<double> shares = quick ? std::vector{0.3, 0.8} : std::vector{0.2, 0.55, 0.9};
  std::vector<std::pair<double, double>> runs(shares.size());
  tbb::parallel_for(std::size_t{0}, shares.size(),
                    [&](std::size_t i) { runs[i] = measured(c, shares[i] * end.most->asked); });
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto& [multiple, effort_N] = runs[i];
    const double wanted = shares[i] * end.most->asked;
    all.runs.add(multiple * c.translation_N_per_m, effort_N);
    all.off_stiffness = std::max(all.off_stiffness, std::abs(multiple / wanted - 1.0));
    const double least_N = stiff_forces(grasp, grasp.K_scene, wanted).value().effort_N();
    all.off_effort = std::max(all.off_effort, std::abs(effort_N / least_N - 1.0));
  }
  return all;
}

ordered_json panel_of(const std::string& name, const Front& all) {
  return {{"name", name},
          {"curves",
           {plain_curve("least effort", all.front.x_N_per_m, all.front.effort_N),
            plain_curve("all muscles raised alike", all.all_muscles.x_N_per_m, all.all_muscles.effort_N),
            plain_curve("the first stable pattern, scaled", all.pattern.x_N_per_m, all.pattern.effort_N),
            plain_curve("runs: stiffness by probes", all.runs.x_N_per_m, all.runs.effort_N),
            theory_curve("the end of the range", {all.end_N_per_m, all.end_N_per_m}, {0.0, 1.1 * all.most_N})}}};
}

/// The effort of a way over the least at the same stiffness, in the middle of what it reaches.
double times_least(const Points& way, const Points& front) {
  if (way.x_N_per_m.empty()) return kNone;
  const double middle = 0.5 * std::ranges::max(way.x_N_per_m);
  const auto near = std::ranges::min_element(way.x_N_per_m, {}, [&](double x) { return std::abs(x - middle); });
  return way.effort_N[near - way.x_N_per_m.begin()] / at(front, *near);
}

ordered_json row_of(const std::string& name, const Front& all) {
  const auto reach = [](const Points& points) {
    return points.x_N_per_m.empty() ? ordered_json("-") : ordered_json(std::ranges::max(points.x_N_per_m));
  };
  return {name,
          all.least_N,
          all.end_N_per_m,
          all.most_N,
          all.end,
          reach(all.all_muscles),
          times_least(all.all_muscles, all.front),
          reach(all.pattern),
          times_least(all.pattern, all.front),
          100.0 * all.off_stiffness,
          100.0 * all.off_effort};
}

void add_fronts(ordered_json& part, bool quick) {
  const std::vector<Case> cases = {
      {"box, squeeze 2 N", "box_grasp", {"task={}"}, 150.0, 0.08},
      {"box, squeeze 5 N", "box_grasp", {"task={}", "control.grasp.internal_force=5 N"}, 150.0, 0.08},
      {"handle across, squeeze 1 N", "capsule", {"task={}"}, 150.0, 0.02}};
  ordered_json panels = ordered_json::array(), rows = ordered_json::array();
  int standing = 0;
  for (const Case& c : cases) {
    const Front all = front_of(c, quick);
    standing += all.least_stands ? 1 : 0;
    panels.push_back(panel_of(c.name, all));
    rows.push_back(row_of(c.name, all));
  }
  add_run_curves(
      part, "stiffness_front", "Effort over stiffness",
      "The effort, the root of the sum of squared muscle forces, over the least stiffness that the object has along "
      "all "
      "directions, with as much about all axes on the arm of what is asked for. Torques, contacts and squeeze are the "
      "same on all curves of a panel. The front is the solver's; no forces are below or right of it. Raised alike, all "
      "muscles have one activation at least, and what torques that leaves get the least forces. The scaled pattern is "
      "what is added to the least forces until the object just stands, times a number. Points are runs that ask for a "
      "stiffness: what they have is measured by pushes and turns of the object.",
      "least stiffness [N/m]", "effort [N]", panels);
  ordered_json& figure = add_figure(
      part, "table", "stiffness_ends", "The end of the range, and what ends it",
      fmt::format(
          "The numbers of the figure above. With the least forces the object stands in {} of {}. How many times "
          "the least effort a way takes is at half of the stiffness that it reaches.",
          standing, cases.size()),
      "As above.");
  figure["columns"] = {"grasp",
                       "effort of the least forces [N]",
                       "end of the range [N/m]",
                       fmt::format("effort at {:g} of it [N]", kNearEnd),
                       "what ends it",
                       "raised alike, muscles reach [N/m]",
                       "their effort, times the least",
                       "the scaled pattern reaches [N/m]",
                       "and takes, times the least",
                       "runs off the stiffness that they ask for by [%]",
                       "and off its least effort by [%]"};
  figure["rows"] = rows;
}

// --- stability ------------------------------------------------------------------------------------------------------

constexpr double kFrozen_s = 0.5, kPush_N = 0.2;
constexpr double kTranslation_N_per_m = 150.0, kRotation_Nm_per_rad = 0.08;  // Of configs/box_stiff.yaml.

// A tenth of the scene's viscosities makes all of it ten times as fast.
Texts frozen() {
  return {"object.points=6000",
          "time.duration=2.2 s",
          "hand.joint_viscosity=0.005 N*m*s",
          "object.damping={translation: 1 N*s/m, rotation: 0.0005 N*m*s}",
          fmt::format("task.push={{force: [0 N, {:g} N, 0 N], from: 0.6 s, over: 0.4 s, rise: 50 ms}}", kPush_N),
          fmt::format("control.muscles.frozen_from={:g} s", kFrozen_s)};
}

const MapAxis kSqueeze{"control.grasp.internal_force", "N", 0.5, 8.0, "squeeze [N]"};
const MapAxis kMultiple{"control.muscles.object_stiffness",
                        "",
                        0.03,
                        4.0,
                        "least stiffness [N/m]",
                        [](double m) { return m * kTranslation_N_per_m; },
                        [](double m) { return asked(m * kTranslation_N_per_m, m * kRotation_Nm_per_rad); }};

/// The scene with the least forces, at the time when excitations would freeze.
Model with_least_forces(Model model) {
  model.scene.control->muscles->object_stiffness.reset();
  return model;
}

/// What takes as much effort as the least forces of a stiffness, or as the most that there is.
double same_effort_activation(const StiffGrasp& grasp, const Matrix6d& K) {
  const auto found = stiff_forces(grasp, K, 1.0);
  const StiffEnd end = found ? StiffEnd{} : stiff_end(grasp, K);
  if (!found && !end.most) return 0.0;
  return raised_activation(grasp, found ? found->effort_N() : end.near->effort_N());
}

/// A run whose muscles all have some activation until they freeze: the effort is that of the stiffness.
Recording run_raised(const Model& model) {
  const ObjectStiffness wanted = *model.scene.control->muscles->object_stiffness;
  const Model own = with_least_forces(model);
  const GraspAt at(own, kFrozen_s, Acting::kControl);
  const StiffGrasp grasp(at.run);
  const double activation = same_effort_activation(grasp, wanted_stiffness(wanted, grasp.X_WO));
  RunSettings settings;
  settings.own.muscles = [&](ControlPeriod& period) -> VectorXd {
    const Eigen::MatrixXd& H = period.moment_arms();
    for (const double share : {1.0, 0.95, 0.9, 0.8, 0.6, 0.4, 0.2}) {
      if (auto f = raised(H, period.torques(), grasp.problem.limit, share * activation)) return *f;
    }
    return published_muscle_forces(period);
  };
  State state(own);
  return run_scene(own, state, settings);
}

/// Where, over the squeeze, the range ends; and where all muscles raised alike, at the same effort, begin to stand.
struct Borders {
  MapLimit end{"the end of the range", {}, {}};
  MapLimit stands{"slowest predicted rate = 0: stands above", {}, {}};
  int within = 0, standing = 0;  ///< Cells in the range, and those of them that stand by the least effort's rates.
};

Borders borders(int count) {
  const std::vector<double> squeezes = kSqueeze.values(count);
  std::vector<std::pair<double, double>> found(squeezes.size(), {kNone, kNone});
  std::vector<std::pair<int, int>> cells(squeezes.size());
  tbb::parallel_for(std::size_t{0}, squeezes.size(), [&](std::size_t i) {
    Texts changes = frozen();
    changes.push_back(fmt::format("control.grasp.internal_force={:g} N", squeezes[i]));
    const Model model = with_least_forces(build_model(coarse_scene("box_cocontract", changes)));
    const GraspAt at(model, kFrozen_s, Acting::kControl);
    const StiffGrasp grasp(at.run);
    const Matrix6d K = grasp.wanted(kTranslation_N_per_m, kRotation_Nm_per_rad);
    const StiffEnd end = stiff_end(grasp, K);
    if (end.most) found[i].first = kMultiple.show(end.most->asked);
    for (const double multiple : kMultiple.values(count)) {
      const auto forces = stiff_forces(grasp, K, multiple);
      if (!forces) continue;
      ++cells[i].first;
      cells[i].second += predict_stiffness(at.run, forces->forces_N).is_stable() ? 1 : 0;
    }
    const auto stands = [&](double multiple) {
      const auto forces = raised(grasp, same_effort_activation(grasp, multiple * K));
      return forces && predict_stiffness(at.run, forces->forces_N).is_stable();
    };
    double low = kMultiple.low, high = kMultiple.high;
    if (stands(low) || !stands(high)) return;
    for (int k = 0; k < 12; ++k) {
      const double middle = std::sqrt(low * high);
      (stands(middle) ? high : low) = middle;
    }
    found[i].second = kMultiple.show(high);
  });
  Borders all;
  for (std::size_t i = 0; i < squeezes.size(); ++i) {
    const auto add = [&](double y, MapLimit& line) {
      if (!(y >= kMultiple.show(kMultiple.low) && y <= kMultiple.show(kMultiple.high))) return;
      line.x.push_back(squeezes[i]);
      line.y.push_back(y);
    };
    add(found[i].first, all.end);
    add(found[i].second, all.stands);
    all.within += cells[i].first;
    all.standing += cells[i].second;
  }
  return all;
}

std::string squeeze_caption(const Borders& lines) {
  return fmt::format(
      "What becomes of a box whose muscles keep their excitations from 0.5 s on, over the squeeze and the stiffness "
      "that was asked for before, along as about all axes (0.08 N m/rad where 150 N/m). It is pushed by {:g} N for 0.4 "
      "s and watched for 1.2 s more, with a tenth of the viscosities of configs/box_cocontract.yaml. For the least "
      "effort the slowest predicted rate is positive in {} of {} cells within the range. Above the end "
      "of the range a run says which motion and muscles end it, or has taken less by 0.5 s and holds as it is; near "
      "the "
      "bottom, what was asked for hardly resists the push. The other panel "
      "has the same effort, or the most that there is, in all muscles raised alike, and less stiffness: below the line "
      "of its own the slowest predicted rate is negative, and near that line the box turns away more slowly than is "
      "watched.",
      kPush_N, lines.standing, lines.within);
}

void add_squeeze_map(ordered_json& part, bool quick) {
  const int count = quick ? 5 : 8;
  const Borders lines = borders(count);
  const double soft = kPush_N / kOffTarget_m;
  const MapLimit too_soft{"the push moves it 10 mm", {kSqueeze.low, kSqueeze.high}, {soft, soft}};
  OutcomeMap map{
      "stiffness_squeeze",
      "Squeeze and stiffness",
      squeeze_caption(lines),
      kSqueeze,
      kMultiple,
      frozen(),
      {},
      {{"least effort for the stiffness", true, [](const Model& model) { return run(model); }, {lines.end, too_soft}},
       {"all muscles raised alike, the same effort", false, run_raised, {lines.end, lines.stands}}},
      {{2.0, kTranslation_N_per_m}},
      "box_cocontract"};
  add_map(part, map, count);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "stiffness", "Stiffness that is chosen",
      "Muscles that pull against one another make a grasp stiffer, at an effort. The solver finds the least "
      "effort for a stiffness, and where there is no more.",
      {add_fronts, add_squeeze_map});
}
