// SPDX-License-Identifier: Apache-2.0
// Where methods fail: what becomes of the grasp of configs/box_grasp.yaml over pairs of settings, by our method and by
// the plain ones that it replaces; and how far each of its settings may go.
//   stability_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "bench/methods/plain_contact.h"
#include "bench/report/figure.h"
#include "bench/report/margins.h"
#include "bench/report/outcome_map.h"
#include "engine/control/control_tick.h"
#include "engine/environment/minimum_jerk.h"
#include "engine/models/build_model.h"
#include "engine/models/surface_model.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;
using Texts = std::vector<std::string>;

constexpr const char* kText =
    "Each cell is one run of configs/box_grasp.yaml: three soft fingertips grip a box of 100 g, and carry it 20 mm. "
    "Held: none of the following. Over limits: a joint left its range, or a muscle was asked for more than it has. Off "
    "target: the object went 10 mm or 20 degrees off its target. Slipping: a patch slid by 0.1 mm, or a finger lost "
    "its load. Unstable: forces chatter by 1 % and more, or by 2 % and more before anything else went wrong. Lost: "
    "fewer than two fingers carried load, or one slid by more than its pulp's radius. The gravest is the word, the "
    "reason has all. Solver failed: a solve found no answer, or there is none. The reason of every cell is in the data "
    "behind the figure. The runs of the maps are shorter than the scene's, 1.2 s with the move from 0.4 s to 0.9 s, "
    "and the box has 9000 points; all else is as in the scene, unless the caption says so.";

const Texts kShort = {"time.duration=1.2 s", "task.translate.over=0.5 s", "object.points=9000"};

Texts shortened(Texts more) {
  more.insert(more.begin(), kShort.begin(), kShort.end());
  return more;
}

Model short_model(const Texts& more = {}) {
  return build_model(load_scene(std::string(THENAR_CONFIGS) + "/box_grasp.yaml", shortened(more)));
}

Recording ours(const Model& model) {
  State state(model);
  return run_scene(model, state);
}

Recording ours_in_lockstep(const Model& model) {
  State state(model);
  return run_scene(model, state, {.lockstep = LockstepSettings{}});
}

auto plain(ContactLaw law) {
  return [law](const Model& model) { return run_plain(model, {law}); };
}

// --- a step and stiffness -------------------------------------------------------------------------------------------

constexpr double kScenePulp_Pa = 0.24e6;

/// A pulp's stiffness under a given load goes with E*^(2/3), and so does the controller's model of it.
void scale_pulp_model(Scene& scene) {
  const double ratio = std::pow(scene.fingertips->material.reduced_modulus_Pa / kScenePulp_Pa, 2.0 / 3.0);
  scene.control->pulp_normal_N_per_m *= ratio;
  scene.control->pulp_tangential_N_per_m *= ratio;
}

MapLimit penalty_limit_by_modulus(const MapAxis& modulus, int count) {
  MapLimit limit{"explicit Euler is stable left of 2 / λ_max(J B⁻¹ Jᵀ K)", {}, {}};
  for (const double MPa : modulus.values(count)) {
    Model model = short_model({fmt::format("fingertips.reduced_modulus={} MPa", MPa)});
    scale_pulp_model(model.scene);
    const double limit_s = penalty_step_limit(model, 0.1e-3, 0.2)(model.scene);
    if (!std::isfinite(limit_s)) continue;
    limit.x.push_back(1e3 * limit_s);
    limit.y.push_back(MPa);
  }
  return limit;
}

