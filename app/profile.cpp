#include "app/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <utility>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "engine/figures/chrome_trace.h"
#include "engine/figures/profile_figures.h"
#include "engine/formats/files.h"
#include "engine/loops/measured_period.h"
#include "engine/loops/percentiles.h"
#include "engine/loops/threads.h"
#include "engine/results/profile.h"
#include "engine/results/recording_file.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/scene_file.h"
#include "engine/studies/cyclictest.h"
#include "engine/studies/load_model.h"
#include "engine/studies/profile_table.h"

namespace thenar::app {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

constexpr double kTrace_s = 5.0;  // A trace of more is slow to open.
constexpr int kPairs = 5;
constexpr double kPair_s = 2.0;  // Of each run, or the scene's duration if that is less.

/// The threads as the command line asks for them.
ThreadSettings thread_settings(const Options& options, double duration_s, double spin_s) {
  ThreadSettings settings;
  settings.duration_s = duration_s;
  settings.spin_s = spin_s;
  settings.realtime = options.realtime;
  settings.core = options.core;
  settings.quiet = options.quiet;
  return settings;
}

/// The scene from its start on two threads.
ThreadsReport run_profiled(const Model& model, double duration_s, double spin_s, const Options& options,
                           LoopProfile& profile, const Progress& progress) {
  State state(model);
  std::int64_t first_ns = 0;
  bool interrupted = false;
  ThreadSettings settings = thread_settings(options, duration_s, spin_s);
  settings.on_first_control = [&](const ControlReport& control, const Eigen::VectorXd& muscle_forces_N) {
    profile.begin(control, muscle_forces_N);
  };
  settings.on_tick = [&](const ContactSample& sample) {
    profile.add(sample);
    if (first_ns == 0) first_ns = sample.deadline_ns;
    const double simulated_s = static_cast<double>(sample.after.tick) * model.scene.step_s;
    const double wall_s = 1e-9 * static_cast<double>(sample.end_ns - first_ns);
    if (progress && !interrupted && !progress(simulated_s, wall_s)) {
      interrupted = true;
      profile.interrupt(simulated_s);
    }
    return !interrupted;
  };
  settings.on_control = [&](const ControlSample& sample) { profile.add(sample); };
  return run_threads(model, state, settings);
}

/// The same, and a recording of it.
ThreadsReport run_filmed(const Model& model, const Options& options, LoopProfile& profile, const Progress& progress,
                         Attempts& results) {
  State state(model);
  RecordingFile film(options.record.file, model, options.record.settings());
  const Progress watched = [&](double simulated_s, double wall_s) {
    const bool goes_on = progress(simulated_s, wall_s);
    if (!goes_on) profile.interrupt(simulated_s);
    return goes_on;
  };
  const RealtimeRun run = run_realtime(model, state, thread_settings(options, model.scene.duration_s, options.spin_s),
                                       profile, watched, &film);
  results.attempt([&] { finish_recording(film, run.recording); });
  return run.report;
}

double median(const std::vector<double>& values) { return percentiles(values).p50; }

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// What the machine can do at best: short runs of ours without a spin and of cyclictest in turns, so that both meet the
/// same neighbours. Null, and a warning, if there is no cyclictest.
ordered_json measure_floor(const Model& model, const Options& options, JitterFloor& floor) {
  if (std::system("command -v cyclictest >/dev/null 2>&1") != 0) {
    std::cerr << "warning: no floor, for cyclictest is missing: apt-get install rt-tests\n";
    return nullptr;
  }
  const double pair_s = std::min(kPair_s, model.scene.duration_s);
  const std::int64_t loops = std::llround(pair_s / model.scene.step_s);
  std::vector<double> theirs_us, ours_us, ratios;
  std::string remark;
  for (int pair = 0; pair < kPairs; ++pair) {
    LoopProfile profile(model);
    const ThreadsReport report = run_profiled(model, pair_s, 0.0, options, profile, {});
    const auto cyclictest = run_cyclictest(report.contact, model.scene.step_s, loops);
    if (!cyclictest) {
      std::cerr << "warning: no floor, for cyclictest was refused what the contact thread was granted\n";
      return nullptr;
    }
    // Without SCHED_FIFO ours asks for short turns, see ask_for_realtime, which cyclictest cannot be told to.
    if (options.realtime && report.contact.policy != "SCHED_FIFO") {
      remark = "cyclictest had no short turns, which the contact thread asks for where SCHED_FIFO is refused";
    }
    const std::vector<double> jitter_us = collect(profile.contact(), &ContactTrace::jitter_us);
    theirs_us.push_back(percentiles(*cyclictest).p99);
    ours_us.push_back(percentiles(jitter_us).p99);
    ratios.push_back(ours_us.back() / theirs_us.back());
    append(floor.cyclictest_us, *cyclictest);
    append(floor.contact_us, jitter_us);
  }
  return {{"pairs", kPairs},          {"pair_s", pair_s}, {"cyclictest_p99_us", theirs_us},
          {"jitter_p99_us", ours_us}, {"ratios", ratios}, {"ratio_p99_median", median(ratios)},
          {"remark", remark}};
}

void write_results(const Model& model, const LoopProfile& profile, const ThreadsReport& report,
                   const JitterFloor& floor, const std::string& json, const fs::path& folder, Attempts& results) {
  results.attempt([&] { write_file(folder / "profile.json", json); });
  // Figures of an earlier run must not pass for this one's.
  const auto remove_figures = [&] {
    std::error_code none;
    for (const char* figure : kProfileFigures) fs::remove(folder / figure, none);
  };
  remove_figures();
  if (profile.contact().empty()) return;
  results.attempt([&] {
    if (draw_profile(model, profile, floor, report.contact.spin_us, folder)) return;
    remove_figures();
    std::cerr << "warning: no figures, for gnuplot is missing or failed\n";
  });
}

std::vector<Result> profile_results(const Options& options) {
  std::vector<Result> results;
  if (!options.out.empty()) {
    results.push_back({"--out", options.out / "profile.json"});
    for (const char* figure : kProfileFigures) results.push_back({"--out", options.out / figure});
  }
  if (!options.trace.empty()) results.push_back({"--trace", options.trace});
  if (options.record.asked()) results.push_back({"--record", options.record.file});
  return results;
}

}  // namespace

