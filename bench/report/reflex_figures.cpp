// SPDX-License-Identifier: Apache-2.0
// What a grip that answers to touch can hold, against what first-order mechanics say: slip over latency, the largest
// load and the least friction.
//   reflex_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/figure.h"
#include "bench/report/touch_runs.h"
#include "engine/control/control.h"
#include "engine/models/build_model.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/results/verdict.h"
#include "engine/studies/reflex_reach.h"

namespace thenar {
namespace {

using Eigen::Vector3d;
using nlohmann::ordered_json;

constexpr double kEvent_s = 0.8;  // When the box becomes wet, or the load comes.

std::string load_of(double N) {
  return fmt::format("task.push={{force: [0 N, 0 N, {:.6g} N], from: 0.8 s, over: 1 s, rise: 10 ms}}", -N);
}

std::string wet(double friction) { return fmt::format("task.friction=[{{at: 0.8 s, to: {:.6g}}}]", friction); }

// --- slip over latency ----------------------------------------------------------------------------------------------

constexpr double kGone_mm = 4.0;  // Runs go on until here,
constexpr double kLost_mm = 2.0;  // where the scenes count an object as lost from here on.
constexpr double kEarly_s = 0.3;  // After the event: the answer has come, the load is still there.
constexpr double kLoad_N = 1.15;

/// The time constant of a viscous finger on its pulp, at its share of a grip [s].
double press_lag_s(const Model& model, double grip_N) {
  HandPose pose;
  const State start(model);
  forward_kinematics(model.scene.hand, start.q, pose);
  double slowest_s = 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    const GraspContact contact = finger_contact(model, pose, start, k);
    const Vector3d n = contact.axes.col(0);
    const Eigen::Matrix3d yields = damped(squared(finger_jacobian(model.scene.hand, pose, k, contact.point_m)));
    const double N = 0.5 * grip_N / (k == 0 ? 1.0 : model.fingers() - 1.0);  // The thumb bears what all others do.
    const double drag = model.scene.viscosity(k) / n.dot(yields * n);
    slowest_s = std::max(slowest_s, drag * hertz_depth_m(model.pulps[k], N) / (1.5 * N));
  }
  return slowest_s;
}

/// A grip before the box becomes wet and as it is asked for after that.
struct Grip {
  double before_N = 0.0, asked_N = 0.0, lag_s = 0.0;
};

Grip grip_of(double ms) {
  const Model model = build_model(coarse_scene("box_wet", late(ms, {"task.lost=4 mm"})));
  const Recording recording = run(model);
  const auto sum = [](const PerFinger<NormalTangential>& forces) {
    double N = 0.0;
    for (const NormalTangential& force : forces) N += force.normal_N;
    return N;
  };
  Grip grip;
  for (const TickRecord& tick : recording.ticks) {
    if (tick.time_s < kEvent_s) grip.before_N = sum(tick.force);
    if (tick.time_s < kEvent_s + 1e-3 * ms + 5e-3) grip.asked_N = sum(tick.force_desired);
  }
  grip.lag_s = press_lag_s(model, grip.before_N);
  return grip;
}

/// What friction does not hold, X = w - mu N, slides at X / b_t for a latency, and on while N rises to what holds.
double law_of_wet_mm(const Scene& scene, const Grip& grip, double ms) {
  const double w = scene.object.mass_kg * scene.gravity.norm(), mu = scene.task.friction.back().friction;
  constexpr double kStep_s = 1e-4;
  double slip_m = 0.0;
  for (double s = 0.0; s < 2.0; s += kStep_s) {
    const double risen = 1.0 - std::exp(-std::max(0.0, s - 1e-3 * ms) / grip.lag_s);
    const double excess_N = w - mu * (grip.before_N + (grip.asked_N - grip.before_N) * risen);
    if (!(excess_N > 0.0)) break;
    slip_m += kStep_s * excess_N / scene.object.translation_damping;
  }
  return 1e3 * slip_m;
}

/// What must be forgiven for reflex_reach() to hold the load.
double law_of_load_mm(double ms) {
  Model model = build_model(coarse_scene("box_load", late(ms, {load_of(kLoad_N)})));
  double low = 0.0, high = kGone_mm;
  for (int i = 0; i < 7; ++i) {
    const double middle = 0.5 * (low + high);
    model.scene.task.lost_m = 1e-3 * middle;
    const auto reach = reflex_reach(model);
    (reach && reach->load_N >= kLoad_N ? high : low) = middle;
  }
  return high >= kGone_mm ? kNone : 0.5 * (low + high);
}

Scene without_reflex(Scene scene) {
  scene.control->reflex.reset();
  scene.control->felt_margin.reset();
  return scene;
}

/// Slips of the worst finger at one latency.
struct Slips {
  double early_mm = 0.0, in_all_mm = 0.0, without_mm = 0.0, law_mm = 0.0;
  bool lost = false, lost_without = false;  ///< By the end.
  double back_mm = 0.0;                     ///< What the finger went the other way, while the object slid.
};

Slips slips_of(const std::string& name, const Texts& changes, double ms) {
  const Scene scene = coarse_scene(name, late(ms, changes));
  const Recording recording = run(build_model(scene));
  const auto at = [&](double s) -> const TickRecord& {
    return *std::ranges::find_if(recording.ticks, [&](const TickRecord& tick) { return tick.is_from(s); });
  };
  const double answer_s = kEvent_s + 1e-3 * ms;
  Slips slips;
  slips.early_mm = slip_mm(recording, kEvent_s + kEarly_s);
  slips.lost = recording.verdict.lost_s.has_value();
  slips.in_all_mm = std::min(kGone_mm, slip_mm(recording));
  const Recording without = run(build_model(without_reflex(scene)));
  slips.lost_without = without.verdict.lost_s.has_value();
  slips.without_mm = std::min(kGone_mm, slip_mm(without));
  const double moved_mm = 1e3 * (at(answer_s).position_m - at(kEvent_s).position_m).norm();
  slips.back_mm = slip_mm(recording, answer_s) - slip_mm(recording, kEvent_s) - moved_mm;
  return slips;
}

using AllSlips = std::vector<Slips>;

ordered_json slip_panel(const std::string& name, const std::vector<double>& ms, const AllSlips& all) {
  const auto of = [&](double Slips::*number) {
    std::vector<double> numbers;
    for (const Slips& slips : all) numbers.push_back(slips.*number);
    return numbers;
  };
  const std::vector<double> ends = {0.0, ms.back()};
  return {{"name", name},
          {"curves",
           {plain_curve("without a reflex, at the end", ms, of(&Slips::without_mm)),
            plain_curve("with the reflex, at the end", ms, of(&Slips::in_all_mm)),
            plain_curve("with the reflex, 0.3 s after the event", ms, of(&Slips::early_mm)),
            theory_curve("first-order mechanics", ms, of(&Slips::law_mm)),
            theory_curve("2 mm, where the scene counts the box as lost", ends, {kLost_mm, kLost_mm})}}};
}

/// The largest difference from the law, in words; and which runs are lost by their end, with the reflex and without.
std::string slips_in_words(const std::vector<double>& ms, const AllSlips& all) {
  double worst_mm = 0.0, at_ms = 0.0;
  std::string lost, lost_without;
  for (std::size_t i = 0; i < ms.size(); ++i) {
    if (all[i].lost) lost += fmt::format("{} {:g}", lost.empty() ? "" : ",", ms[i]);
    if (all[i].lost_without) lost_without += fmt::format("{} {:g}", lost_without.empty() ? "" : ",", ms[i]);
    const double off_mm = all[i].early_mm - all[i].law_mm;
    if (std::abs(off_mm) > std::abs(worst_mm)) worst_mm = off_mm, at_ms = ms[i];
  }
  const auto at = [](const std::string& latencies) {
    return latencies.empty() ? std::string("none") : "at" + latencies + " ms";
  };
  return fmt::format("{:+.2f} mm at most, at {:g} ms. Lost by the end with the reflex: {}; without: {}.", worst_mm,
                     at_ms, at(lost), at(lost_without));
}

/// How much more slips without a reflex, in the mean over the latencies at which neither run is lost.
double spared_mm(const AllSlips& all) {
  double sum_mm = 0.0;
  int count = 0;
  for (const Slips& slips : all) {
    if (slips.lost || slips.lost_without) continue;
    sum_mm += slips.without_mm - slips.in_all_mm;
    ++count;
  }
  return sum_mm / count;
}

void slip_over_latency(ordered_json& part, bool quick) {
  const std::vector<double> ms = quick ? std::vector{5.0, 30.0, 65.0, 100.0, 150.0}
                                       : std::vector{5.0, 15.0, 30.0, 50.0, 65.0, 80.0, 100.0, 125.0, 150.0};
  const std::string gone = fmt::format("task.lost={:g} mm", kGone_mm);
  const Scene scene = coarse_scene("box_wet", {});
  const Grip grip = grip_of(65.0);
  AllSlips wets(ms.size()), loads(ms.size());
  tbb::parallel_for(std::size_t{0}, ms.size(), [&](std::size_t i) {
    wets[i] = slips_of("box_wet", {gone}, ms[i]);
    wets[i].law_mm = law_of_wet_mm(scene, grip, ms[i]);
    loads[i] = slips_of("box_load", {gone, load_of(kLoad_N)}, ms[i]);
    loads[i].law_mm = law_of_load_mm(ms[i]);
  });
  double back_mm = 0.0;
  for (const Slips& slips : wets) back_mm += slips.back_mm / static_cast<double>(wets.size());
  const double w = scene.object.mass_kg * scene.gravity.norm(), mu = scene.task.friction.back().friction;
  add_run_curves(
      part, "slip_latency", "Slip over latency",
      fmt::format(
          "How far the worst finger slips, when touch and pose are known so late; a run ends at {:g} mm. Left: the "
          "friction of box_wet falls to {:g}; of its weight w = {:.3g} N the grip of {:.3g} N holds {:.2g} N. The "
          "excess "
          "X = w - μ N slides at X / b_t = {:.3g} mm/s for the latency, and on while the grip rises with a time "
          "constant "
          "of {:.0f} ms. Measured less predicted, 0.3 s after the event: {} Fingers and pulps that are let go of go "
          "{:.2f} "
          "mm the other way, in the mean; the prediction leaves that out. Right: {:g} N come upon box_load within 10 "
          "ms; "
          "the prediction is that of `thenar check`. Measured less predicted: {} There the reflex spares {:.2f} mm in "
          "the "
          "mean, no more: as the box sinks, the pose's loop asks for more force, too, and the grip rises with it.",
          kGone_mm, mu, w, grip.before_N, mu * grip.before_N,
          1e3 * (w - mu * grip.before_N) / scene.object.translation_damping, 1e3 * grip.lag_s, slips_in_words(ms, wets),
          back_mm, kLoad_N, slips_in_words(ms, loads), spared_mm(loads)),
      "latency [ms]", "slip [mm]",
      {slip_panel(fmt::format("friction falls to {:g}", mu), ms, wets),
       slip_panel(fmt::format("a load of {:g} N", kLoad_N), ms, loads)});
}

// --- reach ----------------------------------------------------------------------------------------------------------

/// What is looked for: the last value that is not lost, from a good one to a bad one.
struct Reach {
  const char* name;
  const char* scene;
  const char* unit;
  Texts changes;
  std::string (*change)(double value);
  bool of_friction;