OutcomeMap step_stiffness(int count) {
  const MapAxis step{"time.step", "ms", 0.25, 20.0, "step [ms]"};
  const MapAxis modulus{"fingertips.reduced_modulus", "MPa", 0.01, 10.0, "modulus E* of the pulps [MPa]"};
  const auto adapt = [](Model& model) {
    model.scene.control_period_s = std::max(1e-3, model.scene.step_s);
    scale_pulp_model(model.scene);
  };
  return {"step_stiffness",
          "Step and stiffness",
          "The time step against the stiffness of the fingertips. Ours solves for the forces at the end of the step. "
          "The plain alternative takes them from springs at its start: a bed of springs, one a control point, that "
          "takes Hertz's force at the depth R/8, and tangential springs that slide at Coulomb's limit; explicit Euler "
          "on the same viscous bodies. Right of the line its springs overshoot. Where ours fails at 0.01 MPa and short "
          "steps it holds, for its pulps are stiffer: a bed's force grows with the square of the depth, Hertz's with "
          "its power 3/2, so that at the depth R the bed bears 2.8 times Hertz's force. At the scene itself both hold; "
          "the plain one has little room left. Control runs every millisecond, or every step where steps are longer; "
          "its model of the pulps, K_n and K_t, goes with their stiffness. Ours fails below 0.023 MPa: there 2 N press "
          "a pulp in by more than its radius, 8 mm, by Hertz's law.",
          step,
          modulus,
          shortened({"time.control_period=20 ms"}),
          adapt,
          {{"ours", true, ours},
           {"explicit penalty", false, plain(ContactLaw::kPenalty), {penalty_limit_by_modulus(modulus, count)}}},
          {{1.0, 0.24}}};
}

// --- W of the wrong step --------------------------------------------------------------------------------------------

OutcomeMap wrong_step(int /*count*/) {
  const auto stale = [](const Model& model) {
    return run_plain(model, {ContactLaw::kWrongStep, model.scene.control_period_s});
  };
  return {"wrong_step",
          "W of the wrong step",
          "The Delassus operator W(h) = h J B⁻¹ Jᵀ + (1 - ρ(h)) C holds the step h. A control loop that "
          "assembles it once for its own period, and hands it to a contact loop with a shorter step, hands "
          "over another law: forces come out too small by up to the ratio of the two. Ours makes W of factors"
          " in every step. At the right lower corner the ratio is 80, at the left upper one 1, where the two "
          "are the same.",
          {"time.control_period", "ms", 1.0, 20.0, "control period, for which the plain method makes W [ms]"},
          {"time.step", "ms", 0.25, 1.0, "contact step [ms]"},
          shortened({}),
          {},
          {{"ours", true, ours}, {"W of the control period", false, stale}},
          {{1.0, 1.0}}};
}

// --- friction and squeeze -------------------------------------------------------------------------------------------

constexpr double kShare = 0.9;  // mu_c over mu.

/// Friction that forces of this squeeze need, when nothing but the squeeze and the weight asks for them.
MapLimit friction_limit(const MapAxis& squeeze, int count) {
  MapLimit limit{"left of it static grasp forces exist only with more squeeze than asked", {}, {}};
  for (const double squeeze_N : squeeze.values(count)) {
    const Model model = short_model({fmt::format("control.grasp.internal_force={} N", squeeze_N),
                                     "control.grasp.friction=10", "control.grasp.cone=exact"});
    const State state(model);
    Frame frame(model);
    Controller controller(model);
    const ControlReport report = control_tick(model, state, controller, frame);
    if (report.grasp != GraspStatus::kOptimal) continue;
    double needed = 0.0;
    for (int k = 0; k < model.fingers(); ++k) {
      const Eigen::Vector3d f_C = report.contacts[k].axes.transpose() * report.f_desired.col(k);
      needed = std::max(needed, f_C.tail<2>().norm() / f_C[0]);
    }
    limit.x.push_back(needed / kShare);
    limit.y.push_back(squeeze_N);
  }
  return limit;
}

