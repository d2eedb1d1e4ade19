// SPDX-License-Identifier: Apache-2.0
#include "engine/results/run_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/formats/build_info.h"
#include "engine/results/run_events.h"
#include "engine/results/warnings.h"
#include "solvers/grasp_forces.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

using View = const RunView&;
using TickRef = const TickRecord&;
using Value = MeasureValue;
using Values = std::vector<double>;
constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

// Of what is finite; NaN if that is nothing.
template <int kPercent>
double percent(Values values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::sort(values.begin(), values.end());
  return percentile(values, 0.01 * kPercent);
}
constexpr auto largest = percent<100>, median = percent<50>, smallest = percent<0>, p99 = percent<99>;
double root_mean_square(Values values) {
  for (double& v : values) v *= v;
  return std::sqrt(mean(values));
}

const std::vector<TickRecord>& ticks(View v) { return v.recording->ticks; }
const TickRecord* last_tick(View v) { return ticks(v).empty() ? nullptr : &ticks(v).back(); }
double time_of(const TickRecord* tick) { return tick != nullptr ? tick->time_s : kNever; }
double end_s(View v) { return ticks(v).empty() ? 0.0 : last_tick(v)->time_s; }
double final_s(View v) { return ticks(v).empty() ? 0.0 : end_s(v) - kFinalWindow_s; }

// A part of a tick, or what a function says of it.
double of(TickRef tick, double TickRecord::*part) { return tick.*part; }
template <typename T>
T of(TickRef tick, T TickReport::*part) {
  return tick.contact.*part;
}
template <typename T>
T of(TickRef tick, T EnvironmentReport::*part) {
  return tick.contact.environment.*part;
}
template <typename Get>
auto of(TickRef tick, Get get) -> decltype(get(tick)) {
  return get(tick);
}

/// One number of every tick from `from_s` on; or of those in which the fingers hold the object: else it has no target.
template <bool kHeld = false, typename Get>
Values over(View v, double from_s, Get get) {
  Values values;
  for (TickRef tick : ticks(v)) {
    if (tick.is_from(from_s) && (tick.holds || !kHeld)) values.push_back(static_cast<double>(of(tick, get)));
  }
  return values;
}
/// A number of each finger.
template <typename Get>
Values each_finger(View v, Get get) {
  Values values;
  for (int k = 0; k < v.model->fingers(); ++k) values.push_back(get(k));
  return values;
}
/// The first tick of which something is true; null: there is none.
template <typename Is>
const TickRecord* first(View v, Is is) {
  const auto tick = std::ranges::find_if(ticks(v), is);
  return tick == ticks(v).end() ? nullptr : &*tick;
}

// Measures by what they make of a number of each tick: of all ticks, of those from 0.3 s on, of the last 0.3 s.
template <auto Reduce, auto Get>
Value all(View v) {
  return Reduce(over(v, 0.0, Get));
}
template <auto Reduce, auto Get>
Value measured(View v) {
  return Reduce(over(v, kMeasuredFrom_s, Get));
}
template <auto Reduce, auto Get>
Value held(View v) {
  return Reduce(over<true>(v, kMeasuredFrom_s, Get));
}
template <auto Get>
Value held_at_end(View v) {
  return mean(over<true>(v, final_s(v), Get));
}
/// Of all fingers, from 0.3 s on or before.
template <auto Reduce, auto Get, bool kMeasured = true>
Value among_fingers(View v) {
  Values values;
  for (TickRef tick : ticks(v)) {
    if (tick.is_measured() == kMeasured) values.insert(values.end(), (tick.*Get).begin(), (tick.*Get).end());
  }
  return Reduce(values);
}
template <auto Get>
Value at_end(View v) {
  return each_finger(v, [&](int k) { return ticks(v).empty() ? 0.0 : (last_tick(v)->*Get)[k]; });
}
template <auto Get>
Value most_at_end(View v) {
  return std::ranges::max(std::get<Values>(at_end<Get>(v)));
}
Value walk(View v) {
  return each_finger(v, [&](int k) { return ticks(v).empty() ? 0.0 : last_tick(v)->walk_m[k].norm(); });
}
template <auto Is>
Value count(View v) {
  return std::ranges::count_if(ticks(v), [](TickRef tick) { return of(tick, Is); });
}
template <auto Is>
Value when_first(View v) {
  return time_of(first(v, [](TickRef tick) { return of(tick, Is); }));
}
/// Of the ticks that ran a stage; some count it in control ticks alone.
template <auto Get, bool kControlled = false>
Value stage(View v) {
  Values us = over(v, 0.0, [](TickRef tick) { return tick.controlled || !kControlled ? 1e6 * of(tick, Get) : 0.0; });
  std::erase_if(us, [](double one) { return !(one > 0.0); });
  return percentiles(std::move(us));
}
template <auto Part>
Value ledger_term(View v) {
  return v.ledger->*Part;
}
template <auto Part>
Value of_scene(View v) {
  return v.scene->*Part;
}
template <auto Part>
Value of_verdict(View v) {
  return v.verdict->*Part;
}
template <auto Part>
Value of_excess(View v) {
  return v.verdict->beyond[v.item].*Part;
}
template <const std::string_view& kText>
Value text(View /*v*/) {
  return std::string(kText);
}

