// SPDX-License-Identifier: Apache-2.0
#include "engine/results/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "engine/control/control.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/realtime.h"
#include "engine/results/summary.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using Values = std::vector<double>;

double force_step_N(const Snapshot& before, const Snapshot& after) {
  double step_N = 0.0;
  for (std::size_t k = 0; k < after.load.size(); ++k) {
    step_N = std::max(step_N, (after.load[k].force_N - before.load[k].force_N).norm());
  }
  return step_N;
}

std::int32_t narrow(std::int64_t value) {
  return static_cast<std::int32_t>(std::min<std::int64_t>(value, std::numeric_limits<std::int32_t>::max()));
}

}  // namespace

void LoopProfile::add(const ContactSample& sample) {
  const TickReport& tick = sample.step.tick;
  ContactTrace trace;
  trace.deadline_ns = sample.deadline_ns;
  trace.start_ns = sample.start_ns;
  trace.end_ns = sample.end_ns;
  trace.tick = sample.after.tick;
  trace.sequence = tick.sequence;
  trace.frame_age = narrow(tick.frame_age);
  trace.acquire_ns = narrow(sample.step.acquire_ns);
  trace.publish_ns = narrow(sample.step.publish_ns);
  trace.sweeps = tick.solve.sweeps;
  trace.contacts = narrow(tick.contacts);
  trace.residual = static_cast<float>(tick.solve.residual);
  const bool follows = !contact_.empty() && last_.tick + 1 == sample.after.tick;
  trace.force_step_N = static_cast<float>(follows ? force_step_N(last_, sample.after) : kNaN);
  const auto& load = sample.after.load;
  trace.force_N = PerFinger<float>(static_cast<int>(load.size()));
  for (std::size_t k = 0; k < load.size(); ++k) trace.force_N[k] = static_cast<float>(load[k].force_N.norm());
  trace.handed_over = tick.handed_over;
  trace.held = tick.held;
  trace.caught_up = sample.caught_up;
  trace.finite = tick.solve.status != SolveStatus::kNotFinite;
  contact_.push_back(trace);
  last_ = sample.after;
}

void LoopProfile::add(const ControlSample& sample) {
  const ControlReport& control = sample.step.control;
  ControlTrace trace;
  trace.deadline_ns = sample.deadline_ns;
  trace.start_ns = sample.start_ns;
  trace.end_ns = sample.end_ns;
  trace.sequence = sample.step.sequence;
  trace.snapshot_tick = sample.step.snapshot_tick;
  trace.find_us = static_cast<float>(1e6 * control.find_s);
  trace.factors_us = static_cast<float>(1e6 * control.factors_s);
  trace.grasp_us = static_cast<float>(1e6 * control.grasp_s);
  trace.muscle_us = static_cast<float>(1e6 * control.muscle_s);
  trace.published = sample.step.published;
  trace.grasp_found = control.grasp == GraspStatus::kOptimal;
  trace.muscles_found = control.muscle == MuscleStatus::kOptimal;
  trace.stiffness_answered = !control.stiffness.is_unanswered;
  control_.push_back(trace);
  control_slipped_ += sample.slipped;
}

