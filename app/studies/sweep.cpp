// SPDX-License-Identifier: Apache-2.0
#include "app/studies/sweep.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <iostream>
#include <numeric>
#include <optional>
#include <string>
#include <thread>

#include "app/exit_code.h"
#include "app/results.h"
#include "app/studies/ranks.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/grasp/stopwatch.h"
#include "engine/results/scene_run.h"
#include "engine/sweeps/sweep.h"
#include "engine/sweeps/sweep_journal.h"

namespace thenar::app {

namespace {

SweepPlan read_plan(const Options& options) {
  SweepPlan plan{options.scene, options.overrides, {}};
  for (const std::string& text : options.vary) plan.vary.push_back(read_variation(text));
  return plan;
}

SweepRow run_row_lockstep(const Model& model) {
  State state(model);
  return sweep_row(model, run_scene(model, state, {.lockstep = LockstepSettings{}}));
}

/// What makes a row: "row 3 of 12 (contact.friction=0.5, time.step=1 ms)".
std::string row_in_words(const SweepPlan& plan, std::size_t row) {
  const std::vector<std::string> values = plan.values(row);
  std::string words;
  for (std::size_t i = 0; i < values.size(); ++i) {
    words += fmt::format("{}{}={}", i == 0 ? "" : ", ", plan.vary[i].key, values[i]);
  }
  return fmt::format("row {} of {} ({})", row + 1, plan.rows(), words);
}

std::vector<std::size_t> missing_rows(const SweepPlan& plan, const FinishedRows& finished) {
  std::vector<std::size_t> missing;
  for (std::size_t row = 0; row < plan.rows(); ++row) {
    if (!finished.contains(row)) missing.push_back(row);
  }
  return missing;
}

/// This process's share: all take rows in turns.
std::vector<std::size_t> share_of(const std::vector<std::size_t>& missing, const Ranks& me) {
  std::vector<std::size_t> mine;
  for (std::size_t i = me.rank; i < missing.size(); i += me.ranks) mine.push_back(missing[i]);
  return mine;
}

std::string duration(double s) {
  if (s < 60.0) return fmt::format("{:.0f} s", s);
  if (s < 3600.0) return fmt::format("{:.0f} min {:.0f} s", std::floor(s / 60.0), std::fmod(s, 60.0));
  return fmt::format("{:.0f} h {:.0f} min", std::floor(s / 3600.0), std::fmod(s, 3600.0) / 60.0);
}

/// Tells on a line of stderr how far the sweep is after each row, if somebody is looking. `before` rows were there.
std::function<void()> sweep_progress(std::size_t before, std::size_t to_run, bool quiet) {
  if (quiet || isatty(STDERR_FILENO) == 0 || to_run == 0) return [] {};
  return [=, ran = std::size_t{0}, watch = Stopwatch(), spent_s = 0.0]() mutable {
    spent_s += watch.lap();
    ++ran;
    const double share = static_cast<double>(before + ran) / static_cast<double>(before + to_run);
    const double left_s = spent_s * static_cast<double>(to_run - ran) / static_cast<double>(ran);
    std::fprintf(stderr, "\r[%-30s] %zu of %zu rows, %.0f %%, %s left \033[K%s",
                 std::string(static_cast<std::size_t>(30.0 * share), '#').c_str(), before + ran, before + to_run,
                 100.0 * share, duration(left_s).c_str(), ran == to_run ? "\n" : "");
  };
}

std::string farewell;  // Of whoever interrupts; not changed once the handler is there.

void interrupted(int /*signal*/) {
  // Rows that have ended are in the journal already.
  [[maybe_unused]] const auto told = write(STDERR_FILENO, farewell.data(), farewell.size());
  _exit(kInterrupted);
}

void say_farewell_to(const std::filesystem::path& folder) {
  farewell = fmt::format("\nstopped: the rows that had ended are kept in {}; the same command goes on\n",
                         printable(folder.string()));
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, interrupted);
}

/// Returns the sum of all outcomes.
std::size_t rows_in(const SweepJournal::Outcomes& outcomes) {
  return std::accumulate(outcomes.begin(), outcomes.end(), std::size_t{0},
                         [](std::size_t sum, const auto& outcome) { return sum + outcome.second; });
}

std::string outcomes_table(const SweepJournal::Outcomes& outcomes) {
  std::string table;
  for (const Outcome outcome : kOutcomes) {
    const auto count = outcomes.find(outcome);
    table += fmt::format("{:<14}{:>8}\n", to_string(outcome), count == outcomes.end() ? 0 : count->second);
  }
  return table + fmt::format("{:<14}{:>8}\n", "rows", rows_in(outcomes));
}

/// The last process to end speaks for all.
int report(const SweepPlan& plan, const std::optional<SweepJournal::Outcomes>& outcomes, const Options& options) {
  if (!outcomes) return kDone;
  const std::string file = printable((options.out / "rows.csv").string());
  if (!options.quiet) std::cout << outcomes_table(*outcomes) << "\nrows in " << file << '\n';
  const std::size_t missing = plan.rows() - rows_in(*outcomes);
  if (missing == 0) return kDone;
  std::cerr << fmt::format(
      "failed: {} of {} rows are missing in {}: they were not run, or their process ended before its time; the same "
      "command goes on\n",
      missing, plan.rows(), file);
  return kFailed;
}

}  // namespace

int sweep(const Options& options) {
  const KeptFiles kept;
  SweepPlan plan;
  nlohmann::ordered_json plan_text;
  std::optional<FileLock> claim;
  std::optional<SweepJournal> journal;
  std::vector<std::size_t> missing;
  const bool lockstep = options.runner == Runner::kLockstep;
  const auto read_files = [&] {
    plan = read_plan(options);
    keep_files(plan);
    plan_text = plan_json(plan, lockstep ? "lockstep" : "monolithic");
  };
  const auto prepare = [&] {
    read_files();
    static_cast<void>(first_scene(plan));
    check_results({{"--out", options.out / "rows.csv"}, {"--out", options.out / "plan.json"}}, files_of(plan));
    claim.emplace(claim_sweep_folder(options.out, plan_text));
    // By one process for all: a file system of many machines may show each of them another state of the journals.
    return missing_rows(plan, FinishedRows(options.out, plan, plan_text));
  };
  const auto enter = [&](const Ranks& me, const std::vector<std::size_t>& all_missing) {
    if (me.rank != 0) read_files();
    journal.emplace(options.out, me.rank, plan_text);
    missing = all_missing;
  };
  const std::optional<Ranks> me = meet_ranks(prepare, enter);
  if (!me) return kBadUsage;  // Another process has said why.
  claim.reset();              // Whoever comes now finds the journals locked.

  say_farewell_to(options.out);
  const std::vector<std::size_t> rows = share_of(missing, *me);
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int jobs = options.jobs > 0 ? options.jobs : me->ranks > 1 ? 1 : cores;
  const std::function<void()> progress = sweep_progress(plan.rows() - missing.size(), rows.size(), options.quiet);
  const auto done = [&](std::size_t row, const SweepRow& result) {
    journal->add(row, result);
    progress();
  };
  const auto failed = [&](std::size_t row, const std::string& why) {
    std::cerr << fmt::format("not run: {}: {}\n", row_in_words(plan, row), why);
  };
  run_sweep(plan, rows, jobs, lockstep ? run_row_lockstep : run_row, {done, failed});
  return report(plan, journal->finish(plan), options);
}

}  // namespace thenar::app