// Numbers of a tick.
Vector3d position_error(TickRef tick) { return tick.position_m - tick.target_m; }
double distance(TickRef tick) { return position_error(tick).norm(); }
/// Mean over the fingers of |f^d - f| / |f^d|.
double relative_force_error(TickRef tick) {
  double sum = 0.0;
  for (std::size_t k = 0; k < tick.force_error_N.size(); ++k) {
    sum += tick.force_error_N[k] / std::hypot(tick.force_desired[k].normal_N, tick.force_desired[k].tangential_N);
  }
  return sum / static_cast<double>(tick.force_error_N.size());
}
double force_error_N(TickRef tick) { return root_mean_square({tick.force_error_N.begin(), tick.force_error_N.end()}); }
double stop(TickRef tick) { return tick.contact.stop_Nm.lpNorm<Eigen::Infinity>(); }
double assembly(TickRef tick) { return tick.factors_s + tick.contact.assemble_s; }
int sweeps(TickRef tick) { return tick.contact.solve.sweeps; }
double residual(TickRef tick) {
  const bool touches = tick.contact.contacts > 0 || tick.contact.environment.contacts > 0;
  return touches ? tick.contact.solve.residual : kNever;
}
template <auto Part>
double chosen(TickRef tick) {
  return tick.stiffness.now && tick.stiffness.now->report.is_chosen ? tick.stiffness.now->report.*Part : kNever;
}
bool has_no_grasp(TickRef tick) { return tick.grasp == GraspStatus::kInfeasible; }
bool has_no_muscles(TickRef tick) { return tick.muscle == MuscleStatus::kInfeasible; }
bool is_unanswered(TickRef tick) {
  return tick.grasp == GraspStatus::kBudgetSpent || tick.muscle == MuscleStatus::kBudgetSpent;
}
bool touches(TickRef tick) { return tick.contact.environment.active > 0; }
template <ReflexEvent kEvent>
bool answers(TickRef tick) {
  return tick.controlled && tick.reflex.event == kEvent;
}

// Numbers of a run.
Value off_axis(View v) {
  const Vector3d axis = v.scene->task.translate ? v.scene->task.translate->axis : Vector3d::Zero();
  return largest(over<true>(v, kMeasuredFrom_s, [&](TickRef tick) {
    const Vector3d error = position_error(tick);
    return (error - error.dot(axis) * axis).norm();
  }));
}
Value hold_transitions(View v) {
  std::int64_t transitions = 0;
  bool held = false;
  for (TickRef tick : ticks(v)) {
    transitions += tick.contact.held != held ? 1 : 0;
    held = tick.contact.held;
  }
  return transitions;
}
Value grasp_infeasible(View v) {
  // A run that stops at once has no tick to count.
  const std::optional<UnsolvedGrasp>& unsolved = v.recording->unsolved;
  if (ticks(v).empty() && unsolved && unsolved->control.grasp == GraspStatus::kInfeasible) return std::int64_t{1};
  return count<has_no_grasp>(v);
}
Value joint_margin(View v) {
  return smallest(over(v, 0.0, [&](TickRef tick) {
    Values of_joints;
    for (Eigen::Index i = 0; i < tick.q_rad.size(); ++i) {
      const Joint& joint = v.scene->hand.joints[i];
      of_joints.push_back(std::min(tick.q_rad[i] - joint.lower_rad, joint.upper_rad - tick.q_rad[i]));
    }
    return smallest(of_joints);
  }));
}
Value activation(View v) {
  const auto& f = v.recording->muscle_forces_N;
  double most = 0.0;
  for (Eigen::Index m = 0; m < f.rows(); ++m) {
    most = std::max(most, f.row(m).maxCoeff() / v.scene->hand.muscles[m].max_force_N);
  }
  return most;
}
/// The published computation shows fingertips in every tick: where a tick does not, their last time is counted.
Value contact_total(View v) {
  Values us;
  double shown_s = 0.0;
  for (TickRef tick : ticks(v)) {
    if (tick.interpolate_s > 0.0) shown_s = tick.interpolate_s;
    const double total_s = tick.contact_total_s() - tick.interpolate_s + shown_s;
    if (tick.controlled && total_s > 0.0) us.push_back(1e6 * total_s);
  }
  return percentiles(std::move(us));
}
/// The least of each finger once the grip had built up.
template <typename Get>
Value least_of_fingers(View v, Get get) {
  return each_finger(
      v, [&](int k) { return smallest(over(v, kMeasuredFrom_s, [&](TickRef tick) { return get(tick, k); })); });
}
Value least_sticking(View v) {
  return least_of_fingers(v, [](TickRef tick, int k) { return tick.touch[k].stick; });
}
/// What of friction is to spare at a load, torsion left out; NaN without load.
double friction_margin(const NormalTangential& load, double mu) {
  return load.normal_N > 0.0 ? 1.0 - load.tangential_N / (mu * load.normal_N) : kNever;
}
Value true_margin(View v) {
  return least_of_fingers(v, [&](TickRef tick, int k) {
    return friction_margin(tick.force[k], v.model->friction(tick.time_s - v.scene->step_s));
  });
}
Value felt_margin(View v) {
  return least_of_fingers(v, [](TickRef t, int k) { return friction_margin(t.force[k], t.reflex.friction[k]); });
}
Value felt_friction(View v) {
  return each_finger(v, [&](int k) { return ticks(v).empty() ? kNever : last_tick(v)->reflex.friction[k]; });
}
Value unanswered_stiffness(View v) {
  std::int64_t unanswered = 0;
  const StiffnessRecord* before = nullptr;
  for (TickRef tick : ticks(v)) {
    // The ticks of a frame share what its control tick found.
    const StiffnessRecord* const now = tick.stiffness.now.get();
    unanswered += now != nullptr && now != before && now->report.is_unanswered ? 1 : 0;
    before = now;
  }
  return unanswered;
}
/// Three of the diagonal of the stiffness that was chosen last.
template <int kFrom>
Value last_stiffness(View v) {
  if (ticks(v).empty() || !last_tick(v)->stiffness.chosen) return {};
  const auto K = last_tick(v)->stiffness.chosen->report.K_O.diagonal();
  return Values{K[kFrom], K[kFrom + 1], K[kFrom + 2]};
}

