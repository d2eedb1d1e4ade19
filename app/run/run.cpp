// SPDX-License-Identifier: Apache-2.0
#include "app/run/run.h"

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/run/jitter_floor.h"
#include "app/run/loops_table.h"
#include "app/run/table.h"
#include "engine/figures/chrome_trace.h"
#include "engine/figures/figures.h"
#include "engine/figures/profile_figures.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/loops/measured_period.h"
#include "engine/problems/problem_dump.h"
#include "engine/recordings/recording_file.h"
#include "engine/recordings/signals.h"
#include "engine/recordings/thread_film.h"
#include "engine/results/kept_rates.h"
#include "engine/results/profile.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "engine/scenes/scene_file.h"
#include "engine/studies/load_model.h"

namespace thenar::app {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

constexpr double kTrace_s = 5.0;  // A trace of more is slow to open.

bool in_realtime(const Options& options) { return options.runner == Runner::kRealtime; }

std::vector<const char*> all_figures() {
  std::vector<const char*> figures(kFigures.begin(), kFigures.end());
  figures.insert(figures.end(), kProfileFigures.begin(), kProfileFigures.end());
  return figures;
}

void remove_figures(const fs::path& folder) {
  std::error_code none;  // A figure that cannot be removed cannot be drawn either, and then there is a warning.
  for (const char* figure : all_figures()) fs::remove(folder / figure, none);
}

std::vector<Result> results_of(const Options& options) {
  std::vector<Result> results;
  if (!options.out.empty()) {
    for (const char* name : {"summary.json", "signals.csv"}) results.push_back({"--out", options.out / name});
    for (const char* figure : all_figures()) results.push_back({"--out", options.out / figure});
  }
  if (!options.trace.empty()) results.push_back({"--trace", options.trace});
  if (options.record.asked()) results.push_back({"--record", options.record.file});
  return results;
}

/// The folders of a run's results, locked while this lives, and the problems that it writes.
struct ClaimedFolders {
  std::optional<FileLock> out_lock, dump_lock;
  std::optional<ProblemDump> dump;
};

/// Takes the folders of the results. Throws ConfigError where a result would replace an input or another result, and
/// where another run writes.
void claim(const Options& options, ClaimedFolders& claimed) {
  check_results(results_of(options), scene_files(options.scene, options.overrides));
  if (!options.out.empty()) claimed.out_lock.emplace(claim_folder(options.out, "--out"));
  if (options.trace.has_parent_path()) prepare_folder(options.trace.parent_path());
  if (options.dump_problems.empty()) return;
  std::error_code none;
  const bool locked = claimed.out_lock && fs::equivalent(options.out, options.dump_problems, none);
  if (!locked) claimed.dump_lock.emplace(claim_folder(options.dump_problems, "--dump-problems"));
  claimed.dump.emplace(options.dump_problems, options.dump_every);
}

/// The model of the command line. `claim` is called once its scene is known to be good, and before `model: auto` runs
/// it. Where the scene is to run at the control rate that this machine keeps, measures it, sets it and, unless quiet,
/// says so on stderr.
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

/// Begins the recording that is asked for, in place of one that is there. Throws FileError.
void begin_recording(const Options& options, const Model& model, std::optional<RecordingFile>& film) {
  if (!options.record.asked()) return;
  if (options.record.file.has_parent_path()) prepare_folder(options.record.file.parent_path());
  film.emplace(options.record.file, model, options.record.settings());
}

/// The threads as the command line asks for them.
ThreadSettings thread_settings(const Options& options, const Model& model) {
  ThreadSettings settings;
  settings.duration_s = model.scene.duration_s;
  settings.spin_s = options.spin_s;
  settings.realtime = options.realtime;
  settings.core = options.core;
  settings.quiet = options.quiet;
  return settings;
}

/// Runs the scene to its end on two threads.
RealtimeRun run_in_threads(const Options& options, const Model& model, State& state, const Progress& progress,
                           RecordingFile* film) {
  ThreadSettings settings = thread_settings(options, model);
  if (film == nullptr) return run_realtime(model, state, settings, progress);
  ThreadFilm to_file(model, *film, settings);
  RealtimeRun run = run_realtime(model, state, settings, progress, {film});
  to_file.finish();
  return run;
}

/// Runs the scene to its end. On one thread there is a recording alone.
RealtimeRun run_to_end(const Options& options, const Model& model, State& state, const Progress& progress,
                       RecordingFile* film, ProblemDump* dump) {
  if (in_realtime(options)) return run_in_threads(options, model, state, progress, film);
  RunSettings settings{.progress = progress};
  if (film != nullptr) settings.watchers.push_back(film);
  if (dump != nullptr) settings.watchers.push_back(dump);
  if (options.runner == Runner::kLockstep) settings.lockstep = LockstepSettings{.jitter_s = options.control_jitter_s};
  return {.recording = run_scene(model, state, settings), .report = {}, .profile = {}};
}

/// The measures of the run, and after a run on two threads the floor with what this run's spin made of it.
ordered_json summary_of(const Options& options, const Model& model, const RealtimeRun& run, const MeasuredFloor& floor,
                        const std::vector<MeasuredSection>& measures) {
  ordered_json summary = summary_json(measures);
  if (!in_realtime(options)) return summary;
  add_loops(model, run, summary);
  summary["floor"] = floor.json;
  if (floor.json.is_null()) return summary;
  summary["floor"]["spin"] = {{"spin_us", run.report.contact.spin_us},
                              {"jitter_p99_us", summary["loops"]["contact"]["jitter"]["p99_us"]}};
  return summary;
}

/// Writes the numbers of a run. Returns whether signals.csv, which the figures are drawn from, is this run's.
bool write_numbers(const Options& options, const Model& model, const RealtimeRun& run, const ordered_json& summary,
                   Attempts& results) {
  bool has_signals = false;
  if (!options.out.empty()) {
    // Figures of an earlier run must not pass for this one's.
    remove_figures(options.out);
    results.attempt([&] { write_file(options.out / "summary.json", summary.dump(2) + "\n"); });
    results.attempt([&] {
      write_file(options.out / "signals.csv", signals_csv(model, run.recording));
      has_signals = true;
    });
  }
  if (!options.trace.empty()) {
    results.attempt([&] { write_file(options.trace, chrome_trace(model, run.profile, kTrace_s)); });
  }
  return has_signals;
}

void print_answer(const Options& options, const std::vector<MeasuredSection>& measures, const ordered_json& summary,
                  const RealtimeRun& run, const ProblemDump* dump) {
  if (options.format == "json") {
    std::cout << summary.dump(2) << '\n';
  } else if (!options.quiet) {
    std::cout << results_table(measures, in_realtime(options) ? &run.report.contact : nullptr);
    if (in_realtime(options)) std::cout << loops_table(summary);
    if (!options.out.empty()) std::cout << "\nresults in " << printable(options.out.string()) << '\n';
    if (dump != nullptr) {
      std::cout << fmt::format("\nproblems of one tick in {} (--dump-every) in {}: {}\n", options.dump_every,
                               printable(options.dump_problems.string()), counted(dump->files(), "file"));
    }
  }
  std::cout.flush();
}

/// Draws the figures of a run, from its folder's signals.csv and from its profile. Prints a warning on stderr if there
/// is no gnuplot; throws FileError.
void draw(const Model& model, const RealtimeRun& run, const State& state, const JitterFloor& floor,
          const fs::path& folder) {
  if (run.recording.ticks.empty()) return;
  const bool in_one = run.profile.contact().empty();
  if (draw_figures(model, run.recording, state, folder) &&
      (in_one || draw_profile(model, run.profile, floor, run.report.contact.spin_us, folder))) {
    return;
  }
  remove_figures(folder);
  std::cerr << "warning: no figures, for gnuplot is missing or failed\n";
}

}  // namespace

