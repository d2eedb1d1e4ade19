#include "engine/results/run_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "engine/formats/build_info.h"
#include "engine/results/source_id.h"
#include "engine/results/warnings.h"
#include "solvers/grasp_forces.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

using View = const RunView&;
using Tick = const TickRecord&;
using Value = MeasureValue;
using Values = std::vector<double>;
constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

/// The q-quantile of the finite values; NaN if there are none.
double quantile(Values values, double q) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  std::sort(values.begin(), values.end());
  return percentile(values, q);
}
double largest(const Values& values) { return quantile(values, 1.0); }
double smallest(const Values& values) { return quantile(values, 0.0); }
double root_mean_square(Values values) {
  for (double& v : values) v *= v;
  return std::sqrt(mean(values));
}
Value whole(double value) { return std::isnan(value) ? Value() : Value(std::lround(value)); }
Values scaled(Values values, double scale) {
  for (double& v : values) v *= scale;
  return values;
}

const std::vector<TickRecord>& ticks(View v) { return v.recording->ticks; }
const TickRecord* last_tick(View v) { return ticks(v).empty() ? nullptr : &ticks(v).back(); }
double final_s(View v) { return ticks(v).empty() ? 0.0 : last_tick(v)->time_s - kFinalWindow_s; }

/// One number of every tick from `from_s` on.
template <typename Get>
Values over(View v, double from_s, Get get) {
  Values values;
  for (Tick tick : ticks(v)) {
    if (tick.is_from(from_s)) values.push_back(static_cast<double>(std::invoke(get, tick)));
  }
  return values;
}
template <typename Get>
Values over_all(View v, Get get) {
  return over(v, 0.0, get);
}
/// Likewise where the fingers hold the object: else it has no target.
template <typename Get>
Values over_held(View v, double from_s, Get get) {
  Values values;
  for (Tick tick : ticks(v)) {
    if (tick.holds && tick.is_from(from_s)) values.push_back(get(tick));
  }
  return values;
}
/// A number of each finger in every tick that is measured, or in those before.
Values over_fingers(View v, bool measured, PerFinger<double> TickRecord::*get) {
  Values values;
  for (Tick tick : ticks(v)) {
    if (tick.is_measured() == measured) values.insert(values.end(), (tick.*get).begin(), (tick.*get).end());
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
Values at_end(View v, PerFinger<double> TickRecord::*get) {
  return each_finger(v, [&](int k) { return ticks(v).empty() ? 0.0 : (last_tick(v)->*get)[k]; });
}
template <typename Is>
std::int64_t count(View v, Is is) {
  return std::ranges::count_if(ticks(v), is);
}
/// The first tick of which something is true; null: there is none.
template <typename Is>
const TickRecord* first(View v, Is is) {
  const auto tick = std::ranges::find_if(ticks(v), is);
  return tick == ticks(v).end() ? nullptr : &*tick;
}
double time_of(const TickRecord* tick) { return tick != nullptr ? tick->time_s : kNever; }

template <auto Part>
Value of_ledger(View v) {
  return v.ledger->*Part;
}
template <auto Part>
Value of_excess(View v) {
  return v.verdict->beyond[v.item].*Part;
}

// The object against its target.
Vector3d position_error(Tick tick) { return tick.position_m - tick.target_m; }
double distance(Tick tick) { return position_error(tick).norm(); }
double rotation(Tick tick) { return tick.rotation_error_rad; }
Value off_axis_mm(View v) {
  const Vector3d axis = v.scene->task.translate ? v.scene->task.translate->axis : Vector3d::Zero();
  return 1e3 * largest(over_held(v, kMeasuredFrom_s, [&](Tick tick) {
           const Vector3d error = position_error(tick);
           return (error - error.dot(axis) * axis).norm();
         }));
}

/// Mean over the fingers of |f^d - f| / |f^d|.
double relative_force_error(Tick tick) {
  double sum = 0.0;
  for (std::size_t k = 0; k < tick.force_error_N.size(); ++k) {
    sum += tick.force_error_N[k] / std::hypot(tick.force_desired[k].normal_N, tick.force_desired[k].tangential_N);
  }
  return sum / static_cast<double>(tick.force_error_N.size());
}
double force_error_rms_N(Tick tick) { return root_mean_square({tick.force_error_N.begin(), tick.force_error_N.end()}); }

double contacts(Tick tick) { return static_cast<double>(tick.contact.contacts); }
double sweeps(Tick tick) { return tick.contact.solve.sweeps; }
double residual(Tick tick) {
  const bool touches = tick.contact.contacts > 0 || tick.contact.environment.contacts > 0;
  return touches ? tick.contact.solve.residual : kNever;
}

std::int64_t hold_transitions(View v) {
  std::int64_t transitions = 0;
  bool held = false;
  for (Tick tick : ticks(v)) {
    transitions += tick.contact.held != held ? 1 : 0;
    held = tick.contact.held;
  }
  return transitions;
}

std::int64_t grasp_infeasible(View v) {
  // A run that stops at once has no tick to count.
  const std::optional<UnsolvedGrasp>& unsolved = v.recording->unsolved;
  if (ticks(v).empty() && unsolved && unsolved->control.grasp == GraspStatus::kInfeasible) return 1;
  return count(v, [](Tick t) { return t.grasp == GraspStatus::kInfeasible; });
}

Value least_joint_margin(View v) {
  return smallest(over_all(v, [&](Tick tick) {
    Values of_joints;
    for (Eigen::Index i = 0; i < tick.q_rad.size(); ++i) {
      const Joint& joint = v.scene->hand.joints[i];
      of_joints.push_back(std::min(tick.q_rad[i] - joint.lower_rad, joint.upper_rad - tick.q_rad[i]));
    }
    return smallest(of_joints);
  }));
}
Value largest_stop(View v) {
  return largest(over_all(v, [](Tick t) { return t.contact.stop_Nm.cwiseAbs().maxCoeff(); }));
}

double largest_activation(View v) {
  const auto& f = v.recording->muscle_forces_N;
  double activation = 0.0;
  for (Eigen::Index m = 0; m < f.rows(); ++m) {
    activation = std::max(activation, f.row(m).maxCoeff() / v.scene->hand.muscles[m].max_force_N);
  }
  return activation;
}

/// Over the ticks that ran the stage.
template <typename Get>
Percentiles stage(View v, bool control_only, Get get) {
  Values us;
  for (Tick tick : ticks(v)) {
    const double stage_s = std::invoke(get, tick);
    if ((tick.controlled || !control_only) && stage_s > 0.0) us.push_back(1e6 * stage_s);
  }
  return percentiles(us);
}
template <auto Stage>
Value control_stage(View v) {
  return stage(v, true, Stage);
}
/// The published computation shows fingertips in every tick: where a tick does not, their last time is counted.
Value contact_total(View v) {
  return stage(v, true, [shown_s = 0.0](Tick t) mutable {
    if (t.interpolate_s > 0.0) shown_s = t.interpolate_s;
    return t.contact_total_s() - t.interpolate_s + shown_s;
  });
}

/// What of friction is to spare at a load, torsion left out; NaN without load.
double friction_margin(const NormalTangential& load, double mu) {
  return load.normal_N > 0.0 ? 1.0 - load.tangential_N / (mu * load.normal_N) : kNever;
}
/// The least of each finger once the grip had built up.
template <typename Get>
Values least_of_fingers(View v, Get get) {
  return each_finger(v, [&](int k) { return smallest(over(v, kMeasuredFrom_s, [&](Tick t) { return get(t, k); })); });
}

Values chosen(View v, double StiffnessReport::*what) {
  return over(v, kMeasuredFrom_s, [what](Tick t) {
    return t.stiffness.now && t.stiffness.now->report.is_chosen ? t.stiffness.now->report.*what : kNever;
  });
}
std::int64_t unanswered_stiffness(View v) {
  std::int64_t unanswered = 0;
  const StiffnessRecord* before = nullptr;
  for (Tick tick : ticks(v)) {
    // The ticks of a frame share what its control tick found.
    const StiffnessRecord* const now = tick.stiffness.now.get();
    unanswered += now != nullptr && now != before && now->report.is_unanswered ? 1 : 0;
    before = now;
  }
  return unanswered;
}
/// Three of the diagonal of the stiffness that was chosen last.
Value last_stiffness(View v, int from) {
  if (ticks(v).empty() || !last_tick(v)->stiffness.chosen) return {};
  const auto K = last_tick(v)->stiffness.chosen->report.K_O.diagonal();
  return Values{K[from], K[from + 1], K[from + 2]};
}

bool touches(Tick tick) { return tick.contact.environment.active > 0; }
bool is_wedged(Tick tick) { return tick.contact.environment.wedged; }
const TickRecord* last_touch(View v) {
  const auto last = std::find_if(ticks(v).rbegin(), ticks(v).rend(), touches);
  return last == ticks(v).rend() ? nullptr : &*last;
}
/// On the object, against the scene's gravity, in ticks that touch.
Values vertical_N(View v) {
  const Vector3d up = -v.scene->gravity.normalized();  // Zero without gravity: then nothing is vertical.
  return over_all(
      v, [&](Tick t) { return touches(t) && !up.isZero() ? up.dot(t.contact.environment.wrench.head<3>()) : kNever; });
}
/// How deep the end of the scene's peg is below the plate of its hole as it first wedges; NaN without these. It is as
/// if the object had kept its start's rotation: of 60 mm, 5 degrees make 0.1 mm.
double wedged_depth_m(View v) {
  const TickRecord* const tick = first(v, is_wedged);
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
  const auto range = std::ranges::equal_range(ticks(v), static_cast<int>(v.item), {}, &TickRecord::phase);
  return {range.begin(), range.end()};
}
Phase::Kind kind(View v) { return v.scene->task.phases[v.item].kind; }
bool loads(View v) { return kind(v) == Phase::Kind::kLoad && !phase_ticks(v).empty(); }
bool lifts(View v) { return loads(v) && touches(phase_ticks(v).front()); }
double grip_N(Tick tick) {
  double sum_N = 0.0;
  for (const NormalTangential& force : tick.force) sum_N += force.normal_N;
  return sum_N;
}
/// Pearson's, of grip and load.
Value grip_load_correlation(View v) {
  double n = 0.0, g = 0.0, l = 0.0, gg = 0.0, ll = 0.0, gl = 0.0;
  for (Tick tick : phase_ticks(v)) {
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
double largest_step_m(View v) {
  constexpr double kAround_s = 10e-3;
  const TickRecord* const off = lift_off(v);
  if (off == nullptr) return kNever;
  double most_m = 0.0;
  for (std::size_t i = 1; i < ticks(v).size(); ++i) {
    Tick tick = ticks(v)[i];
    const bool is_near = tick.time_s > off->time_s - kAround_s && tick.time_s < off->time_s + kAround_s;
    if (is_near) most_m = std::max(most_m, (tick.position_m - ticks(v)[i - 1].position_m).norm());
  }
  return most_m;
}

// The grip's answers.
ReflexEvent answer(Tick tick) { return tick.controlled ? tick.reflex.event : ReflexEvent::kNone; }
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
  const TickRecord* const tick =
      first(v, [&](Tick t) { return t.is_from(from_s + v.scene->step_s) && answer(t) != ReflexEvent::kNone; });
  return time_of(tick) - from_s;
}
/// How far a finger slipped from then until the answer's pulse was over.
double answered_slip_m(View v) {
  const double from_s = disturbed_s(v), until_s = onset_s(v) + v.scene->control->reflex->pulse_s;
  double slip_m = kNever;
  PerFinger<double> before_m(v.model->fingers());
  for (Tick tick : ticks(v)) {
    if (!tick.is_from(from_s + v.scene->step_s)) {
      before_m = tick.slip_m;
      continue;
    }
    if (tick.time_s - from_s > until_s) break;
    for (int k = 0; k < v.model->fingers(); ++k) slip_m = std::fmax(slip_m, tick.slip_m[k] - before_m[k]);
  }
  return slip_m;
}

// Which runs have a measure.
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

// Rows: key, unit, value, sentence, label, remark, column, its prefix, runs.
constexpr RunMeasure kName[] = {
    {"scene", "", [](View v) -> Value { return v.scene->name; }, "Name of the scene.", "scene"}};

constexpr RunMeasure kBuild[] = {
    {"type", "", [](View) -> Value { return std::string(build_info::kType); }, "The program's build type."},
    {"flags", "", [](View) -> Value { return std::string(build_info::kFlags); }, "Its compiler's flags."},
    {"compiler", "", [](View) -> Value { return std::string(build_info::kCompiler); }, "Its compiler."},
    {"version", "", [](View) -> Value { return std::string(build_info::kVersion); }, "Its version."},
    {"source", "", [](View) -> Value { return std::string(build_info::kSource); },
     "The commit that it is built of, with `-dirty` if files had changed."}};

constexpr RunMeasure kSimulated[] = {{"simulated_s", "s",
                                      [](View v) -> Value { return ticks(v).empty() ? 0.0 : last_tick(v)->time_s; },
                                      "Simulated time.", "simulated"}};

constexpr RunMeasure kSettings[] = {
    {"contact_rate_hz", "Hz", [](View v) -> Value { return 1.0 / v.scene->step_s; }, "Rate of the contact loop.",
     "contact loop"},
    {"control_rate_hz", "Hz", [](View v) -> Value { return 1.0 / v.scene->control_period_s; },
     "Rate of the control loop.", "control loop"},
    {"control_delay_ms", "ms", [](View v) -> Value { return 1e3 * v.scene->control_delay_s; }, "Delay of its frames.",
     "", "late by"},
    {"tolerance", "", [](View v) -> Value { return v.scene->contact.tolerance; },
     "Residual at which a contact solve stops.", "a contact solve stops at residual"},
    {"max_sweeps", "", [](View v) -> Value { return v.scene->contact.max_sweeps; }, "Sweeps after which it stops, too.",
     "", "or sweeps:"},
    {"grasp_method", "",
     [](View v) -> Value { return v.scene->control ? Value(grasp_method(v.scene->control->cone)) : Value(); },
     "How the grasp forces are computed.", "grasp forces by"},
    {"muscle_method", "",
     [](View v) -> Value {
       if (v.scene->chooses_stiffness()) return "Newton for the stiffness, else active set";
       return v.scene->has_muscles() ? Value("active set") : Value();
     },
     "How the muscle forces are computed.", "", "muscle forces by"},
    {"level", "", [](View v) -> Value { return v.model->level; }, "Level of detail of the pulps.", "", "", 0, "",
     &kSoft}};

constexpr RunMeasure kRemarks[] = {
    {"parts", "", [](View v) -> Value { return v.scene->left_out; },
     "With `model: auto`, a sentence for each part that was left out or kept, and why.", "part"},
    {"warnings", "", [](View v) -> Value { return warnings(*v.model, *v.recording); },
     "A sentence for each way in which the run left its model's range of validity.", "warning"}};

constexpr RunMeasure kObject[] = {
    {"final_error_mm", "mm", [](View v) -> Value { return 1e3 * mean(over_held(v, final_s(v), distance)); },
     "Mean distance from its target over the last 0.3 s.", "final position error", "", 1},
    {"rms_error_mm", "mm",
     [](View v) -> Value { return 1e3 * root_mean_square(over_held(v, kMeasuredFrom_s, distance)); },
     "Root of the mean squared distance from its target, from 0.3 s on, as the next two.", "rms position error", "", 2},
    {"max_off_axis_error_mm", "mm", off_axis_mm, "Largest distance from the line on which the task moves it.",
     "largest off-axis error", "", 3},
    {"max_rotation_deg", "deg",
     [](View v) -> Value { return kDegrees * largest(over_held(v, kMeasuredFrom_s, rotation)); },
     "Largest angle to its target.", "largest rotation error", "", 5},
    {"final_rotation_deg", "deg", [](View v) -> Value { return kDegrees * mean(over_held(v, final_s(v), rotation)); },
     "Mean angle to its target over the last 0.3 s.", "final rotation error", "", 4}};

constexpr RunMeasure kOutcome[] = {
    {"outcome", "", [](View v) -> Value { return to_string(v.verdict->outcome); },
     "[The outcome](../guide/run.md#what-became-of-the-grasp), a word.", "outcome"},
    {"reason", "", [](View v) -> Value { return v.verdict->reason; }, "Everything that was found.", "  reason"},
    {"held", "", [](View v) -> Value { return is_fine(v.verdict->outcome); }, "Whether the object was held."},
    {"lost_at_s", "s", [](View v) -> Value { return v.verdict->lost_s ? Value(*v.verdict->lost_s) : Value(); },
     "When the object was lost.", "", "", 6}};

constexpr RunMeasure kBeyond[] = {
    {"name", "", of_excess<&Excess::name>, "A joint or muscle that passed its limit."},
    {"unit", "", [](View v) -> Value { return v.verdict->beyond[v.item].muscle ? "N" : "rad"; },
     "Unit of the next two."},
    {"limit", "", of_excess<&Excess::limit>,
     "The muscle's largest force, or that end of the joint's range which was passed."},
    {"value", "", of_excess<&Excess::value>, "The worst value."},
    {"at_s", "s", of_excess<&Excess::at_s>, "When that was."},
    {"first_s", "s", of_excess<&Excess::first_s>, "When the limit was first passed."}};

constexpr RunMeasure kGrasp[] = {
    {"max_slip_mm", "mm", [](View v) -> Value { return 1e3 * std::ranges::max(at_end(v, &TickRecord::slip_m)); },
     "[Slip](../guide/run.md#what-the-measures-of-a-grip-mean) of the finger that slipped most.",
     "largest slip of a finger", "", 7},
    {"max_start_slip_mm", "mm",
     [](View v) -> Value { return 1e3 * std::ranges::max(at_end(v, &TickRecord::start_slip_m)); },
     "Largest part of a slip in the first 0.3 s.", "", "of it at the start:", 8},
    {"slip_mm", "mm", [](View v) -> Value { return scaled(at_end(v, &TickRecord::slip_m), 1e3); },
     "Slip of each finger."},
    {"start_slip_mm", "mm", [](View v) -> Value { return scaled(at_end(v, &TickRecord::start_slip_m), 1e3); },
     "The part of the first 0.3 s, of each finger."},
    {"max_spin_deg", "deg",
     [](View v) -> Value { return kDegrees * std::ranges::max(at_end(v, &TickRecord::spin_rad)); },
     "Spin of the finger that turned most.", "largest spin of a finger", "", 9},
    {"max_start_spin_deg", "deg",
     [](View v) -> Value { return kDegrees * std::ranges::max(at_end(v, &TickRecord::start_spin_rad)); },
     "Largest part of a spin in the first 0.3 s.", "", "of it at the start:", 10},
    {"spin_deg", "deg", [](View v) -> Value { return scaled(at_end(v, &TickRecord::spin_rad), kDegrees); },
     "Spin of each finger."},
    {"start_spin_deg", "deg", [](View v) -> Value { return scaled(at_end(v, &TickRecord::start_spin_rad), kDegrees); },
     "The part of the first 0.3 s, of each finger."},
    {"max_sliding_share", "",
     [](View v) -> Value { return largest(over_fingers(v, true, &TickRecord::sliding_share)); },
     "Largest share of a patch that slid, from 0.3 s on.", "largest share of a patch sliding", "", 11},
    {"max_creep_um_per_s", "um/s",
     [](View v) -> Value { return 1e6 * largest(over_fingers(v, true, &TickRecord::creep_m_per_s)); },
     "Largest speed of a point that should stick, from 0.3 s on.", "fastest point that should stick", "", 12},
    {"min_margin", "", [](View v) -> Value { return smallest(over_fingers(v, true, &TickRecord::margin)); },
     "Least margin of a finger, from 0.3 s on.", "least margin", "", 13},
    {"min_start_margin", "", [](View v) -> Value { return smallest(over_fingers(v, false, &TickRecord::margin)); },
     "Least margin of a finger before.", "", "at the start:", 14},
    {"force_error_end", "",
     [](View v) -> Value {
       return v.scene->control ? Value(mean(over(v, final_s(v), relative_force_error))) : Value();
     },
     "Error of the finger forces, as a share of the desired ones: mean over the last 0.3 s.", "final force error",
     "share of the desired forces", 15},
    {"force_error_rms_N", "N",
     [](View v) -> Value {
       return v.scene->control ? Value(root_mean_square(over(v, kMeasuredFrom_s, force_error_rms_N))) : Value();
     },
     "Root of the mean squared error of the finger forces, from 0.3 s on.", "", "", 16},
    {"predicted_paper_law_error", "",
     [](View v) -> Value {
       const std::optional<double>& error = v.recording->predicted_paper_law_error;
       return v.scene->control && error ? Value(*error) : Value();
     },
     "The share that the published law without feedforward would leave.", "  of the law without feedforward",
     "predicted: (I + S)^-1 S f^d"}};

constexpr RunMeasure kContacts[] = {
    {"min", "", [](View v) -> Value { return whole(smallest(over(v, kMeasuredFrom_s, contacts))); },
     "Fewest contacts of a tick, from 0.3 s on, as the next three.", "", "", 17, "contacts_"},
    {"median", "", [](View v) -> Value { return whole(quantile(over(v, kMeasuredFrom_s, contacts), 0.5)); },
     "Median of the contacts.", "contacts, median", "", 18, "contacts_"},
    {"max", "", [](View v) -> Value { return whole(largest(over(v, kMeasuredFrom_s, contacts))); },
     "Most contacts of a tick.", "", "at the most:", 19, "contacts_"},
    {"active_median", "",
     [](View v) -> Value {
       return whole(quantile(over(v, kMeasuredFrom_s, [](Tick t) { return t.contact.active; }), 0.5));
     },
     "Median of the contacts that carry force.", "  of them carrying force", "", 20, "contacts_"},
    {"max_penetration_um", "um",
     [](View v) -> Value { return 1e6 * largest(over_all(v, [](Tick t) { return t.contact.penetration_m; })); },
     "Largest penetration of a pulp into the object.", "deepest penetration of a pulp", "", 21},
    {"residual_p99", "", [](View v) -> Value { return quantile(over_all(v, residual), 0.99); },
     "Natural-map residual that 99 % of the contact solves reach.", "contact residual, p99", "natural map", 22},
    {"sweeps_median", "", [](View v) -> Value { return whole(quantile(over_all(v, sweeps), 0.5)); },
     "Median of the sweeps of a contact solve.", "", "", 23},
    {"sweeps_max", "", [](View v) -> Value { return whole(largest(over_all(v, sweeps))); },
     "Most sweeps of a contact solve.", "", "", 24}};

constexpr RunMeasure kFrames[] = {
    {"handovers", "", [](View v) -> Value { return count(v, [](Tick t) { return t.contact.handed_over; }); },
     "Hand-overs to a new frame.", "", "", 25},
    {"held_ticks", "", [](View v) -> Value { return count(v, [](Tick t) { return t.contact.held; }); },
     "Ticks that held the drive of a frame that was too old.", "ticks on the drive of an old frame", "", 26},
    {"hold_transitions", "", [](View v) -> Value { return hold_transitions(v); }, "Times that this began or ended.", "",
     "transitions:"}};

constexpr RunMeasure kEnergy[] = {
    {"drive_J", "J", of_ledger<&Ledger::drive_J>, "Work of torques, weight, springs and input on the bodies.",
     "energy of the drive"},
    {"viscous_J", "J", of_ledger<&Ledger::viscous_J>, "Taken by the bodies' viscosities."},
    {"deformation_J", "J", of_ledger<&Ledger::deformation_J>, "Work of the contact forces on pulps and a soft object."},
    {"stored_J", "J", of_ledger<&Ledger::stored_J>, "Elastic energy in these at the end."},
    {"injected_J", "J", of_ledger<&Ledger::injected_J>,
     "Work of contacts that push their surfaces on: energy from nowhere.", "  that contact gave", "", 27},
    {"dissipated_J", "J", of_ledger<&Ledger::dissipated_J>, "Taken by the other contacts, by friction above all.", "",
     "and took:", 28},
    {"dropped_J", "J", of_ledger<&Ledger::dropped_J>,
     "Elastic energy of contacts that a new frame or tick no longer had."},
    {"unbalanced_J", "J", [](View v) -> Value { return v.ledger->unbalanced_J(); }, "Error of the balance.",
     "  that the balance misses", "", 29}};

constexpr RunMeasure kSolves[] = {
    {"grasp_infeasible", "", [](View v) -> Value { return grasp_infeasible(v); },
     "Ticks in which grasp forces do not exist.", "ticks without a solution", "grasp forces,", 31},
    {"muscle_infeasible", "",
     [](View v) -> Value { return count(v, [](Tick t) { return t.muscle == MuscleStatus::kInfeasible; }); },
     "Ticks in which muscle forces do not exist.", "", "muscle forces:", 32},
    {"unanswered", "",
     [](View v) -> Value {
       return count(
           v, [](Tick t) { return t.grasp == GraspStatus::kBudgetSpent || t.muscle == MuscleStatus::kBudgetSpent; });
     },
     "Ticks in which one of them was not found.", "", "not found:", 33},
    {"muscle_residual_max", "N m",
     [](View v) -> Value { return largest(over_all(v, &TickRecord::muscle_residual_Nm)); },
     "Largest difference between the muscles' torques and those asked for.", "muscle torque residual", "", 34}};

constexpr RunMeasure kJoints[] = {
    {"least_margin_rad", "rad", least_joint_margin, "Least distance to an end of a joint's range.",
     "least distance to a joint's limit", "", 30, "joints_", &kTurning},
    {"stop_max_Nm", "N m", largest_stop, "Largest moment of a stop at such an end.", "", "", 0, "", &kTurning},
    {"least_margin_m", "m", least_joint_margin, "Least distance to an end of a slide.",
     "least distance to a slide's end", "", 0, "", &kSliding},
    {"stop_max_N", "N", largest_stop, "Largest force of a stop at such an end.", "", "", 0, "", &kSliding}};

constexpr RunMeasure kMuscleForces[] = {
    {"max_force_N", "N", [](View v) -> Value { return v.recording->muscle_forces_N.maxCoeff(); },
     "Largest force of a muscle.", "largest muscle force"},
    {"max_activation", "", [](View v) -> Value { return largest_activation(v); },
     "Largest force of a muscle over the largest that it has.", "  over the most a muscle has", "1: its limit"}};
constexpr RunMeasure kNoForces[] = {{"muscles", "", [](View) -> Value { return {}; }, "Null."}};

constexpr RunMeasure kStages[] = {
    {"find", "us", control_stage<&TickRecord::find_s>, "Contact finding.", "contact finding"},
    {"assemble", "us",
     [](View v) -> Value { return stage(v, false, [](Tick t) { return t.factors_s + t.contact.assemble_s; }); },
     "The contacts' compliance.", "Delassus operator"},
    {"solve", "us", [](View v) -> Value { return stage(v, false, [](Tick t) { return t.contact.solve_s; }); },
     "Contact forces.", "contact forces"},
    {"deform", "us", [](View v) -> Value { return stage(v, false, [](Tick t) { return t.contact.deform_s; }); },
     "Deformation.", "deformation"},
    {"interpolate", "us", [](View v) -> Value { return stage(v, false, &TickRecord::interpolate_s); },
     "Shown surfaces, in the 60 ticks a second that show fingertips.", "surface interpolation"},
    {"contact_total", "us", contact_total,
     "All of these, in control ticks, and the last shown surfaces, as the published computation shows them in every "
     "tick.",
     "contact computation, total", "published: 6, 10, 20 ms at 15, 30, 60 contacts"},
    {"grasp_lcp", "us", control_stage<&TickRecord::grasp_s>, "Grasp forces.", "grasp forces",
     "published, by Lemke: 40 us"},
    {"muscle_lcp", "us", control_stage<&TickRecord::muscle_s>, "Muscle forces.", "muscle forces"},
    {"control_total", "us", control_stage<&TickRecord::control_s>, "The whole control tick.", "control tick, total"}};

constexpr RunMeasure kSpeed[] = {
    {"real_time_factor", "",
     [](View v) -> Value { return (ticks(v).empty() ? 0.0 : last_tick(v)->time_s) / v.recording->wall_s; },
     "Simulated over wall time.", "times real time"}};

constexpr RunMeasure kTouchMeasures[] = {
    {"stick_min", "",
     [](View v) -> Value { return least_of_fingers(v, [](Tick t, int k) { return t.touch[k].stick; }); },
     "For each finger, from 0.3 s on: the least share of its loaded area that stuck.",
     "least share of a patch sticking"},
    {"margin_true", "",
     [](View v) -> Value {
       return least_of_fingers(v, [&](Tick t, int k) {
         return friction_margin(t.force[k], v.model->friction(t.time_s - v.scene->step_s));
       });
     },
     "Likewise, the least of 1 - T/(mu N) with its loads and the contacts' friction at the time.",
     "least margin without torsion"},
    {"friction_felt", "",
     [](View v) -> Value {
       return each_finger(v, [&](int k) { return ticks(v).empty() ? kNever : last_tick(v)->reflex.friction[k]; });
     },
     "For each finger, the friction that the hand felt last.", "friction felt at the end", "", 0, "", &kFelt},
    {"margin_felt", "",
     [](View v) -> Value {
       return least_of_fingers(v, [](Tick t, int k) { return friction_margin(t.force[k], t.reflex.friction[k]); });
     },
     "As `margin_true` with the friction that the hand had felt by then: below 0 if that was less than what bore the "
     "load.",
     "least margin by felt friction", "", 0, "", &kFelt}};

constexpr RunMeasure kChosenStiffness[] = {
    {"min_share", "", [](View v) -> Value { return smallest(chosen(v, &StiffnessReport::share)); },
     "Least share of the requested stiffness that was reached, from 0.3 s on.", "share of the stiffness asked for",
     "at the least; 1: all of it"},
    {"max_squeeze_N", "N", [](View v) -> Value { return largest(chosen(v, &StiffnessReport::squeeze_N)); },
     "Largest rise of the internal force for it, from 0.3 s on."},
    {"unanswered", "", [](View v) -> Value { return unanswered_stiffness(v); },
     "Control periods in which for some share neither forces nor a proof that none exist was found.",
     "  periods without an answer", "neither forces nor a proof that there are none"},
    {"along_N_per_m", "N/m", [](View v) -> Value { return last_stiffness(v, 0); },
     "Last chosen: the stiffness along the object's axes, through `centre`.", "  last chosen, along x, y, z"},
    {"about_Nm_per_rad", "N m/rad", [](View v) -> Value { return last_stiffness(v, 3); }, "Likewise about these axes.",
     "", "about them:"},
    {"sum_N", "N",
     [](View v) -> Value { return v.recording->muscle_forces_N.rightCols(ticks(v).empty() ? 0 : 1).sum(); },
     "Sum of the muscles' forces at the end."}};

constexpr RunMeasure kTouched[] = {
    {"ticks_with_contact", "", [](View v) -> Value { return count(v, touches); }, "Ticks in which it bears force.",
     "ticks in which it is touched"},
    {"first_touch_s", "s", [](View v) -> Value { return time_of(first(v, touches)); }, "End of the first of these.", "",
     "from"},
    {"last_touch_s", "s", [](View v) -> Value { return time_of(last_touch(v)); }, "End of the last.", "", "to"},
    {"lift_off_s", "s",
     [](View v) -> Value {
       const double last_s = time_of(last_touch(v));
       return !ticks(v).empty() && last_tick(v)->is_from(last_s + kUnloaded_s) ? last_s : kNever;
     },
     "The same, if 50 ms or more of the run follow.", "lifted off it"},
    {"ticks_wedged", "", [](View v) -> Value { return count(v, is_wedged); },
     "Ticks in which the line through two sticking contacts lay in both friction cones.", "ticks in which it wedges"},
    {"first_wedged_s", "s", [](View v) -> Value { return time_of(first(v, is_wedged)); }, "End of the first of these.",
     "", "from"},
    {"wedged_depth_mm", "mm", [](View v) -> Value { return 1e3 * wedged_depth_m(v); },
     "Depth of a cylinder's end below the plate of a hole then, to 0.1 mm.", "", "on, at a depth of"},
    {"max_normal_N", "N",
     [](View v) -> Value { return largest(over_all(v, [](Tick t) { return t.contact.environment.normal_N; })); },
     "Largest sum of its normal forces.", "largest normal force"},
    {"min_vertical_N", "N", [](View v) -> Value { return smallest(vertical_N(v)); },
     "Least force on the object against `gravity`, of ticks with contact.", "least vertical force on the object"},
    {"max_vertical_N", "N", [](View v) -> Value { return largest(vertical_N(v)); }, "The largest.", "", "the largest:"},
    {"max_penetration_um", "um",
     [](View v) -> Value {
       return 1e6 * largest(over_all(v, [](Tick t) { return t.contact.environment.penetration_m; }));
     },
     "Largest deformation between object and body.", "deepest penetration"}};

constexpr RunMeasure kPhases[] = {
    {"phase", "", [](View v) -> Value { return to_string(kind(v)); }, "Name of a phase.", "phase"},
    {"from_s", "s", [](View v) -> Value { return phase_ticks(v).empty() ? kNever : phase_ticks(v).front().time_s; },
     "When it began.", "", "from"},
    {"until_s", "s",
     [](View v) -> Value {
       const bool has_ended = !phase_ticks(v).empty() && last_tick(v)->phase > static_cast<int>(v.item);
       return has_ended ? phase_ticks(v).back().time_s : kNever;
     },
     "When it ended.", "", "to"},
    {"grip_load_correlation", "", grip_load_correlation,
     "Correlation of the sum of the fingers' normal forces and the weight that they bore.",
     "  correlation of grip and load", "", 0, "", &kLoads},
    {"lift_off.at_s", "s", [](View v) -> Value { return time_of(lift_off(v)); },
     "When nothing else bore the object any more.", "  the object came off at", "", 0, "", &kLifts},
    {"lift_off.borne_N", "N", [](View v) -> Value { return lift_off(v) != nullptr ? lift_off(v)->borne_N : kNever; },
     "What the fingers bore then.", "", "the fingers bore", 0, "", &kLifts},
    {"lift_off.largest_step_um", "um", [](View v) -> Value { return 1e6 * largest_step_m(v); },
     "The object's largest displacement in a tick within 10 ms of it.", "", "", 0, "", &kLifts}};
constexpr RunMeasure kWeight[] = {{"weight_N", "N",
                                   [](View v) -> Value { return v.scene->object.mass_kg * v.scene->gravity.norm(); },
                                   "Weight of the object.", "weight of the object"}};

constexpr RunMeasure kAnswers[] = {
    {"events.load", "",
     [](View v) -> Value { return count(v, [](Tick t) { return answer(t) == ReflexEvent::kLoad; }); },
     "How often the grip began to answer a load.", "answers to loads"},
    {"events.slip", "",
     [](View v) -> Value { return count(v, [](Tick t) { return answer(t) == ReflexEvent::kSlip; }); },
     "How often it began to answer a slip.", "", "to slips:"},
    {"onset_ms", "ms", [](View v) -> Value { return 1e3 * onset_s(v); },
     "Time from the task's first push or change of friction to the end of the tick in which the first answer began.",
     "  the first one after"},
    {"slip_mm", "mm", [](View v) -> Value { return 1e3 * answered_slip_m(v); },
     "How far the finger that slipped most slid from then until the answer's pulse, or the run, was over.", "",
     "with a slip of"}};

constexpr RunMeasure kChatter[] = {
    {"force_chatter", "", [](View v) -> Value { return v.verdict->force_chatter; },
     "How much of a finger's force changes to and fro from tick to tick, over the last 0.3 s.", "", "", 35}};

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
                                   {"grasp", Heading::kGrasp, &kRun, kGrasp},
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
                                   {"task.phases", Heading::kTask, &kTask, kPhases, phases},
                                   {"task", Heading::kTask, &kTask, kWeight},
                                   {"reflex", Heading::kGrasp, &kReflex, kAnswers},
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
    MeasuredSection& measured = all.emplace_back(&section);
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