Model ready_model(const Options& options, const std::function<void()>& claim) {
  ReadyingLine line(options.quiet);
  const auto is_whole = [&](Model& model) {
    line.hide();
    print_object_notes(model.object_notes, options.quiet);
    claim();
    if (!options.rates.auto_control()) return;
    model.scene.control_period_s = measured_control_period_s(model);
    if (options.quiet) return;
    std::cerr << fmt::format("control rate: {:.4g} Hz, every {:g} ms, which is what this machine keeps\n",
                             1.0 / model.scene.control_period_s, 1e3 * model.scene.control_period_s);
  };
  return load_model(scene_of(options), {.begins = line.begins(), .is_whole = is_whole});
}

int profile(const Options& options) {
  std::optional<FileLock> lock;
  const Model model = ready_model(options, [&] {
    check_results(profile_results(options), scene_files(options.scene, options.overrides));
    if (!options.out.empty()) lock.emplace(claim_folder(options.out, "--out"));
    if (options.trace.has_parent_path()) prepare_folder(options.trace.parent_path());
  });
  if (options.record.asked()) check_record(model, options.record);
  if (options.record.file.has_parent_path()) prepare_folder(options.record.file.parent_path());

  Attempts results;
  JitterFloor floor;
  const ordered_json floor_json = options.floor ? measure_floor(model, options, floor) : nullptr;
  LoopProfile profile(model);
  RunWatch watch(model.scene, options.quiet);
  const ThreadsReport report = options.record.asked() ? run_filmed(model, options, profile, watch.progress(), results)
                                                      : run_profiled(model, model.scene.duration_s, options.spin_s,
                                                                     options, profile, watch.progress());
  watch.end();

  ordered_json json = profile_json(model, profile, report);
  json["floor"] = floor_json;
  if (floor_json.is_object()) {
    json["floor"]["spin"] = {{"spin_us", report.contact.spin_us},
                             {"jitter_p99_us", json["loops"]["contact"]["jitter"]["p99_us"]}};
  }
  if (!options.out.empty()) write_results(model, profile, report, floor, json.dump(2) + "\n", options.out, results);
  if (!options.trace.empty()) {
    results.attempt([&] { write_file(options.trace, chrome_trace(model, profile, kTrace_s)); });
  }
  if (options.format == "json") {
    std::cout << json.dump(2) << '\n';
  } else if (!options.quiet) {
    std::cout << profile_table(json);
    if (!options.out.empty()) std::cout << "\nresults in " << options.out.string() << '\n';
  }
  const int code = report_verdict(model.scene, profile.verdict(report));
  results.finish();
  return watch.interrupted() ? kInterrupted : code;
}

}  // namespace thenar::app