double last_touch_s(View v) {
  const auto last = std::find_if(ticks(v).rbegin(), ticks(v).rend(), touches);
  return last == ticks(v).rend() ? kNever : last->time_s;
}
/// Of the section's item, a body: its force on the object.
double body_force_N(TickRef tick, std::size_t body) {
  return tick.contact.environment.body_N.col(static_cast<Eigen::Index>(body)).norm();
}
/// The first tick with the largest force.
const TickRecord* strongest_tick(View v) {
  const auto now = [&](TickRef tick) { return body_force_N(tick, v.item); };
  const auto most = std::ranges::max_element(ticks(v), {}, now);
  return most != ticks(v).end() && now(*most) > 0.0 ? &*most : nullptr;
}
std::size_t told_bodies(View v) { return std::min<std::size_t>(kToldBodies, v.scene->environment->bodies.size()); }
/// On the object, against the scene's gravity, in ticks that touch.
template <auto Reduce>
Value vertical(View v) {
  const Vector3d up = -v.scene->gravity.normalized();  // Zero without gravity: then nothing is vertical.
  return Reduce(over(v, 0.0, [&](TickRef tick) {
    return touches(tick) && !up.isZero() ? up.dot(tick.contact.environment.wrench.head<3>()) : kNever;
  }));
}
/// How deep the end of the scene's peg is below the plate of its hole as it first wedges; NaN without these. It is as
/// if the object had kept its start's rotation: of 60 mm, 5 degrees make 0.1 mm.
Value wedged_depth(View v) {
  const TickRecord* const tick = first(v, [](TickRef t) { return t.contact.environment.wedged; });
  const auto* peg = std::get_if<CylinderShape>(&v.scene->object.shape);
  const std::vector<EnvironmentBody>& bodies = v.scene->environment->bodies;
  const auto hole = std::ranges::find_if(
      bodies, [](const EnvironmentBody& body) { return std::holds_alternative<HoleShape>(body.shape); });
  if (tick == nullptr || peg == nullptr || hole == bodies.end()) return kNever;
  const Eigen::Isometry3d& X_WO = v.scene->object.X_WO;
  const Eigen::Isometry3d X_EO = pose(*hole, {tick->time_s, X_WO.linear() * tick->arm_m}).inverse() * X_WO;
  const double middle_m = (X_EO * tick->position_m).z(), tilt = std::abs(X_EO.linear()(2, 2));
  return 0.5 * peg->length_m * tilt - middle_m;
}

// A phase of the task: the item of its section.
std::span<const TickRecord> phase_ticks(View v) {
  const int phase = static_cast<int>(v.item);
  return {std::ranges::lower_bound(ticks(v), phase, {}, &TickRecord::phase),
          std::ranges::upper_bound(ticks(v), phase, {}, &TickRecord::phase)};
}
Phase::Kind kind(View v) { return v.scene->task.phases[v.item].kind; }
bool loads(View v) { return kind(v) == Phase::Kind::kLoad && !phase_ticks(v).empty(); }
bool lifts(View v) { return loads(v) && touches(phase_ticks(v).front()); }
double grip_N(TickRef tick) {
  double sum_N = 0.0;
  for (const NormalTangential& force : tick.force) sum_N += force.normal_N;
  return sum_N;
}
/// Pearson's, of grip and load.
Value grip_load_correlation(View v) {
  double n = 0.0, g = 0.0, l = 0.0, gg = 0.0, ll = 0.0, gl = 0.0;
  for (TickRef tick : phase_ticks(v)) {
    const double grip = grip_N(tick), load = tick.borne_N;
    n += 1.0, g += grip, l += load, gg += grip * grip, ll += load * load, gl += grip * load;
  }
  return (n * gl - g * l) / std::sqrt((n * gg - g * g) * (n * ll - l * l));
}
/// From the load phase on, the first tick in which nothing but the fingers bears the object; null: there is none.
const TickRecord* lift_off(View v) {
  const TickRecord *const begin = phase_ticks(v).data(), *const end = last_tick(v) + 1;
  const TickRecord* const off = std::find_if_not(begin, end, touches);
  return off == end ? nullptr : off;
}
/// The object's largest displacement in a tick within 10 ms of it.
Value largest_step(View v) {
  constexpr double kAround_s = 10e-3;
  const TickRecord* const off = lift_off(v);
  if (off == nullptr) return kNever;
  double most_m = 0.0;
  for (std::size_t i = 1; i < ticks(v).size(); ++i) {
    TickRef tick = ticks(v)[i];
    const bool is_near = tick.time_s > off->time_s - kAround_s && tick.time_s < off->time_s + kAround_s;
    if (is_near) most_m = std::max(most_m, (tick.position_m - ticks(v)[i - 1].position_m).norm());
  }
  return most_m;
}

/// When the task first pushes or changes friction.
double disturbed_s(View v) {
  const TaskSettings& task = v.scene->task;
  double from_s = task.push ? task.push->from_s : std::numeric_limits<double>::infinity();
  for (const FrictionStep& step : task.friction) from_s = std::min(from_s, step.from_s);
  return from_s;
}
/// How late the first answer came.
double onset_s(View v) {
  const double from_s = disturbed_s(v);
  const auto is_answer = [&](TickRef t) {
    return t.is_from(from_s + v.scene->step_s) && t.controlled && t.reflex.event != ReflexEvent::kNone;
  };
  return time_of(first(v, is_answer)) - from_s;
}
/// How far a finger slipped from then until the answer's pulse was over.
Value answered_slip(View v) {
  const double from_s = disturbed_s(v), until_s = onset_s(v) + v.scene->control->reflex->pulse_s;
  double slip_m = kNever;
  PerFinger<double> before_m(v.model->fingers());
  for (TickRef tick : ticks(v)) {
    if (!tick.is_from(from_s + v.scene->step_s)) {
      before_m = tick.slip_m;
      continue;
    }
    if (tick.time_s - from_s > until_s) break;
    for (int k = 0; k < v.model->fingers(); ++k) slip_m = std::fmax(slip_m, tick.slip_m[k] - before_m[k]);
  }
  return slip_m;
}