namespace {

/// One number of every trace for which `use` holds.
template <typename Trace, typename Get, typename Use>
Values collect(const std::deque<Trace>& traces, Get get, Use use) {
  Values values;
  for (const Trace& trace : traces) {
    if (std::invoke(use, trace)) values.push_back(static_cast<double>(std::invoke(get, trace)));
  }
  return values;
}

/// With the 9 digits that a time needs; null if it is not finite.
ordered_json finite(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json latency(Values us) {
  const Percentiles p = percentiles(std::move(us));
  return {{"p50_us", finite(p.p50)}, {"p99_us", finite(p.p99)}, {"p999_us", finite(p.p999)}, {"max_us", finite(p.max)}};
}

/// Ticks a second of wall time, from the first start to the last.
template <typename Trace>
ordered_json rate_hz(const std::deque<Trace>& traces) {
  if (traces.size() < 2) return nullptr;
  const auto spent_ns = static_cast<double>(traces.back().start_ns - traces.front().start_ns);
  return finite(1e9 * static_cast<double>(traces.size() - 1) / spent_ns);
}

ordered_json contact_loop(const RealtimeRun& run) {
  const auto& ticks = run.profile.contact();
  const ThreadsReport& report = run.report;
  const Percentiles sweeps = percentiles(collect(ticks, &ContactTrace::sweeps));
  const auto is_unsolved = [](const ContactTrace& t) { return t.contacts > 0 && t.residual > 1e-2F; };
  return {{"rate_hz", rate_hz(ticks)},
          {"ticks", report.ticks},
          {"jitter", latency(collect(ticks, &ContactTrace::jitter_us))},
          {"compute", latency(collect(ticks, &ContactTrace::compute_us))},
          {"overruns", report.overruns},
          {"caught_up", std::ranges::count_if(ticks, &ContactTrace::caught_up)},
          {"slipped", report.slipped},
          {"longest_slip_s", report.longest_slip_s},
          {"lost_samples", report.lost_samples},
          {"sweeps_p50", finite(sweeps.p50)},
          {"sweeps_p99", finite(sweeps.p99)},
          {"residual_above_1e-2", std::ranges::count_if(ticks, is_unsolved)},
          {"not_finite", std::ranges::count(ticks, false, &ContactTrace::finite)}};
}

ordered_json control_loop(const Model& model, const RealtimeRun& run) {
  const auto& ticks = run.profile.control();
  // A stage that the scene does not have takes no time; null says so.
  const auto stage = [&](bool exists, float ControlTrace::*us) -> ordered_json {
    return latency(exists ? collect(ticks, us) : Values());
  };
  const auto& control = model.scene.control;
  return {{"rate_hz", rate_hz(ticks)},
          {"ticks", ticks.size()},
          {"total", latency(collect(ticks, &ControlTrace::total_us))},
          {"jitter", latency(collect(ticks, &ControlTrace::jitter_us))},
          {"slipped", run.profile.control_slipped()},
          {"lost_samples", run.report.lost_control_samples},
          {"refused", std::ranges::count(ticks, false, &ControlTrace::published)},
          {"grasp_unsolved", std::ranges::count(ticks, false, &ControlTrace::grasp_found)},
          {"muscle_unsolved", std::ranges::count(ticks, false, &ControlTrace::muscles_found)},
          {"stiffness_unanswered", std::ranges::count(ticks, false, &ControlTrace::stiffness_answered)},
          {"stages",
           {{"grasp_lcp", stage(control.has_value(), &ControlTrace::grasp_us)},
            {"muscle_lcp", stage(model.scene.has_muscles(), &ControlTrace::muscle_us)},
            {"find", stage(true, &ControlTrace::find_us)},
            {"factors", stage(true, &ControlTrace::factors_us)}}}};
}

ordered_json counts_json(const ExchangeCounts& counts) {
  return {{"published", counts.published}, {"consumed", counts.consumed}, {"superseded", counts.superseded},
          {"in_flight", counts.in_flight}, {"torn", counts.torn},         {"unaccounted", counts.unaccounted()}};
}

ordered_json exchange(const RealtimeRun& run) {
  const auto& ticks = run.profile.contact();
  const Percentiles publish = percentiles(collect(ticks, &ContactTrace::publish_ns));
  const Percentiles acquire = percentiles(collect(ticks, &ContactTrace::acquire_ns, &ContactTrace::handed_over));
  ordered_json json = counts_json(run.report.frames);
  json["publish_p50_ns"] = finite(publish.p50);
  json["publish_p99_ns"] = finite(publish.p99);
  json["acquire_p50_ns"] = finite(acquire.p50);
  json["acquire_p99_ns"] = finite(acquire.p99);
  return json;
}

ordered_json frame_age(const Model& model, const LoopProfile& profile) {
  const double step_ms = 1e3 * model.scene.step_s;
  const Percentiles ms = percentiles(collect(
      profile.contact(), [step_ms](const ContactTrace& t) { return step_ms * static_cast<double>(t.frame_age); }));
  return {{"p50_ms", finite(ms.p50)}, {"p99_ms", finite(ms.p99)}, {"max_ms", finite(ms.max)}};
}

/// Whether a tick ends at this time or later, but for rounding.
auto ends_from(const Model& model, double from_s) {
  return [step_s = model.scene.step_s, from_s](const ContactTrace& t) {
    return static_cast<double>(t.tick) * step_s >= from_s - 1e-9;
  };
}

ordered_json handover(const Model& model, const LoopProfile& profile) {
  const auto measured = ends_from(model, kMeasuredFrom_s);
  const auto step_N = &ContactTrace::force_step_N;
  const Percentiles kick =
      percentiles(collect(profile.contact(), step_N, [&](const auto& t) { return measured(t) && t.handed_over; }));
  const Percentiles tick =
      percentiles(collect(profile.contact(), step_N, [&](const auto& t) { return measured(t) && !t.handed_over; }));
  return {{"count", std::ranges::count_if(profile.contact(), &ContactTrace::handed_over)},
          {"kick_N_max", finite(kick.max)},
          {"kick_N_p99", finite(kick.p99)},
          {"tick_N_p99", finite(tick.p99)},
          {"kick_over_tick_p99", finite(kick.p99 / tick.p99)}};
}

ordered_json hold(const LoopProfile& profile) {
  std::int64_t transitions = 0;
  bool held = false;
  for (const ContactTrace& tick : profile.contact()) {
    transitions += tick.held != held;
    held = tick.held;
  }
  return {{"transitions", transitions}, {"ticks", std::ranges::count_if(profile.contact(), &ContactTrace::held)}};
}

/// The largest distance of the object from its target, once the grip had built up.
double max_error_m(const Recording& recording) {
  double most_m = kNaN;
  for (const TickRecord& tick : recording.ticks) {
    if (tick.is_measured()) most_m = std::fmax(most_m, (tick.position_m - tick.target_m).norm());
  }
  return most_m;
}

ordered_json scheduling(const ThreadsReport& report) {
  const Scheduling& contact = report.contact;
  const Scheduling& control = report.control;
  return {{"policy", contact.policy},
          {"priority", contact.priority},
          {"core", contact.core < 0 ? ordered_json(nullptr) : ordered_json(contact.core)},
          {"locked", contact.memory_locked},
          {"kept_awake", contact.kept_awake},
          {"denormals_flushed", contact.denormals_flushed},
          {"spin_us", contact.spin_us},
          {"timer_slack_ns", contact.timer_slack_ns},
          {"remark", contact.remark},
          {"control",
           {{"policy", control.policy},
            {"priority", control.priority},
            {"core", control.core < 0 ? ordered_json(nullptr) : ordered_json(control.core)},
            {"remark", control.remark}}}};
}

}  // namespace

ordered_json summarize(const Model& model, const RealtimeRun& run) {
  ordered_json summary = summarize(model, run.recording);
  add_loops(model, run, summary);
  return summary;
}

void add_loops(const Model& model, const RealtimeRun& run, ordered_json& summary) {
  const LoopProfile& profile = run.profile;
  summary["object"]["max_error_mm"] = finite(1e3 * max_error_m(run.recording));
  const Ledger ledger = run.recording.ticks.empty() ? Ledger{} : run.recording.ticks.back().ledger;
  summary["ledger"]["injected_over_dissipated"] = finite(ledger.injected_J / ledger.dissipated_J);
  summary["scheduling"] = scheduling(run.report);
  summary["wall_s"] = run.report.wall_s;
  summary["loops"] = {{"contact", contact_loop(run)}, {"control", control_loop(model, run)}};
  summary["exchange"] = exchange(run);
  summary["snapshots"] = counts_json(run.report.snapshots);
  summary["frame_age"] = frame_age(model, profile);
  summary["handover"] = handover(model, profile);
  summary["hold"] = hold(profile);
}

std::optional<std::string> lost_records(const ThreadsReport& report) {
  if (report.lost_samples + report.lost_control_samples == 0) return std::nullopt;
  return fmt::format("the records of {} contact and {} control ticks were lost: nobody saw what they did",
                     report.lost_samples, report.lost_control_samples);
}

}  // namespace thenar