  [[nodiscard]] Texts with(double ms, double value) const {
    Texts all = late(ms, changes);
    all.push_back(change(value));
    return all;
  }
};

const std::vector<Reach> kReaches = {
    {"largest load, box_load", "box_load", "N", {}, load_of, false},
    {"largest load, box_wet at friction 0.8", "box_wet", "N", {wet(0.8)}, load_of, false},
    {"least friction, box_wet", "box_wet", "", {}, wet, true}};

struct Reached {
  double predicted = kNone, measured = kNone;
  double lost_s = kNone, turned_deg = kNone;  ///< Just beyond: when, after the event, and how far it has turned then.

  [[nodiscard]] double error() const { return predicted / measured - 1.0; }
};

Reached reached(const Reach& reach, double ms, bool quick) {
  Reached result;
  const double any = reach.of_friction ? 0.15 : 0.5;
  const auto predicted = reflex_reach(build_model(coarse_scene(reach.scene, reach.with(ms, any))));
  if (!predicted || (reach.of_friction && !predicted->friction)) return result;
  result.predicted = reach.of_friction ? *predicted->friction : predicted->load_N;
  double good = reach.of_friction ? 0.4 : 0.2 * result.predicted;
  double bad = reach.of_friction ? 0.0 : 2.0 * result.predicted;
  const int halvings = (reach.of_friction ? 8 : 6) + (quick ? 0 : 1);
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (good + bad);
    const Recording recording = run(reach.scene, reach.with(ms, middle));
    const bool is_lost = recording.verdict.outcome == Outcome::kLost;
    (is_lost ? bad : good) = middle;
    if (!is_lost) continue;
    result.lost_s = recording.verdict.lost_s.value_or(kNone) - kEvent_s;
    result.turned_deg = recording.ticks.back().rotation_error_rad * 180.0 / std::numbers::pi;
  }
  result.measured = 0.5 * (good + bad);
  return result;
}

