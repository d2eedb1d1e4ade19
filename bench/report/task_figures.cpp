// SPDX-License-Identifier: Apache-2.0
// What is said of tasks in phases, against where the object is at the end: random variations of three scenes.
//   task_figures [--quick] FILE.json

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/cases/random_tasks.h"
#include "bench/report/figure.h"
#include "engine/control/pose_loop.h"
#include "engine/models/build_model.h"
#include "engine/results/verdict.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

struct Trial {
  RandomTask task;
  bool stands = false;  ///< The sampled loop of each phase is stable, by its poles: what `check` says beforehand.
  Verdict verdict;
  TaskLook look;
};

bool loops_stand(const Scene& scene) {
  const Model model = build_model(scene);
  const PoseLoop loop(model);
  for (int phase = 0; phase < std::ssize(scene.task.phases); ++phase) {
    if (!loop.slowest(pose_gains(scene, phase), loop.delay_steps()).is_stable()) return false;
  }
  return true;
}

std::vector<Trial> trials(std::uint32_t count, double delay_s) {
  std::vector<Trial> all(count);
  tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t seed) {
    Trial& trial = all[seed];
    trial.task = random_task(seed, delay_s);
    trial.stands = loops_stand(trial.task.scene);
    const Recording recording = run_task(trial.task);
    trial.verdict = recording.verdict;
    trial.look = look_at_end(trial.task, recording);
  });
  return all;
}

void add_counts(ordered_json& figure, const char* frames, const std::vector<Trial>& all) {
  for (const char* scene : {"grip_lift", "pick_and_place", "peg_assembly"}) {
    int runs = 0, possible = 0, done = 0, possible_done = 0, untrue = 0, unsaid = 0, stand = 0, stand_done = 0;
    for (const Trial& trial : all) {
      if (trial.task.name != scene) continue;
      const bool is_said = trial.verdict.outcome == Outcome::kTaskDone, is_true = trial.look.is_done();
      ++runs;
      possible += trial.task.is_possible;
      done += is_said;
      possible_done += trial.task.is_possible && is_said;
      stand += trial.task.is_possible && trial.stands;
      stand_done += trial.task.is_possible && trial.stands && is_said;
      untrue += is_said && !is_true;
      unsaid += !is_said && is_true;
    }
    figure["rows"].push_back({scene, frames, runs, done, untrue, unsaid, possible, possible_done, stand, stand_done});
  }
}

void add_tasks(ordered_json& part, bool quick) {
  const std::uint32_t count = quick ? 30 : 200;
  ordered_json& counts = add_figure(
      part, "table", "task_truth", "What is said of a task's end, and where the object is",
      "Random variations of three scenes, seeds from 0 on (bench/cases/random_tasks.h): shape, mass, friction, "
      "squeeze, speeds, damping, tilt, the peg's offset, the step. Untrue: called done, and by an independent look at "
      "the last second's poses the object is not in its place, upright, at rest and free. Possible: by statics without "
      "the engine. Stable: the sampled loop of each phase is, by its poles; a peg in its hole may be steadier than "
      "that.",
      fmt::format("{} runs at each delay", count));
  counts["columns"] = {"scene",
                       "frames",
                       "runs",
                       "called done",
                       "untrue",
                       "done, but called otherwise",
                       "possible",
                       "of these called done",
                       "possible and stable",
                       "of these called done "};
  ordered_json& others = add_figure(part, "table", "task_not_done", "Tasks that statics allow and that were not done",
                                    "By seed, with what was drawn and the reason.", "single runs");
  others["columns"] = {"seed", "frames", "sampled loops", "scene", "drawn", "verdict", "off its place [mm]"};
  for (const double delay_s : {0.0, 5e-3}) {
    const char* const frames = delay_s > 0.0 ? "5 ms late" : "at once";
    const std::vector<Trial> all = trials(count, delay_s);
    add_counts(part["figures"][0], frames, all);
    for (std::size_t seed = 0; seed < all.size(); ++seed) {
      const auto& [task, stands, verdict, look] = all[seed];
      const bool is_untrue = verdict.outcome == Outcome::kTaskDone && !look.is_done();
      if (!is_untrue && (!task.is_possible || verdict.outcome == Outcome::kTaskDone)) continue;
      part["figures"][1]["rows"].push_back({seed, frames, stands ? "stable" : "unstable", task.name, task.variation,
                                            in_words(verdict), 1e3 * look.off_m});
    }
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "task", "Tasks in phases",
      "A phase knows what a hand can know; the outcome is judged by the world: after its last release the object "
      "has to stay, to rest and to be borne.",
      {add_tasks});
}
