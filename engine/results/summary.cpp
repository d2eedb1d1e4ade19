#include "engine/results/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/formats/build_info.h"
#include "engine/loops/percentiles.h"
#include "engine/results/source_id.h"
#include "engine/results/task_results.h"
#include "engine/results/warnings.h"
#include "solvers/grasp_forces.h"

namespace thenar {

using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

using Values = std::vector<double>;

/// The q-quantile of the finite values; NaN, which JSON shows as null, if there are none.
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

/// One number of every tick from `from_s` on.
template <typename Get>
Values collect(const Recording& recording, double from_s, Get get) {
  Values values;
  for (const TickRecord& tick : recording.ticks) {
    if (tick.is_from(from_s)) values.push_back(get(tick));
  }
  return values;
}

double final_window_start(const Recording& recording) {
  return recording.ticks.empty() ? 0.0 : recording.ticks.back().time_s - kFinalWindow_s;
}

Vector3d position_error(const TickRecord& tick) { return tick.position_m - tick.target_m; }

ordered_json object_measures(const Model& model, const Recording& recording) {
  const double final_s = final_window_start(recording);
  // What nobody holds has no target.
  const auto collect_held = [&](double from_s, auto get) {
    Values values;
    for (const TickRecord& tick : recording.ticks) {
      if (tick.holds && tick.is_from(from_s)) values.push_back(get(tick));
    }
    return values;
  };
  const auto distance = [](const TickRecord& tick) { return position_error(tick).norm(); };
  const auto angle = [](const TickRecord& tick) { return tick.rotation_error_rad; };
  const Vector3d axis = model.scene.task.translate ? model.scene.task.translate->axis : Vector3d::Zero();
  const auto off_axis = [&](const TickRecord& tick) {
    const Vector3d error = position_error(tick);
    return (error - error.dot(axis) * axis).norm();
  };
  return {{"final_error_mm", 1e3 * mean(collect_held(final_s, distance))},
          {"rms_error_mm", 1e3 * root_mean_square(collect_held(kMeasuredFrom_s, distance))},
          {"max_off_axis_error_mm", 1e3 * largest(collect_held(kMeasuredFrom_s, off_axis))},
          {"max_rotation_deg", kDegrees * largest(collect_held(kMeasuredFrom_s, angle))},
          {"final_rotation_deg", kDegrees * mean(collect_held(final_s, angle))}};
}

using OfFingers = PerFinger<double>;

/// What the patches did since their first contact, and what of it at the start, while the grip builds up.
ordered_json patch_measures(const Model& model, const Recording& recording) {
  const TickRecord last = recording.ticks.empty() ? TickRecord(model.scene.hand) : recording.ticks.back();
  const auto scaled = [](OfFingers values, double scale) {
    for (double& v : values) v *= scale;
    return values;
  };
  const auto extreme = [&](bool measured, bool most, auto get) {
    Values values;
    for (const TickRecord& tick : recording.ticks) {
      if (tick.is_measured() == measured) values.insert(values.end(), get(tick).begin(), get(tick).end());
    }
    return quantile(values, most ? 1.0 : 0.0);
  };
  const auto margin = [](const TickRecord& tick) -> const OfFingers& { return tick.margin; };
  const auto sliding = [](const TickRecord& tick) -> const OfFingers& { return tick.sliding_share; };
  const auto creep = [](const TickRecord& tick) -> const OfFingers& { return tick.creep_m_per_s; };
  ordered_json measures;
  const auto add = [&](const std::string& name, const OfFingers& whole, const OfFingers& start, double scale) {
    measures["max_" + name] = scale * *std::max_element(whole.begin(), whole.end());
    measures["max_start_" + name] = scale * *std::max_element(start.begin(), start.end());
    measures[name] = scaled(whole, scale);
    measures["start_" + name] = scaled(start, scale);
  };
  add("slip_mm", last.slip_m, last.start_slip_m, 1e3);
  add("spin_deg", last.spin_rad, last.start_spin_rad, kDegrees);
  measures["max_sliding_share"] = extreme(true, true, sliding);
  measures["max_creep_um_per_s"] = 1e6 * extreme(true, true, creep);
  measures["min_margin"] = extreme(true, false, margin);
  measures["min_start_margin"] = extreme(false, false, margin);
  return measures;
}

/// Mean over the fingers of |f^d - f| / |f^d|.
double relative_force_error(const TickRecord& tick) {
  double sum = 0.0;
  for (std::size_t k = 0; k < tick.force_error_N.size(); ++k) {
    sum += tick.force_error_N[k] / std::hypot(tick.force_desired[k].normal_N, tick.force_desired[k].tangential_N);
  }
  return sum / static_cast<double>(tick.force_error_N.size());
}

ordered_json grasp_measures(const Model& model, const Recording& recording) {
  ordered_json grasp = verdict_json(recording.verdict);
  grasp.update(patch_measures(model, recording));
  for (const char* key : {"force_error_end", "force_error_rms_N", "predicted_paper_law_error"}) grasp[key] = nullptr;
  if (!model.scene.control) return grasp;
  grasp["force_error_end"] = mean(collect(recording, final_window_start(recording), relative_force_error));
  grasp["force_error_rms_N"] = root_mean_square(collect(recording, kMeasuredFrom_s, [](const TickRecord& tick) {
    return root_mean_square({tick.force_error_N.begin(), tick.force_error_N.end()});
  }));
  if (recording.predicted_paper_law_error) grasp["predicted_paper_law_error"] = *recording.predicted_paper_law_error;
  return grasp;
}

/// What of friction is to spare at a load, torsion left out; NaN without load.
double friction_margin(const NormalTangential& load, double mu) {
  if (!(load.normal_N > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return 1.0 - load.tangential_N / (mu * load.normal_N);
}

/// The least of each finger once the grip had built up. Loads are true: margins differ by what is known of friction.
ordered_json touch_measures(const Model& model, const Recording& recording) {
  ordered_json measures;
  for (int k = 0; k < model.fingers(); ++k) {
    const auto add_least = [&](const char* key, auto get) {
      measures[key].push_back(smallest(collect(recording, kMeasuredFrom_s, get)));
    };
    add_least("stick_min", [k](const TickRecord& t) { return t.touch[k].stick; });
    add_least("margin_true", [&](const TickRecord& t) {
      return friction_margin(t.force[k], model.friction(t.time_s - model.scene.step_s));
    });
    if (!model.scene.control) continue;
    measures["friction_felt"].push_back(recording.ticks.empty() ? std::numeric_limits<double>::quiet_NaN()
                                                                : recording.ticks.back().reflex.friction[k]);
    add_least("margin_felt", [k](const TickRecord& t) { return friction_margin(t.force[k], t.reflex.friction[k]); });
  }
  return measures;
}

/// The grip's answers. Of the task's first push or change of friction: how late the first answer came after it, and how
/// far a finger slipped from then until the answer's pulse was over.
ordered_json reflex_measures(const Model& model, const Recording& recording) {
  const TaskSettings& task = model.scene.task;
  double from_s = task.push ? task.push->from_s : std::numeric_limits<double>::infinity();
  for (const FrictionStep& step : task.friction) from_s = std::min(from_s, step.from_s);
  int loads = 0, slips = 0;
  double onset_s = std::numeric_limits<double>::quiet_NaN(), slip_m = onset_s;
  OfFingers before_m(model.fingers());
  for (const TickRecord& tick : recording.ticks) {
    const ReflexEvent event = tick.controlled ? tick.reflex.event : ReflexEvent::kNone;
    loads += event == ReflexEvent::kLoad ? 1 : 0;
    slips += event == ReflexEvent::kSlip ? 1 : 0;
    if (!tick.is_from(from_s + model.scene.step_s)) {
      before_m = tick.slip_m;
      continue;
    }
    const double since_s = tick.time_s - from_s;
    if (event != ReflexEvent::kNone && std::isnan(onset_s)) onset_s = since_s;
    if (since_s > onset_s + model.scene.control->reflex->pulse_s) continue;
    for (int k = 0; k < model.fingers(); ++k) slip_m = std::fmax(slip_m, tick.slip_m[k] - before_m[k]);
  }
  return {{"events", {{"load", loads}, {"slip", slips}}}, {"onset_ms", 1e3 * onset_s}, {"slip_mm", 1e3 * slip_m}};
}

double residual_p99(const Recording& recording) {
  return quantile(collect(recording, 0.0,
                          [](const TickRecord& tick) {
                            const bool touches = tick.contact.contacts > 0 || tick.contact.environment.contacts > 0;
                            return touches ? tick.contact.solve.residual : std::numeric_limits<double>::quiet_NaN();
                          }),
                  0.99);
}

ordered_json contact_measures(const Recording& recording) {
  const Values contacts = collect(recording, kMeasuredFrom_s,
                                  [](const TickRecord& tick) { return static_cast<double>(tick.contact.contacts); });
  const Values active = collect(recording, kMeasuredFrom_s,
                                [](const TickRecord& tick) { return static_cast<double>(tick.contact.active); });
  const Values sweeps =
      collect(recording, 0.0, [](const TickRecord& tick) { return static_cast<double>(tick.contact.solve.sweeps); });
  const Values penetration = collect(recording, 0.0, [](const TickRecord& tick) { return tick.contact.penetration_m; });
  const auto whole = [](double value) {
    return std::isnan(value) ? ordered_json(nullptr) : ordered_json(std::lround(value));
  };
  return {{"min", whole(smallest(contacts))},
          {"median", whole(quantile(contacts, 0.5))},
          {"max", whole(largest(contacts))},
          {"active_median", whole(quantile(active, 0.5))},
          {"max_penetration_um", 1e6 * largest(penetration)},
          {"residual_p99", residual_p99(recording)},
          {"sweeps_median", whole(quantile(sweeps, 0.5))},
          {"sweeps_max", whole(largest(sweeps))}};
}

/// What became of the frames.
ordered_json frame_measures(const Recording& recording) {
  std::int64_t handovers = 0, held_ticks = 0, transitions = 0;
  bool held = false;
  for (const TickRecord& tick : recording.ticks) {
    handovers += tick.contact.handed_over ? 1 : 0;
    held_ticks += tick.contact.held ? 1 : 0;
    transitions += tick.contact.held != held ? 1 : 0;
    held = tick.contact.held;
  }
  return {{"handovers", handovers}, {"held_ticks", held_ticks}, {"hold_transitions", transitions}};
}

ordered_json lcp_measures(const Recording& recording) {
  const auto count = [&](auto condition) {
    return std::count_if(recording.ticks.begin(), recording.ticks.end(), condition);
  };
  auto grasp = count([](const TickRecord& tick) { return tick.grasp == GraspStatus::kInfeasible; });
  // A run that stops at once has no tick to count.
  const bool stopped_at_once = recording.ticks.empty() && recording.unsolved;
  if (stopped_at_once && recording.unsolved->control.grasp == GraspStatus::kInfeasible) grasp = 1;
  const Values residuals_Nm = collect(recording, 0.0, [](const TickRecord& tick) { return tick.muscle_residual_Nm; });
  return {{"grasp_infeasible", grasp},
          {"muscle_infeasible", count([](const TickRecord& t) { return t.muscle == MuscleStatus::kInfeasible; })},
          {"unanswered", count([](const TickRecord& t) {
             return t.grasp == GraspStatus::kBudgetSpent || t.muscle == MuscleStatus::kBudgetSpent;
           })},
          {"muscle_residual_max", largest(residuals_Nm)}};
}

/// How far the joints kept from the ends of their ranges, and the most that a stop there bore.
ordered_json joint_measures(const Model& model, const Recording& recording) {
  const Values margins = collect(recording, 0.0, [&](const TickRecord& tick) {
    Values of_joints;
    for (Eigen::Index i = 0; i < tick.q_rad.size(); ++i) {
      const Joint& joint = model.scene.hand.joints[i];
      of_joints.push_back(std::min(tick.q_rad[i] - joint.lower_rad, joint.upper_rad - tick.q_rad[i]));
    }
    return smallest(of_joints);
  });
  const Values stops_Nm =
      collect(recording, 0.0, [](const TickRecord& tick) { return tick.contact.stop_Nm.cwiseAbs().maxCoeff(); });
  if (model.scene.hand.slides) return {{"least_margin_m", smallest(margins)}, {"stop_max_N", largest(stops_Nm)}};
  return {{"least_margin_rad", smallest(margins)}, {"stop_max_Nm", largest(stops_Nm)}};
}

ordered_json muscle_measures(const Model& model, const Recording& recording) {
  const auto& f = recording.muscle_forces_N;
  if (f.size() == 0) return nullptr;
  double activation = 0.0;
  for (Eigen::Index m = 0; m < f.rows(); ++m) {
    activation = std::max(activation, f.row(m).maxCoeff() / model.scene.hand.muscles[m].max_force_N);
  }
  return {{"max_force_N", f.maxCoeff()}, {"max_activation", activation}};
}

/// Once the grip had built up: how much of what was asked for was had, and at the end the stiffness that was chosen,
/// along and about the object's axes through the point that the scene names.
ordered_json stiffness_measures(const Recording& recording) {
  const auto chosen = [&](double StiffnessReport::*what) {
    return collect(recording, kMeasuredFrom_s, [what](const TickRecord& t) {
      const bool is_chosen = t.stiffness.now && t.stiffness.now->report.is_chosen;
      return is_chosen ? t.stiffness.now->report.*what : std::numeric_limits<double>::quiet_NaN();
    });
  };
  std::int64_t unanswered = 0;
  const StiffnessRecord* before = nullptr;
  for (const TickRecord& tick : recording.ticks) {
    // The ticks of a frame share what its control tick found.
    const StiffnessRecord* const now = tick.stiffness.now.get();
    unanswered += now != nullptr && now != before && now->report.is_unanswered ? 1 : 0;
    before = now;
  }
  ordered_json measures = {{"min_share", smallest(chosen(&StiffnessReport::share))},
                           {"max_squeeze_N", largest(chosen(&StiffnessReport::squeeze_N))},
                           {"unanswered", unanswered},
                           {"along_N_per_m", nullptr},
                           {"about_Nm_per_rad", nullptr},
                           {"sum_N", recording.muscle_forces_N.rightCols(recording.ticks.empty() ? 0 : 1).sum()}};
  if (recording.ticks.empty() || !recording.ticks.back().stiffness.chosen) return measures;
  const StiffnessReport& last = recording.ticks.back().stiffness.chosen->report;
  measures["along_N_per_m"] = {last.K_O(0, 0), last.K_O(1, 1), last.K_O(2, 2)};
  measures["about_Nm_per_rad"] = {last.K_O(3, 3), last.K_O(4, 4), last.K_O(5, 5)};
  return measures;
}

/// How deep the end of the scene's peg is below the plate of its hole; NaN without these. It is as if the object had
/// kept its start's rotation: of 60 mm, 5 degrees make 0.1 mm.
double peg_depth_m(const Scene& scene, const TickRecord& tick) {
  const auto* peg = std::get_if<CylinderShape>(&scene.object.shape);
  const std::vector<EnvironmentBody>& bodies = scene.environment->bodies;
  const auto hole = std::ranges::find_if(
      bodies, [](const EnvironmentBody& body) { return std::holds_alternative<HoleShape>(body.shape); });
  if (peg == nullptr || hole == bodies.end()) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Isometry3d& X_WO = scene.object.X_WO;
  const Eigen::Isometry3d X_EO = pose(*hole, {tick.time_s, X_WO.linear() * tick.arm_m}).inverse() * X_WO;
  const double middle_m = (X_EO * tick.position_m).z(), tilt = std::abs(X_EO.linear()(2, 2));
  return 0.5 * peg->length_m * tilt - middle_m;
}

/// What the object did to its environment. Vertical: against the scene's gravity, in ticks that touch.
ordered_json environment_measures(const Scene& scene, const Recording& recording) {
  constexpr double kNever = std::numeric_limits<double>::quiet_NaN();
  const Vector3d up = -scene.gravity.normalized();  // Zero without gravity: then nothing is vertical.
  double first_s = kNever, last_s = kNever, off_s = kNever, wedged_s = kNever, wedged_m = kNever;
  std::int64_t ticks = 0, wedged = 0;
  for (const TickRecord& tick : recording.ticks) {
    if (tick.contact.environment.active > 0) {
      ++ticks;
      if (std::isnan(first_s)) first_s = tick.time_s;
      last_s = tick.time_s;
    }
    wedged += tick.contact.environment.wedged ? 1 : 0;
    if (tick.contact.environment.wedged && std::isnan(wedged_s)) {
      wedged_s = tick.time_s;
      wedged_m = peg_depth_m(scene, tick);
    }
    off_s = tick.is_from(last_s + kUnloaded_s) ? last_s : kNever;
  }
  const Values normals_N =
      collect(recording, 0.0, [](const TickRecord& tick) { return tick.contact.environment.normal_N; });
  const Values penetration_m =
      collect(recording, 0.0, [](const TickRecord& tick) { return tick.contact.environment.penetration_m; });
  const Values vertical_N = collect(recording, 0.0, [&](const TickRecord& tick) {
    const EnvironmentReport& environment = tick.contact.environment;
    return environment.active > 0 && !up.isZero() ? up.dot(environment.wrench.head<3>()) : kNever;
  });
  return {{"ticks_with_contact", ticks},
          {"first_touch_s", first_s},
          {"last_touch_s", last_s},
          {"lift_off_s", off_s},
          {"ticks_wedged", wedged},
          {"first_wedged_s", wedged_s},
          {"wedged_depth_mm", 1e3 * wedged_m},
          {"max_normal_N", largest(normals_N)},
          {"min_vertical_N", smallest(vertical_N)},
          {"max_vertical_N", largest(vertical_N)},
          {"max_penetration_um", 1e6 * largest(penetration_m)}};
}

ordered_json stage_measures(const Recording& recording) {
  ordered_json stages;
  const auto add = [&](const char* name, bool control_only, auto seconds) {
    Values us;
    for (const TickRecord& tick : recording.ticks) {
      const double stage_s = seconds(tick);
      if ((tick.controlled || !control_only) && stage_s > 0.0) us.push_back(1e6 * stage_s);
    }
    stages[name] = {{"p50_us", quantile(us, 0.5)}, {"p99_us", quantile(us, 0.99)}};
  };
  add("find", true, [](const TickRecord& t) { return t.find_s; });
  add("assemble", false, [](const TickRecord& t) { return t.factors_s + t.contact.assemble_s; });
  add("solve", false, [](const TickRecord& t) { return t.contact.solve_s; });
  add("deform", false, [](const TickRecord& t) { return t.contact.deform_s; });
  add("interpolate", false, [](const TickRecord& t) { return t.interpolate_s; });
  // The published one shows fingertips in every tick: where a tick does not, what it took the last time is counted.
  add("contact_total", true, [shown_s = 0.0](const TickRecord& t) mutable {
    if (t.interpolate_s > 0.0) shown_s = t.interpolate_s;
    return t.contact_total_s() - t.interpolate_s + shown_s;
  });
  add("grasp_lcp", true, [](const TickRecord& t) { return t.grasp_s; });
  add("muscle_lcp", true, [](const TickRecord& t) { return t.muscle_s; });
  add("control_total", true, [](const TickRecord& t) { return t.control_s; });
  return stages;
}

}  // namespace

ordered_json verdict_json(const Verdict& verdict) {
  ordered_json beyond = ordered_json::array();
  for (const Excess& excess : verdict.beyond) {
    beyond.push_back({{"name", excess.name},
                      {"unit", excess.muscle ? "N" : "rad"},
                      {"limit", excess.limit},
                      {"value", excess.value},
                      {"at_s", excess.at_s},
                      {"first_s", excess.first_s}});
  }
  return {{"outcome", to_string(verdict.outcome)},
          {"reason", verdict.reason},
          {"held", is_fine(verdict.outcome)},
          {"lost_at_s", verdict.lost_s ? ordered_json(*verdict.lost_s) : ordered_json(nullptr)},
          {"beyond", beyond}};
}

ordered_json build_settings() {
  return {{"type", build_info::kType},
          {"flags", build_info::kFlags},
          {"compiler", build_info::kCompiler},
          {"version", build_info::kVersion},
          {"source", build_info::kSource}};
}

ordered_json ledger_json(const Ledger& ledger) {
  return {
      {"drive_J", ledger.drive_J},     {"viscous_J", ledger.viscous_J},        {"deformation_J", ledger.deformation_J},
      {"stored_J", ledger.stored_J},   {"injected_J", ledger.injected_J},      {"dissipated_J", ledger.dissipated_J},
      {"dropped_J", ledger.dropped_J}, {"unbalanced_J", ledger.unbalanced_J()}};
}

ordered_json loop_settings(const Scene& scene) {
  ordered_json grasp = nullptr, muscles = nullptr;
  if (scene.control) grasp = grasp_method(scene.control->cone);
  if (scene.has_muscles()) muscles = "active set";
  if (scene.chooses_stiffness()) muscles = "Newton for the stiffness, else active set";
  return {{"contact_rate_hz", 1.0 / scene.step_s},
          {"control_rate_hz", 1.0 / scene.control_period_s},
          {"control_delay_ms", 1e3 * scene.control_delay_s},
          {"tolerance", scene.contact.tolerance},
          {"max_sweeps", scene.contact.max_sweeps},
          {"grasp_method", grasp},
          {"muscle_method", muscles}};
}

ordered_json summarize(const Model& model, const Recording& recording) {
  const double simulated_s = recording.ticks.empty() ? 0.0 : recording.ticks.back().time_s;
  ordered_json settings = loop_settings(model.scene);
  if (model.deformable()) settings["level"] = model.level;
  ordered_json summary = {{"scene", model.scene.name},
                          {"build", build_settings()},
                          {"simulated_s", simulated_s},
                          {"settings", settings},
                          {"parts", model.scene.left_out},
                          {"warnings", warnings(model, recording)},
                          {"object", object_measures(model, recording)},
                          {"grasp", grasp_measures(model, recording)},
                          {"contacts", contact_measures(recording)},
                          {"frames", frame_measures(recording)},
                          {"ledger", ledger_json(recording.ticks.empty() ? Ledger{} : recording.ticks.back().ledger)},
                          {"lcp", lcp_measures(recording)},
                          {"joints", joint_measures(model, recording)},
                          {"muscles", muscle_measures(model, recording)},
                          {"stages", stage_measures(recording)},
                          {"real_time_factor", simulated_s / recording.wall_s}};
  if (model.feels()) summary["touch"] = touch_measures(model, recording);
  if (model.scene.chooses_stiffness()) summary["stiffness"] = stiffness_measures(recording);
  if (model.scene.environment) summary["environment"] = environment_measures(model.scene, recording);
  if (!model.scene.task.phases.empty()) summary["task"] = task_measures(model.scene, recording);
  if (model.scene.control && model.scene.control->reflex) summary["reflex"] = reflex_measures(model, recording);
  return summary;
}

}  // namespace thenar