// Which runs have a measure; all of a view comes with its recording.
constexpr Runs kAny{[](View) { return true; }, ""};
constexpr Runs kScene{[](View v) { return v.scene != nullptr; }, ""};
constexpr Runs kVerdict{[](View v) { return v.verdict != nullptr; }, ""};
constexpr Runs kLedger{[](View v) { return v.ledger != nullptr; }, ""};
constexpr Runs kRun{[](View v) { return v.recording != nullptr; }, ""};
constexpr Runs kSoft{[](View v) { return v.model != nullptr && v.model->deformable(); }, "of scenes with pulps"};
constexpr Runs kTurning{[](View v) { return !v.scene->hand.slides; }, "of hands with joints that turn"};
constexpr Runs kSliding{[](View v) { return v.scene->hand.slides; }, "of fingertips on slides"};
constexpr Runs kMuscles{[](View v) { return kRun.have(v) && v.recording->muscle_forces_N.size() > 0; },
                        "of scenes with muscles"};
constexpr Runs kNoMuscles{[](View v) { return kRun.have(v) && !kMuscles.have(v); }, "of scenes without muscles"};
constexpr Runs kTouch{[](View v) { return kRun.have(v) && v.model->feels(); }, "of scenes with `fingertips.touch`"};
constexpr Runs kFelt{[](View v) { return v.scene->control.has_value(); }, "with `control`"};
constexpr Runs kStiffness{[](View v) { return kRun.have(v) && v.scene->chooses_stiffness(); },
                          "of scenes with `control.muscles.object_stiffness`"};
constexpr Runs kEnvironment{[](View v) { return kRun.have(v) && v.scene->environment.has_value(); },
                            "of scenes with `environment`"};
constexpr Runs kTask{[](View v) { return kRun.have(v) && !v.scene->task.phases.empty(); }, "of tasks in phases"};
constexpr Runs kLoads{loads, "of a load phase that began"};
constexpr Runs kLifts{lifts, "of a load phase that began on something"};
constexpr Runs kReflex{[](View v) { return kRun.have(v) && v.scene->control && v.scene->control->reflex; },
                       "of scenes with `control.reflex`"};

constexpr Unit kPlain, kWhole{"", 1.0, true};
constexpr Unit kHz{"Hz"}, kS{"s"}, kMs{"ms", 1e3}, kUs{"us", 1e6}, kM{"m"}, kMm{"mm", 1e3}, kUm{"um", 1e6};
constexpr Unit kUmPerS{"um/s", 1e6}, kRad{"rad"}, kDeg{"deg", kDegrees}, kN{"N"}, kNm{"N m"}, kNPerM{"N/m"};
constexpr Unit kNmPerRad{"N m/rad"}, kJ{"J"};

// Rows: key, unit, number, sentence, label, remark, column, its prefix, runs.
constexpr RunMeasure kName[] = {{"scene", kPlain, of_scene<&Scene::name>, "Name of the scene.", "scene"}};

constexpr RunMeasure kBuild[] = {{"type", kPlain, text<build_info::kType>, "The program's build type."},
                                 {"flags", kPlain, text<build_info::kFlags>, "Its compiler's flags."},
                                 {"compiler", kPlain, text<build_info::kCompiler>, "Its compiler."},
                                 {"version", kPlain, text<build_info::kVersion>, "Its version."},
                                 {"source", kPlain, text<build_info::kSource>,
                                  "The commit that it is built of, with `-dirty` if files had changed."}};

constexpr RunMeasure kSimulated[] = {
    {"simulated_s", kS, [](View v) -> Value { return end_s(v); }, "Simulated time.", "simulated"}};

constexpr RunMeasure kSettings[] = {
    {"contact_rate_hz", kHz, [](View v) -> Value { return 1.0 / v.scene->step_s; }, "Rate of the contact loop.",
     "contact loop"},
    {"control_rate_hz", kHz, [](View v) -> Value { return 1.0 / v.scene->control_period_s; },
     "Rate of the control loop.", "control loop"},
    {"control_delay_ms", kMs, of_scene<&Scene::control_delay_s>, "Delay of its frames.", "", "late by"},
    {"tolerance", kPlain, [](View v) -> Value { return v.scene->contact.tolerance; },
     "Residual at which a contact solve stops.", "a contact solve stops at residual"},
    {"max_sweeps", kPlain, [](View v) -> Value { return v.scene->contact.max_sweeps; },
     "Sweeps after which it stops without one.", "", "or sweeps:"},
    {"grasp_method", kPlain,
     [](View v) -> Value { return v.scene->control ? Value(grasp_method(v.scene->control->cone)) : Value(); },
     "How the grasp forces are computed.", "grasp forces by"},
    {"muscle_method", kPlain,
     [](View v) -> Value {
       if (v.scene->chooses_stiffness()) return "Newton for the stiffness, else active set";
       return v.scene->has_muscles() ? Value("active set") : Value();
     },
     "How the muscle forces are computed.", "", "muscle forces by"},
    {"level", kPlain, [](View v) -> Value { return v.model->level; }, "Level of detail of the pulps.", "", "", 0, "",
     &kSoft}};

constexpr RunMeasure kRemarks[] = {
    {"parts", kPlain, of_scene<&Scene::left_out>,
     "With `model: auto`, a sentence for each part that was left out or kept, and why.", "part"},
    {"warnings", kPlain, [](View v) -> Value { return warnings(*v.model, *v.recording); },
     "A sentence for each way in which the run left its model's range of validity.", "warning"}};