OutcomeMap friction_squeeze(int count) {
  const MapAxis friction{"contact.friction", "", 0.05, 1.5, "friction μ"};
  const MapAxis squeeze{"control.grasp.internal_force", "N", 0.1, 20.0, "squeeze λ [N]"};
  const auto adapt = [](Model& model) {
    model.scene.control->grasp_friction = kShare * model.scene.contact.friction;
    model.scene.control->cone = FrictionCone::kExact;
  };
  const auto with_pyramid = [](const Model& model) {
    Model own = model;
    own.scene.control->cone = FrictionCone::kPyramid;
    return own;
  };
  const std::vector<MapLimit> limit = {friction_limit(squeeze, count)};
  return {
      "friction_squeeze",
      "Friction and squeeze",
      "Friction of the contacts against the squeeze that the grasp forces are biased to. The controller plans with 0.9 "
      "of the friction that there is. Ours plans inside round cones. The published pyramid, planned with the same "
      "number, allows 1.27 μ at its corners, which the contacts do not have: its forces slip. (The scene plans with "
      "0.55 in pyramids at a friction of 0.8, so that the star's cell is not the scene's own run.) In the third panel "
      "the contacts have a pyramid, too, as in engines of games (|f_t1|, |f_t2| <= μ f_n, by projected Gauss-Seidel), "
      "whose corners are turned against those of the plan. Left of the line grasp forces squeeze harder than asked. "
      "Ours fails at the left edge and in the left upper corner, where that takes some 10 N and more of a finger: by "
      "Hertz's law 10 N press a pulp in by 5 mm of its 8 mm, and fingers that slip so deep leave the object.",
      friction,
      squeeze,
      shortened({}),
      adapt,
      {{"ours: exact cones", true, ours, limit},
       {"grasp forces in pyramids", false, [=](const Model& m) { return ours(with_pyramid(m)); }, limit},
       {"pyramids in plan and contacts", false,
        [=](const Model& m) { return run_plain(with_pyramid(m), {ContactLaw::kBoxFriction}); }, limit}},
      {{0.8, 2.0}}};
}

// --- control period and gain ----------------------------------------------------------------------------------------

OutcomeMap period_gain(int count) {
  const MapAxis period{"time.control_period", "ms", 1.0, 20.0, "control period T_c [ms]"};
  MapLimit limit{"K = 2 b / T_c", {}, {}};
  for (const double ms : period.values(count)) {
    limit.x.push_back(ms);
    limit.y.push_back(2.0 * 0.05 / (1e-3 * ms));
  }
  const auto paper = [](const Model& model) {
    Model own = model;
    own.scene.control->law = ControlLaw::kPaper;
    return ours(own);
  };
  return {"period_gain",
          "Control period and gain",
          "The control period against the gain K of the force control, contact at 1 kHz. Sampled with the period, the "
          "loop multiplies a force error by about 1 - K T_c / b in each, and is stable below the line; the lag of the "
          "pulp's filter, and a pulp softer than the controller's model of it, leave some more room at short periods: "
          "how much at 1 ms is in the table of margins. Above, the forces chatter and the box is lost, or the first "
          "torques throw it off its target or leave no forces that hold it: for us, too, and there is no way round it "
          "but a shorter period. With feed-forward any smaller gain holds; the published law, torque by the force "
          "error alone, lets the box go where K is too small to hold it. `gain: auto` takes 0.3 of the line.",
          period,
          {"control.gain", "N*m/rad", 0.1, 1000.0, "gain K [N m/rad]"},
          shortened({}),
          {},
          {{"ours: feed-forward", true, ours, {limit}}, {"published law", false, paper, {limit}}},
          {{1.0, 30.0}}};
}

// --- delay and speed ------------------------------------------------------------------------------------------------

OutcomeMap delay_speed(int /*count*/) {
  constexpr double kMove_mm = 20.0;
  constexpr double kPeriod_s = 5e-3, kBlindGain = 0.3 * 2.0 * 0.05 / kPeriod_s;
  const MapAxis delay{"time.control_delay", "ms", 0.5, 50.0, "delay of the frames [ms]"};
  const MapAxis speed{"task.translate.over", "s", 2.0, 0.05, "largest speed of the move [mm/s]", [](double over_s) {
                        return kMinimumJerkPeak * kMove_mm / over_s;
                      }};
  const auto adapt = [](Model& model) { model.scene.duration_s = 0.9 + model.scene.task.translate->over_s; };
  const auto blind = [=](const Model& model) {
    Model own = model;
    own.scene.control->gain = kBlindGain;
    return ours_in_lockstep(own);
  };
  const double limit_ms = 1e3 * (2.0 * 0.05 / kBlindGain - kPeriod_s);
  const std::vector<double> speeds = {speed.show(speed.low), speed.show(speed.high)};
  // Of the scene: p / b_t = 30 1/s. A delayed integrator's limit, and the speed at which it lags 10 mm.
  const double late_ms = 1e3 * (std::numbers::pi / 2.0 / 30.0 - kPeriod_s), fast_mm_per_s = 10.0 * 30.0;
  const std::vector<MapLimit> pid = {
      {"PID: p (T_c + delay) / b_t = π/2", {late_ms, late_ms}, speeds},
      {"PID: speed * b_t / p = 10 mm", {delay.low, delay.high}, {fast_mm_per_s, fast_mm_per_s}}};
  return {"delay_speed",
          "Delay and speed",
          "How late the frames of the control loop come against how fast the target moves; contact at 1 kHz, control "
          "every 5 ms, two clocks in lockstep. Ours takes the gain that period and delay allow, 0.6 * 2 b / (T_c + "
          "delay) at most, and hands frames over with an offset that keeps the gaps. A gain chosen for the period "
          "alone, K = 6, is beyond the loop's limit right of the line. All fail at the right, where the PID of the "
          "pose comes too late, and at the top, where it lags: the box resists with 10 N s/m, which takes an error of "
          "33 mm per m/s, and 10 mm count as off target.",
          delay,
          speed,
          shortened({"time.control_period=5 ms"}),
          adapt,
          {{"ours", true, ours_in_lockstep, pid},
           {"gain blind to the delay", false, blind, {{"K = 2 b / (T_c + delay)", {limit_ms, limit_ms}, speeds}}}},
          std::nullopt};
}

