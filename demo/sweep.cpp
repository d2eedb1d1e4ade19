#include "demo/sweep.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <thread>

#include "demo/exit_code.h"
#include "demo/ranks.h"
#include "engine/lockstep.h"
#include "engine/stopwatch.h"
#include "engine/sweep.h"
#include "engine/sweep_journal.h"

namespace {

using namespace thenar;
using FinishedRows = std::map<std::size_t, SweepRow>;

constexpr int kInterrupted = 130;  // As shells have it.

SweepPlan read_plan(const Options& options) {
  SweepPlan plan{options.scene, options.overrides, {}};
  for (const std::string& text : options.vary) plan.vary.push_back(read_variation(text));
  return plan;
}

SweepRow run_row_lockstep(const Model& model) {
  State state(model);
  return sweep_row(model, run_lockstep(model, state));
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
  farewell =
      fmt::format("\nstopped: the rows that had ended are kept in {}; the same command goes on\n", folder.string());
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, interrupted);
}

std::string outcomes_table(const FinishedRows& rows) {
  std::string table;
  for (const Outcome outcome : kOutcomes) {
    const auto count =
        std::ranges::count_if(rows, [&](const auto& row) { return row.second.verdict.outcome == outcome; });
    table += fmt::format("{:<14}{:>8}\n", name(outcome), count);
  }
  return table + fmt::format("{:<14}{:>8}\n", "rows", rows.size());
}

/// The last process to end speaks for all.
int report(const SweepPlan& plan, const SweepJournal::Merged& merged, const Options& options) {
  if (!merged.last) return kDone;
  const std::string file = (options.out / "rows.csv").string();
  if (!options.quiet) std::cout << outcomes_table(merged.rows) << "\nrows in " << file << '\n';
  const std::size_t missing = plan.rows() - merged.rows.size();
  if (missing == 0) return kDone;
  std::cerr << fmt::format(
      "failed: {} of {} rows are missing in {}, for a process ended before its time; the same "
      "command goes on\n",
      missing, plan.rows(), file);
  return kFailed;
}

}  // namespace

int sweep(const Options& options) {
  SweepPlan plan;
  std::optional<SweepJournal> journal;
  std::vector<std::size_t> missing;
  const bool lockstep = options.runner == Runner::kLockstep;
  const auto prepare = [&] {
    plan = read_plan(options);
    static_cast<void>(first_scene(plan));
    claim_sweep_folder(options.out, plan_json(plan, lockstep ? "lockstep" : "monolithic"));
    // By one process for all: a file system of many machines may show each of them another state of the journals.
    return missing_rows(plan, read_journals(options.out));
  };
  const auto enter = [&](const Ranks& me, const std::vector<std::size_t>& all_missing) {
    if (me.rank != 0) plan = read_plan(options);
    journal.emplace(options.out, me.rank);
    missing = all_missing;
  };
  const std::optional<Ranks> me = meet_ranks(prepare, enter);
  if (!me) return kBadUsage;  // Another process has said why.

  say_farewell_to(options.out);
  const std::vector<std::size_t> rows = share_of(missing, *me);
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int jobs = options.jobs > 0 ? options.jobs : me->ranks > 1 ? 1 : cores;
  const std::function<void()> progress = sweep_progress(plan.rows() - missing.size(), rows.size(), options.quiet);
  run_sweep(plan, rows, jobs, lockstep ? run_row_lockstep : run_row, [&](std::size_t row, const SweepRow& result) {
    journal->add(row, result);
    progress();
  });
  return report(plan, journal->finish(plan), options);
}