constexpr RunMeasure kObject[] = {
    {"final_error_mm", kMm, held_at_end<distance>, "Mean distance from its target over the last 0.3 s.",
     "final position error", "", 1},
    {"rms_error_mm", kMm, held<root_mean_square, distance>,
     "Root of the mean squared distance from its target, from 0.3 s on, as the next two.", "rms position error", "", 2},
    {"max_off_axis_error_mm", kMm, off_axis, "Largest distance from the line on which the task moves it.",
     "largest off-axis error", "", 3},
    {"max_rotation_deg", kDeg, held<largest, &TickRecord::rotation_error_rad>, "Largest angle to its target.",
     "largest rotation error", "", 5},
    {"final_rotation_deg", kDeg, held_at_end<&TickRecord::rotation_error_rad>,
     "Mean angle to its target over the last 0.3 s.", "final rotation error", "", 4}};

constexpr RunMeasure kOutcome[] = {
    {"outcome", kPlain, [](View v) -> Value { return to_string(v.verdict->outcome); },
     "[The outcome](../guide/run.md#what-became-of-the-grasp), a word.", "outcome"},
    {"reason", kPlain, of_verdict<&Verdict::reason>, "Everything that was found.", "  reason"},
    {"held", kPlain, [](View v) -> Value { return is_fine(v.verdict->outcome); }, "Whether the object was held."},
    {"lost_at_s", kS, [](View v) -> Value { return v.verdict->lost_s ? Value(*v.verdict->lost_s) : Value(); },
     "When the object was lost.", "", "", 6}};

constexpr RunMeasure kBeyond[] = {
    {"name", kPlain, of_excess<&Excess::name>, "A joint or muscle that passed its limit."},
    {"unit", kPlain, [](View v) -> Value { return v.verdict->beyond[v.item].muscle ? "N" : "rad"; },
     "Unit of the next two."},
    {"limit", kPlain, of_excess<&Excess::limit>,
     "The muscle's largest force, or that end of the joint's range which was passed."},
    {"value", kPlain, of_excess<&Excess::value>, "The worst value."},
    {"at_s", kS, of_excess<&Excess::at_s>, "When that was."},
    {"first_s", kS, of_excess<&Excess::first_s>, "When the limit was first passed."}};

constexpr RunMeasure kGripRows[] = {
    {"max_slip_mm", kMm, most_at_end<&TickRecord::slip_m>,
     "[Slip](../guide/run.md#what-the-measures-of-a-grip-mean) of the finger that slipped most.",
     "largest slip of a finger", "", 7},
    {"max_start_slip_mm", kMm, most_at_end<&TickRecord::start_slip_m>, "Largest part of a slip in the first 0.3 s.", "",
     "of it at the start:", 8},
    {"slip_mm", kMm, at_end<&TickRecord::slip_m>, "Slip of each finger."},
    {"start_slip_mm", kMm, at_end<&TickRecord::start_slip_m>, "The part of the first 0.3 s, of each finger."},
    {"max_spin_deg", kDeg, most_at_end<&TickRecord::spin_rad>, "Spin of the finger that turned most.",
     "largest spin of a finger", "", 9},
    {"max_start_spin_deg", kDeg, most_at_end<&TickRecord::start_spin_rad>, "Largest part of a spin in the first 0.3 s.",
     "", "of it at the start:", 10},
    {"spin_deg", kDeg, at_end<&TickRecord::spin_rad>, "Spin of each finger."},
    {"start_spin_deg", kDeg, at_end<&TickRecord::start_spin_rad>, "The part of the first 0.3 s, of each finger."},
    {"max_walk_mm", kMm, [](View v) -> Value { return std::ranges::max(std::get<Values>(walk(v))); },
     "Net way on the object, from 0.3 s on, of the patch that walked farthest.", "largest net way of a patch", "", 36},
    {"walk_mm", kMm, walk, "Net way of each patch from 0.3 s on."},
    {"max_sliding_share", kPlain, among_fingers<largest, &TickRecord::sliding_share>,
     "Largest share of a patch that slid, from 0.3 s on.", "largest share of a patch sliding", "", 11},
    {"max_creep_um_per_s", kUmPerS, among_fingers<largest, &TickRecord::creep_m_per_s>,
     "Largest speed of a point that should stick, from 0.3 s on.", "fastest point that should stick", "", 12},
    {"min_margin", kPlain, among_fingers<smallest, &TickRecord::margin>, "Least margin of a finger, from 0.3 s on.",
     "least margin", "", 13},
    {"min_start_margin", kPlain, among_fingers<smallest, &TickRecord::margin, false>,
     "Least margin of a finger before.", "", "at the start:", 14},
    {"force_error_end", kPlain,
     [](View v) -> Value { return v.scene->control ? mean(over(v, final_s(v), relative_force_error)) : Value(); },
     "Error of the finger forces, as a share of the desired ones: mean over the last 0.3 s.", "final force error",
     "share of the desired forces", 15},
    {"force_error_rms_N", kN,
     [](View v) -> Value { return v.scene->control ? measured<root_mean_square, force_error_N>(v) : Value(); },
     "Root of the mean squared error of the finger forces, from 0.3 s on.", "", "", 16},
    {"predicted_paper_law_error", kPlain,
     [](View v) -> Value {
       const std::optional<double>& error = v.recording->predicted_paper_law_error;
       return v.scene->control && error ? Value(*error) : Value();
     },
     "The share that the published law without feedforward would leave.", "  of the law without feedforward",
     "predicted: (I + S)^-1 S f^d"}};

constexpr RunMeasure kContacts[] = {
    {"min", kWhole, measured<smallest, &TickReport::contacts>,
     "Fewest contacts of a tick, from 0.3 s on, as the next three.", "", "", 17, "contacts_"},
    {"median", kWhole, measured<median, &TickReport::contacts>, "Median of the contacts.", "contacts, median", "", 18,
     "contacts_"},
    {"max", kWhole, measured<largest, &TickReport::contacts>, "Most contacts of a tick.", "", "at the most:", 19,
     "contacts_"},
    {"active_median", kWhole, measured<median, &TickReport::active>, "Median of the contacts that carry force.",
     "  of them carrying force", "", 20, "contacts_"},
    {"max_penetration_um", kUm, all<largest, &TickReport::penetration_m>,
     "Largest penetration of a pulp into the object.", "deepest penetration of a pulp", "", 21},
    {"residual_p99", kPlain, all<p99, residual>, "Natural-map residual that 99 % of the contact solves reach.",
     "contact residual, p99", "", 22},
    {"sweeps_median", kWhole, all<median, sweeps>, "Median of the sweeps of a contact solve.", "", "", 23},
    {"sweeps_max", kWhole, all<largest, sweeps>, "Most sweeps of a contact solve.", "", "", 24}};