// --- viscosity ------------------------------------------------------------------------------------------------------

constexpr double kShortMove_mm = 2.0;  // A drag by the object's damping is not what this map is about.

/// Where the penalty's springs reach the limit of the scene's step: the joint viscosity, by the object's damping.
MapLimit penalty_limit_by_viscosity(const MapAxis& joint, const MapAxis& object, int count,
                                    double rotation_per_translation) {
  MapLimit limit{"explicit Euler is stable right of it", {}, {}};
  Scene scene = short_model().scene;
  const auto limit_s = penalty_step_limit(short_model(), 0.1e-3, 0.2);
  for (const double b_t : object.values(4 * count)) {
    scene.object.translation_damping = b_t;
    scene.object.rotation_damping = rotation_per_translation * b_t;
    double low = 0.1 * joint.low, high = 10.0 * joint.high;
    const auto is_stable = [&](double b) {
      scene.joint_viscosity = b;
      return limit_s(scene) > scene.step_s;
    };
    if (!is_stable(high) || is_stable(low)) continue;
    for (int i = 0; i < 20; ++i) {
      const double middle = std::sqrt(low * high);
      (is_stable(middle) ? high : low) = middle;
    }
    limit.x.push_back(high);
    limit.y.push_back(b_t);
  }
  return limit;
}

OutcomeMap viscosity(int count) {
  constexpr double kRotationPerTranslation = 5e-4;  // the scene's, m^2
  const MapAxis joint{"hand.joint_viscosity", "N*m*s", 5e-5, 5.0, "viscosity b of the joints [N m s]"};
  const MapAxis object{"object.damping.translation", "N*s/m", 0.3, 1000.0, "damping b_t of the object [N s/m]"};
  const auto adapt = [](Model& model) {
    model.scene.object.rotation_damping = kRotationPerTranslation * model.scene.object.translation_damping;
    model.scene.task.translate->amount = 1e-3 * kShortMove_mm;
  };
  return {
      "viscosity",
      "Viscosity",
      "The viscosity of the joints against that of the object, its rotation scaled alike; their ratio is what plain "
      "Gauss-Seidel sweeps are known to stall on. The move is 2 mm, lest the object's drag decide. Plain sweeps have "
      "the same tolerance and budget, 200 sweeps, on the whole matrix, and are not accelerated: they take longer, and "
      "hold as much or nearly so. Springs at the start of the step overshoot where either body moves too easily: left "
      "of and below the line. Ours fails at the left edge: the tolerance of a solve, 1e-6, is relative to the free "
      "motion of a tick, which is a thousand times the scene's where the joints resist so little, and what is left of "
      "it lets fingers creep. With `contact.tolerance=1e-9` and 1000 sweeps it holds there, too. The damping starts at "
      "0.3 N s/m: at a tenth of that gravity moves a box that nothing holds yet by 33 mm in the first tick.",
      joint,
      object,
      shortened({}),
      adapt,
      {{"ours", true, ours},
       {"plain sweeps", false, plain(ContactLaw::kPlainSweeps)},
       {"explicit penalty",
        false,
        plain(ContactLaw::kPenalty),
        {penalty_limit_by_viscosity(joint, object, count, kRotationPerTranslation)}}},
      {{0.05, 10.0}}};
}