int run(const Options& options) {
  ClaimedFolders claimed;
  const Model model = ready_model(options, [&] { claim(options, claimed); });
  ProblemDump* const dump = claimed.dump ? &*claimed.dump : nullptr;
  if (options.record.asked()) check_record(model, options.record);
  MeasuredFloor floor;
  if (options.floor) floor = measure_floor(model, thread_settings(options, model));
  State state(model);
  RunWatch watch(model.scene, options.quiet);
  std::optional<RecordingFile> film;
  begin_recording(options, model, film);
  const RealtimeRun run = run_to_end(options, model, state, watch.progress(), film ? &*film : nullptr, dump);
  watch.end();

  Attempts results;
  if (film) results.attempt([&] { finish_recording(*film, run.recording); });
  const std::vector<MeasuredSection> measures = measure(view_of(model, run.recording));
  const ordered_json summary = summary_of(options, model, run, floor, measures);
  const bool has_signals = write_numbers(options, model, run, summary, results);
  print_answer(options, measures, summary, run, dump);
  if (in_realtime(options)) {
    for (const std::string& reason : rates_not_kept(summary)) std::cerr << "warning: " << reason << '\n';
  }
  if (dump != nullptr) results.attempt([&] { dump->finish(); });
  const int code = report_verdict(model.scene, run.recording.verdict);
  const bool was_stopped = stop_is_asked();  // Then the verdict says so.
  if (has_signals && options.figures) {
    results.attempt([&] { draw(model, run, state, floor.jitter, options.out); });
  }
  results.finish();
  return code_at_end(code, was_stopped);
}

}  // namespace thenar::app