constexpr RunMeasure kFrames[] = {
    {"handovers", kPlain, count<&TickReport::handed_over>, "Hand-overs to a new frame.", "", "", 25},
    {"held_ticks", kPlain, count<&TickReport::held>, "Ticks that held the drive of a frame that was too old.",
     "ticks on the drive of an old frame", "", 26},
    {"hold_transitions", kPlain, hold_transitions, "Times that this began or ended.", "", "transitions:"}};

constexpr RunMeasure kEnergy[] = {
    {"drive_J", kJ, ledger_term<&Ledger::drive_J>, "Work of torques, weight, springs and input on the bodies.",
     "energy of the drive"},
    {"viscous_J", kJ, ledger_term<&Ledger::viscous_J>, "Taken by the bodies' viscosities."},
    {"deformation_J", kJ, ledger_term<&Ledger::deformation_J>,
     "Work of the contact forces on pulps and a soft object."},
    {"stored_J", kJ, ledger_term<&Ledger::stored_J>, "Elastic energy in these at the end."},
    {"injected_J", kJ, ledger_term<&Ledger::injected_J>,
     "Work of contacts that push their surfaces on: energy from nowhere.", "  that contact gave", "", 27},
    {"dissipated_J", kJ, ledger_term<&Ledger::dissipated_J>, "Taken by the other contacts, by friction above all.", "",
     "and took:", 28},
    {"dropped_J", kJ, ledger_term<&Ledger::dropped_J>,
     "Elastic energy of contacts that a new frame or tick no longer had."},
    {"unbalanced_J", kJ, [](View v) -> Value { return v.ledger->unbalanced_J(); }, "Error of the balance.",
     "  that the balance misses", "", 29}};

constexpr RunMeasure kSolves[] = {
    {"grasp_infeasible", kPlain, grasp_infeasible, "Ticks in which grasp forces do not exist.",
     "ticks without grasp forces", "", 31},
    {"muscle_infeasible", kPlain, count<has_no_muscles>, "Ticks in which muscle forces do not exist.", "",
     "muscle forces:", 32},
    {"unanswered", kPlain, count<is_unanswered>, "Ticks in which one of them was not found.", "", "not found:", 33},
    {"muscle_residual_max", kNm, all<largest, &TickRecord::muscle_residual_Nm>,
     "Largest difference between the muscles' torques and those asked for.", "muscle torque residual", "", 34}};

constexpr RunMeasure kJoints[] = {
    {"least_margin_rad", kRad, joint_margin, "Least distance to an end of a joint's range.",
     "least distance to a joint's limit", "", 30, "joints_", &kTurning},
    {"stop_max_Nm", kNm, all<largest, stop>, "Largest moment of a stop at such an end.", "", "", 0, "", &kTurning},
    {"least_margin_m", kM, joint_margin, "Least distance to an end of a slide.", "least distance to a slide's end", "",
     0, "", &kSliding},
    {"stop_max_N", kN, all<largest, stop>, "Largest force of a stop at such an end.", "", "", 0, "", &kSliding}};

constexpr RunMeasure kMuscleForces[] = {
    {"max_force_N", kN, [](View v) -> Value { return v.recording->muscle_forces_N.maxCoeff(); },
     "Largest force of a muscle.", "largest muscle force"},
    {"max_activation", kPlain, activation, "Largest force of a muscle over the largest that it has.",
     "  over the most a muscle has"}};
constexpr RunMeasure kNoForces[] = {{"muscles", kPlain, [](View) -> Value { return {}; }, "Null."}};

constexpr RunMeasure kStages[] = {
    {"find", kUs, stage<&TickRecord::find_s, true>, "Contact finding.", "contact finding"},
    {"assemble", kUs, stage<assembly>, "The contacts' compliance.", "Delassus operator"},
    {"solve", kUs, stage<&TickReport::solve_s>, "Contact forces.", "contact forces"},
    {"deform", kUs, stage<&TickReport::deform_s>, "Deformation.", "deformation"},
    {"interpolate", kUs, stage<&TickRecord::interpolate_s>,
     "Shown surfaces, in the 60 ticks a second that show fingertips.", "surface interpolation"},
    {"contact_total", kUs, contact_total,
     "All of these, in control ticks, and the last shown surfaces, as the published computation shows them in every "
     "tick.",
     "contact computation, total", "published: 6, 10, 20 ms at 15, 30, 60 contacts"},
    {"grasp_lcp", kUs, stage<&TickRecord::grasp_s, true>, "Grasp forces.", "grasp forces",
     "published, by Lemke: 40 us"},
    {"muscle_lcp", kUs, stage<&TickRecord::muscle_s, true>, "Muscle forces.", "muscle forces"},
    {"control_total", kUs, stage<&TickRecord::control_s, true>, "The whole control tick.", "control tick, total"}};

constexpr RunMeasure kSpeed[] = {{"real_time_factor", kPlain,
                                  [](View v) -> Value { return end_s(v) / v.recording->wall_s; },
                                  "Simulated over wall time.", "times real time"}};

