// SPDX-License-Identifier: Apache-2.0
// What an environment costs a contact tick, over its contacts.

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "bench/cases/bed_of_balls.h"
#include "bench/cases/recorded.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "engine/grasp/stopwatch.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"

namespace thenar {
namespace {

using nlohmann::ordered_json;

constexpr Eigen::Index kFingers = 60;
constexpr int kFrom = 700, kTo = 800;  // The ticks of recorded_run().

/// The box grasp over so many balls, and the times of its contact ticks.
struct Bed {
  explicit Bed(int n) : balls(n), model(model_of(n)), start(model) {
    while (start.state.tick < kFrom) start.tick();
  }

  static Model model_of(int n) {
    std::vector<std::string> changes = changes_for(kFingers);
    for (const std::string& change : bed_of_balls(n)) changes.push_back(change);
    return build_model(load_scene(THENAR_CONFIGS "/box_grasp.yaml", changes));
  }

  /// The hundred ticks once; the first ones, which find cold caches, do not count.
  void run() {
    constexpr int kDropped = 20;
    GraspRun again(model);
    again.go_on_as(start);
    for (int k = kFrom; k < kTo; ++k) {
      again.control_if_due();
      Stopwatch watch;
      const TickReport tick = again.contact();
      const double tick_us = 1e6 * watch.lap();
      residual = worse(residual, tick.solve.residual);
      active = tick.environment.active;
      if (k >= kFrom + kDropped) us.push_back(tick_us);
    }
  }

  int balls, active = 0;
  Model model;
  GraspRun start;
  std::vector<double> us;
  double residual = 0.0;
};

void growth(ordered_json& part, bool quick) {
  const int turns = quick ? 4 : 40;
  std::deque<Bed> beds;
  for (const int n : {0, 8, 32, 72, 128, 200}) beds.emplace_back(n);
  for (int turn = 0; turn < turns; ++turn) {
    for (Bed& bed : beds) bed.run();
  }
  double worst = 0.0;
  std::vector<double> contacts, p50_us, p99_us, without_us;
  const double nothing_us = percentiles(beds.front().us).p50;
  for (const Bed& bed : beds) {
    const Percentiles us = percentiles(bed.us);
    worst = worse(worst, bed.residual);
    if (bed.balls == 0) continue;
    contacts.push_back(bed.active);
    p50_us.push_back(us.p50);
    p99_us.push_back(us.p99);
    without_us.push_back(nothing_us);
  }
  ordered_json& figure = add_figure(
      part, "curves", "growth_environment", "Contacts with the environment against the time of a tick",
      fmt::format(
          "The whole contact tick of the box grasp with {} contacts of its fingers, over a bed of balls, each a "
          "body, all of which press against the box from below. Every solve to a residual of {:.1g} or better. "
          "The object's environment is eliminated: the time grows linearly, and slowly.",
          kFingers, worst),
      fmt::format("medians and 99th percentiles of {} ticks of each bed, which took turns of {} ticks, the first 20 of "
                  "a turn dropped",
                  beds.front().us.size(), kTo - kFrom));
  figure["x"] = {{"label", "contacts with the environment"}, {"log", true}};
  figure["y"] = {{"label", "time of a contact tick [µs]"}, {"log", true}};
  figure["panels"] = {{{"name", "box grasp over balls"},
                       {"curves",
                        {curve("median", contacts, p50_us), curve("99th percentile", contacts, p99_us),
                         plain_curve("without an environment, median", contacts, without_us)}}}};
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "environment", "Around the object",
                  "What contacts with a table, walls and other bodies cost beside those of the fingers.", {growth});
}