// --- contacts and redundancy ----------------------------------------------------------------------------------------

/// The published gaussian with the width that the scene's 320 control points give it, whatever their number.
Model with_fixed_gaussian(const Model& model) {
  constexpr double kSigma2PerArea = 0.36, kDepthPerRadius = 1.0 / 8.0, kSceneControls = 320.0;
  Model own = model;
  set_fingertips(own, PulpKernel::kGaussian, model.level);
  for (Pulp& pulp : own.pulps) {
    const double sigma2 = kSigma2PerArea * pulp.area_m2.sum() / kSceneControls;
    const double peak =
        3.0 * std::sqrt(kDepthPerRadius) * pulp.radius_m / (8.0 * pulp.material.reduced_modulus_Pa * sigma2);
    const Eigen::Matrix3Xd& p = pulp.control_points_m;
    for (Eigen::Index j = 0; j < pulp.controls(); ++j) {
      pulp.kernel.col(j) =
          peak * (-(p.colwise() - p.col(j)).colwise().squaredNorm().transpose().array() / (2.0 * sigma2)).exp();
    }
    pulp.rounded_kernel = pulp.kernel.cast<float>();
    pulp.a = (pulp.tangential - 1.0) * pulp.kernel;
  }
  return own;
}

OutcomeMap redundancy(int /*count*/) {
  const auto gaussian = [](const Model& model) {
    Model own = model;
    set_fingertips(own, PulpKernel::kGaussian, model.level);
    return ours(own);
  };
  return {"redundancy",
          "Contacts and redundancy",
          "How many control points a fingertip has against how many of them may be contacts. Where contacts lie closer "
          "together than the kernel is wide, rows of W become alike. Ours is the kernel of an elastic half space; the "
          "plain ones are the published gaussian, its width following the spacing of the points, and the same with the "
          "width fixed at that of 320 points. Ours fails at the right bottom, where 2 to 4 of several hundred points "
          "may be contacts: a spot far smaller than the patch that the load presses; the forces chatter.",
          {"fingertips.leaves", "count", 40.0, 800.0, "control points of a fingertip"},
          {"contact.max_per_finger", "count", 2.0, 40.0, "most contacts of a finger"},
          shortened({}),
          {},
          {{"ours: half space", true, ours},
           {"gaussian", false, gaussian},
           {"gaussian of fixed width", false, [](const Model& model) { return ours(with_fixed_gaussian(model)); }}},
          {{320.0, 20.0}}};
}

// --- margins --------------------------------------------------------------------------------------------------------

/// A key that is a number with a unit.
MarginKey simple(const std::string& name, const std::string& key, double value, const std::string& unit) {
  return {name, unit, value, [key, unit](double v) { return Texts{fmt::format("{}={:.8g} {}", key, v, unit)}; }};
}

MarginKey counted(const std::string& name, const std::string& key, double value, double most) {
  return {name, "", value, [key](double v) { return Texts{fmt::format("{}={:.0f}", key, v)}; }, most, false, true};
}