constexpr RunMeasure kTouchMeasures[] = {
    {"stick_min", kPlain, least_sticking,
     "For each finger, from 0.3 s on: the least share of its loaded area that stuck.",
     "least share of a patch sticking"},
    {"margin_true", kPlain, true_margin,
     "Likewise, the least of 1 - T/(mu N) with its loads and the contacts' friction at the time.",
     "least margin without torsion"},
    {"friction_felt", kPlain, felt_friction, "For each finger, the friction that the hand felt last.",
     "friction felt at the end", "", 0, "", &kFelt},
    {"margin_felt", kPlain, felt_margin,
     "As `margin_true` with the friction that the hand had felt by then: below 0 if that was less than what bore the "
     "load.",
     "least margin by felt friction", "", 0, "", &kFelt}};

constexpr RunMeasure kChosenStiffness[] = {
    {"min_share", kPlain, measured<smallest, chosen<&StiffnessReport::share>>,
     "Least share of the requested stiffness that was reached, from 0.3 s on.",
     "least share of the stiffness asked for"},
    {"max_squeeze_N", kN, measured<largest, chosen<&StiffnessReport::squeeze_N>>,
     "Largest rise of the internal force for it, from 0.3 s on."},
    {"unanswered", kPlain, unanswered_stiffness,
     "Control periods in which for some share neither forces nor a proof that none exist was found.",
     "  periods without an answer"},
    {"along_N_per_m", kNPerM, last_stiffness<0>,
     "Last chosen: the stiffness along the object's axes, through `centre`.", "  last chosen, along x, y, z"},
    {"about_Nm_per_rad", kNmPerRad, last_stiffness<3>, "Likewise about these axes.", "", "about them:"},
    {"sum_N", kN,
     [](View v) -> Value { return v.recording->muscle_forces_N.rightCols(ticks(v).empty() ? 0 : 1).sum(); },
     "Sum of the muscles' forces at the end."}};

constexpr RunMeasure kTouched[] = {
    {"ticks_with_contact", kPlain, count<touches>, "Ticks in which it bears force.", "ticks in which it is touched"},
    {"first_touch_s", kS, when_first<touches>, "End of the first of these.", "", "from"},
    {"last_touch_s", kS, [](View v) -> Value { return last_touch_s(v); }, "End of the last.", "", "to"},
    {"lift_off_s", kS,
     [](View v) -> Value {
       const double last_s = last_touch_s(v);
       return !ticks(v).empty() && last_tick(v)->is_from(last_s + kUnloaded_s) ? last_s : kNever;
     },
     "The same, if 50 ms or more of the run follow.", "lifted off it"},
    {"ticks_wedged", kPlain, count<&EnvironmentReport::wedged>,
     "Ticks in which the line through two sticking contacts lay in both friction cones.", "ticks in which it wedges"},
    {"first_wedged_s", kS, when_first<&EnvironmentReport::wedged>, "End of the first of these.", "", "from"},
    {"wedged_depth_mm", kMm, wedged_depth, "Depth of a cylinder's end below the plate of a hole then, to 0.1 mm.", "",
     "on, at a depth of"},
    {"max_normal_N", kN, all<largest, &EnvironmentReport::normal_N>, "Largest sum of its normal forces.",
     "largest normal force"},
    {"min_vertical_N", kN, vertical<smallest>, "Least force on the object against `gravity`, of ticks with contact.",
     "least vertical force on the object"},
    {"max_vertical_N", kN, vertical<largest>, "The largest.", "", "the largest:"},
    {"max_penetration_um", kUm, all<largest, &EnvironmentReport::penetration_m>,
     "Largest deformation between object and body.", "deepest penetration"}};

constexpr RunMeasure kBodies[] = {
    {"name", kPlain, [](View v) -> Value { return v.scene->environment->bodies[v.item].name; }, "Name of a body.",
     "body"},
    {"ticks_with_contact", kPlain,
     [](View v) -> Value {
       return static_cast<double>(
           std::ranges::count_if(ticks(v), [&](TickRef tick) { return body_force_N(tick, v.item) > 0.0; }));
     },
     "Ticks in which it bears force on the object.", "", "ticks with contact:"},
    {"max_N", kN,
     [](View v) -> Value {
       const TickRecord* const most = strongest_tick(v);
       return most != nullptr ? body_force_N(*most, v.item) : 0.0;
     },
     "Largest size of its force.", "", "largest force"},
    {"max_at_s", kS, [](View v) -> Value { return time_of(strongest_tick(v)); }, "When that was.", "", "at"},
    {"end_N", kN, [](View v) -> Value { return ticks(v).empty() ? kNever : body_force_N(*last_tick(v), v.item); },
     "Size of its force at the end.", "", "at the end"}};

constexpr RunMeasure kPhaseRows[] = {
    {"phase", kPlain, [](View v) -> Value { return to_string(kind(v)); }, "Name of a phase.", "phase"},
    {"from_s", kS, [](View v) -> Value { return phase_ticks(v).empty() ? kNever : phase_ticks(v).front().time_s; },
     "When it began.", "", "from"},
    {"until_s", kS,
     [](View v) -> Value {
       const bool has_ended = !phase_ticks(v).empty() && last_tick(v)->phase > static_cast<int>(v.item);
       return has_ended ? phase_ticks(v).back().time_s : kNever;
     },
     "When it ended.", "", "to"},
    {"grip_load_correlation", kPlain, grip_load_correlation,
     "Correlation of the sum of the fingers' normal forces and the weight that they bore.",
     "  correlation of grip and load", "", 0, "", &kLoads},
    {"lift_off.at_s", kS, [](View v) -> Value { return time_of(lift_off(v)); },
     "When nothing else bore the object any more.", "  the object came off at", "", 0, "", &kLifts},
    {"lift_off.borne_N", kN, [](View v) -> Value { return lift_off(v) != nullptr ? lift_off(v)->borne_N : kNever; },
     "What the fingers bore then.", "", "the fingers bore", 0, "", &kLifts},
    {"lift_off.largest_step_um", kUm, largest_step, "The object's largest displacement in a tick within 10 ms of it.",
     "", "", 0, "", &kLifts}};