constexpr double kFar = 0.1;  // A prediction that is further off is named.

/// All predictions of one kind in words: how good they are, and those that are not.
std::string reach_in_words(const std::vector<double>& ms, const std::vector<Reached>& all) {
  double sum = 0.0;
  std::string far;
  for (std::size_t i = 0; i < ms.size(); ++i) {
    sum += std::abs(all[i].error()) / static_cast<double>(ms.size());
    if (std::abs(all[i].error()) <= kFar) continue;
    far += fmt::format("{} {:g} ms ({:+.0f} %)", far.empty() ? "" : ",", ms[i], 100.0 * all[i].error());
  }
  return fmt::format("{:.0f} % in the mean, {}", 100.0 * sum,
                     far.empty() ? "nowhere more than 10 %" : "more than 10 % at" + far);
}

void add_reach_table(ordered_json& part, const std::vector<double>& ms, const std::vector<std::vector<Reached>>& all) {
  int far = 0, count = 0;
  double first_s = std::numeric_limits<double>::infinity(), least_deg = first_s;  // Of loads that are predicted badly.
  ordered_json rows = ordered_json::array();
  for (std::size_t r = 0; r < kReaches.size(); ++r) {
    for (std::size_t i = 0; i < ms.size(); ++i) {
      const Reached& reached = all[r][i];
      const bool is_far = std::abs(reached.error()) > kFar;
      far += is_far ? 1 : 0;
      ++count;
      if (is_far && !kReaches[r].of_friction) {
        first_s = std::min(first_s, reached.lost_s);
        least_deg = std::min(least_deg, reached.turned_deg);
      }
      rows.push_back({kReaches[r].name, ms[i], reached.predicted, reached.measured,
                      fmt::format("{:+.1f}{}", 100.0 * reached.error(), is_far ? " (over 10)" : ""),
                      fmt::format("{:.2f}", reached.lost_s), fmt::format("{:.0f}", reached.turned_deg)});
    }
  }
  ordered_json& figure = add_figure(
      part, "table", "reach", "What a reflex can hold, predicted and measured",
      fmt::format(
          "The numbers of both figures above. {} of {} predictions are more than 10 % off. Loads that are "
          "predicted so badly are lost {:.2f} s after they came or later, when the reflex has long answered: the "
          "box sinks as far as the gain of its pose lets it, and has turned by {:.0f} degrees or more. The "
          "prediction has one line and no turns.",
          far, count, first_s, least_deg),
      "As above.");
  figure["columns"] = {"",
                       "latency [ms]",
                       "predicted",
                       "measured",
                       "prediction off by [%]",
                       "lost just beyond, after [s]",
                       "turned by then [degrees]"};
  figure["rows"] = rows;
}