std::vector<MarginKey> margin_keys(double move_s) {
  std::vector<MarginKey> keys = {
      simple("friction μ", "contact.friction", 0.8, ""),
      simple("squeeze λ", "control.grasp.internal_force", 2.0, "N"),
      simple("friction μ_c that is planned with (pyramid)", "control.grasp.friction", 0.55, ""),
      simple("gain K", "control.gain", 30.0, "N*m/rad"),
      simple("control period, K with it", "time.control_period", 1.0, "ms"),
      {"step and control period, K with it", "ms", 1.0,
       [](double v) {
         return Texts{fmt::format("time.step={:.8g} ms", v), fmt::format("time.control_period={:.8g} ms", v)};
       },
       20.0},
      {"delay of the frames (control every 5 ms)", "ms", 5.0,
       [](double v) {
         return Texts{"time.control_period=5 ms", fmt::format("time.control_delay={:.8g} ms", v)};
       },
       20.0, true},
      simple("modulus E* of the pulps", "fingertips.reduced_modulus", 0.24, "MPa"),
      simple("relaxation of the pulps", "fingertips.relaxation", 2.0, "ms"),
      simple("viscosity of the joints", "hand.joint_viscosity", 0.05, "N*m*s"),
      {"damping of the object", "N*s/m", 10.0,
       [](double v) {
         return Texts{fmt::format("object.damping.translation={:.8g} N*s/m", v),
                      fmt::format("object.damping.rotation={:.8g} N*m*s", 5e-4 * v)};
       }},
      simple("mass of the object", "object.mass", 100.0, "g"),
      simple("time that the move takes", "task.translate.over", move_s, "s"),
      simple("gain p of the position", "control.position.p", 300.0, "N/m"),
      simple("tolerance of the contact solver", "contact.tolerance", 1e-6, ""),
      counted("most sweeps", "contact.max_sweeps", 200.0, 100.0),
      counted("most contacts a finger", "contact.max_per_finger", 20.0, 20.0),
      counted("samples of the box", "object.points", 36000.0, 4.0)};
  return keys;
}

/// Three digits, as people write them.
std::string with_unit(double value, const MarginKey& key) {
  if (std::isnan(value)) return "";
  const double place = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  const std::string number =
      value >= 1000.0 ? fmt::format("{:.0f}", place * std::round(value / place)) : fmt::format("{:.3g}", value);
  return number + (key.unit.empty() ? "" : " ") + key.unit;
}

std::string what_becomes(const Margin& margin) {
  if (std::isnan(margin.fails)) return fmt::format("holds to the end of what was tried (x{:g})", margin.ratio);
  if (margin.there.outcome == Outcome::kRefused) return "outside what the program accepts";
  return fmt::format("{}: {}", to_string(margin.there.outcome), margin.there.reason);
}

void add_margins(ordered_json& part, bool quick) {
  const Texts overrides = quick ? kShort : Texts{};
  const double move_s = quick ? 0.5 : 0.8, accuracy = quick ? 1.6 : 1.05;
  const std::vector<MarginKey> keys = margin_keys(move_s);
  struct Row {
    const MarginKey* key;
    Margin margin;
  };
  std::vector<Row> rows;
  for (const MarginKey& key : keys) rows.insert(rows.end(), 2, {&key, {}});
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
    rows[i].margin = find_margin(*rows[i].key, i % 2 == 1, overrides, accuracy);
  });
  // Where the program or the search ends is no failure: those come last.
  std::ranges::stable_sort(rows, {}, [](const Row& row) {
    return std::pair(std::isnan(row.margin.fails) || row.margin.there.outcome == Outcome::kRefused, row.margin.ratio);
  });

  ordered_json& figure = add_figure(
      part, "table", "margins", "Margins of the reference scene",
      fmt::format("How far each setting of configs/box_grasp.yaml may go, all others as they are, before the box is no "
                  "more held, the nearest first, then those that do not fail: tried at ratios that grow by 2.5, up to "
                  "100 at most, and halved between the last that holds and the first that does not to {:.0f} %. Where "
                  "a setting holds again beyond its first failure, that is not seen. The row of the delay starts from "
                  "a scene of its own, with control every 5 ms and as much delay: the scene itself has none.{}",
                  100.0 * (accuracy - 1.0), quick ? " The scene is the maps' shorter one." : ""),
      "One deterministic run each, on a virtual clock: no times are measured.");
  figure["columns"] = {"setting",    "it starts from",    "way", "last that holds", "first that does not",
                       "ratio held", "what becomes of it"};
  figure["rows"] = ordered_json::array();
  for (const auto& [key, margin] : rows) {
    figure["rows"].push_back({key->name, with_unit(key->value, *key), margin.up ? "up" : "down",
                              with_unit(margin.holds, *key), with_unit(margin.fails, *key),
                              fmt::format("{:.3g}", margin.ratio), what_becomes(margin)});
  }
}

void add_maps(ordered_json& part, bool quick) {
  for (const auto map :
       {step_stiffness, wrong_step, friction_squeeze, period_gain, delay_speed, viscosity, redundancy}) {
    const int count = quick ? 5 : 11;
    add_map(part, map(count), count);
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "stability", "Where methods fail", kText, {add_maps, add_margins});
}