constexpr RunMeasure kWeight[] = {{"weight_N", kN,
                                   [](View v) -> Value { return v.scene->object.mass_kg * v.scene->gravity.norm(); },
                                   "Weight of the object.", "weight of the object"}};

constexpr RunMeasure kAnswers[] = {
    {"events.load", kPlain, count<answers<ReflexEvent::kLoad>>, "How often the grip began to answer a load.",
     "answers to loads"},
    {"events.slip", kPlain, count<answers<ReflexEvent::kSlip>>, "How often it began to answer a slip.", "",
     "to slips:"},
    {"onset_ms", kMs, [](View v) -> Value { return onset_s(v); },
     "Time from the task's first push or change of friction to the end of the tick in which the first answer began.",
     "  the first one after"},
    {"slip_mm", kMm, answered_slip,
     "How far the finger that slipped most slid from then until the answer's pulse, or the run, was over.", "",
     "with a slip of"}};

constexpr RunMeasure kEvents[] = {
    {"time_s", kS, [](View v) -> Value { return run_events(*v.scene, *v.recording)[v.item].time_s; },
     "When something happened: friction, a push or the target changed, a phase began, the grip answered what "
     "fingertips "
     "felt, or the object was lost."},
    {"what", kPlain, [](View v) -> Value { return run_events(*v.scene, *v.recording)[v.item].what; },
     "What it was, in words."}};

constexpr RunMeasure kChatter[] = {
    {"force_chatter", kPlain, of_verdict<&Verdict::force_chatter>,
     "How much of a finger's force changes to and fro from tick to tick, over the last 0.3 s.", "", "", 35}};

std::size_t events(View v) { return run_events(*v.scene, *v.recording).size(); }
std::size_t beyond(View v) { return v.verdict->beyond.size(); }
std::size_t phases(View v) { return v.scene->task.phases.size(); }

constexpr auto kSections =
    std::to_array<MeasureSection>({{"", Heading::kRun, &kScene, kName},
                                   {"build", Heading::kRun, &kAny, kBuild},
                                   {"", Heading::kRun, &kRun, kSimulated},
                                   {"settings", Heading::kRun, &kScene, kSettings},
                                   {"", Heading::kRun, &kRun, kRemarks},
                                   {"object", Heading::kAccuracy, &kRun, kObject},
                                   {"grasp", Heading::kGrasp, &kVerdict, kOutcome},
                                   {"grasp.beyond", Heading::kGrasp, &kVerdict, kBeyond, beyond},
                                   {"grasp", Heading::kGrasp, &kRun, kGripRows},
                                   {"contacts", Heading::kGrasp, &kRun, kContacts},
                                   {"frames", Heading::kAccuracy, &kRun, kFrames},
                                   {"ledger", Heading::kAccuracy, &kLedger, kEnergy},
                                   {"lcp", Heading::kAccuracy, &kRun, kSolves},
                                   {"joints", Heading::kGrasp, &kRun, kJoints},
                                   {"muscles", Heading::kGrasp, &kMuscles, kMuscleForces},
                                   {"", Heading::kGrasp, &kNoMuscles, kNoForces},
                                   {"stages", Heading::kTime, &kRun, kStages},
                                   {"", Heading::kRun, &kRun, kSpeed},
                                   {"touch", Heading::kGrasp, &kTouch, kTouchMeasures},
                                   {"stiffness", Heading::kGrasp, &kStiffness, kChosenStiffness},
                                   {"environment", Heading::kEnvironment, &kEnvironment, kTouched},
                                   {"environment.bodies", Heading::kEnvironment, &kEnvironment, kBodies, told_bodies},
                                   {"task.phases", Heading::kTask, &kTask, kPhaseRows, phases},
                                   {"task", Heading::kTask, &kTask, kWeight},
                                   {"reflex", Heading::kGrasp, &kReflex, kAnswers},
                                   {"events", Heading::kRun, &kRun, kEvents, events},
                                   {"", Heading::kSweepAlone, &kVerdict, kChatter}});

}  // namespace

RunView view_of(const Model& model, const Recording& recording) {
  static const Ledger kNothing;
  return {.model = &model,
          .scene = &model.scene,
          .recording = &recording,
          .verdict = &recording.verdict,
          .ledger = recording.ticks.empty() ? &kNothing : &recording.ticks.back().ledger};
}

MeasureValue RunMeasure::value(const RunView& view) const {
  MeasureValue value = si(view);
  if (auto* const number = std::get_if<double>(&value)) {
    *number *= unit.factor;
    if (unit.whole) return std::isnan(*number) ? MeasureValue() : MeasureValue(std::lround(*number));
  } else if (auto* const numbers = std::get_if<std::vector<double>>(&value)) {
    for (double& one : *numbers) one *= unit.factor;
  }
  return value;
}

std::span<const MeasureSection> measure_sections() { return kSections; }

std::vector<const RunMeasure*> sweep_measures() {
  std::vector<const RunMeasure*> measures;
  for (const MeasureSection& section : kSections) {
    for (const RunMeasure& measure : section.measures) {
      if (measure.column > 0) measures.push_back(&measure);
    }
  }
  std::ranges::sort(measures, {}, [](const RunMeasure* measure) { return measure->column; });
  return measures;
}

std::vector<MeasuredSection> measure(const RunView& view) {
  std::vector<MeasuredSection> all;
  for (const MeasureSection& section : kSections) {
    if (!section.runs->have(view)) continue;
    MeasuredSection& measured = all.emplace_back(MeasuredSection{&section, {}});
    RunView of = view;
    for (of.item = 0; of.item < (section.items != nullptr ? section.items(view) : 1); ++of.item) {
      std::vector<Measured>& item = measured.items.emplace_back();
      for (const RunMeasure& one : section.measures) {
        if (one.is_in(of)) item.push_back({&one, one.value(of)});
      }
    }
  }
  return all;
}

}  // namespace thenar