void reaches(ordered_json& part, bool quick) {
  const std::vector<double> ms =
      quick ? std::vector{30.0, 65.0, 100.0} : std::vector{15.0, 30.0, 45.0, 65.0, 80.0, 100.0, 120.0};
  std::vector all(kReaches.size(), std::vector<Reached>(ms.size()));
  tbb::parallel_for(std::size_t{0}, ms.size() * kReaches.size(), [&](std::size_t job) {
    const std::size_t r = job / ms.size(), i = job % ms.size();
    all[r][i] = reached(kReaches[r], ms[i], quick);
  });
  const auto panel = [&](std::size_t r) -> ordered_json {
    std::vector<double> predicted, measured;
    for (const Reached& reached : all[r]) predicted.push_back(reached.predicted), measured.push_back(reached.measured);
    return {{"name", kReaches[r].name},
            {"curves", {plain_curve("measured", ms, measured), theory_curve("predicted", ms, predicted)}}};
  };
  const std::string how =
      "Predicted by first-order mechanics along one line, with the scene's own reflex; measured by bisection of runs "
      "of "
      "the whole model. An object is lost once a finger has slid 2 mm.";
  add_run_curves(
      part, "reach_load", "The largest load that a reflex holds",
      fmt::format("A load that comes within 10 ms, over the latency. {} The prediction is off by {} (box_load), "
                  "and by {} (box_wet, whose friction stays 0.8 here).",
                  how, reach_in_words(ms, all[0]), reach_in_words(ms, all[1])),
      "latency [ms]", "load step [N]", {panel(0), panel(1)});
  add_run_curves(
      part, "reach_friction", "The least friction that a reflex holds",
      fmt::format("The friction of box_wet falls from 0.8 to this in one step. {} The prediction is off by {}.", how,
                  reach_in_words(ms, all[2])),
      "latency [ms]", "friction", ordered_json::array({panel(2)}));
  add_reach_table(part, ms, all);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "reflex", "What a grip that answers can hold",
      "A reflex answers what fingertips feel a latency later, as people's does. What slides until then is a "
      "matter of first-order mechanics: here are its predictions and runs of the whole model, also where they "
      "differ.",
      {slip_over_latency, reaches});
}
