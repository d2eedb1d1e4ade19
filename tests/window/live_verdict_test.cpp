// SPDX-License-Identifier: Apache-2.0
#include "app/window/live_verdict.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "tests/support/scenes.h"

namespace thenar::window::live_verdict_test {
namespace {

/// A scene as the window judges it, in one loop: a tick after the other, without end.
class Watched {
 public:
  explicit Watched(const Model& model) : model_(model), run_(model), verdict(model) {}

  void until(double time_s) {
    while (run_.time_s() < time_s - 1e-9) {
      const TickReport contact = run_.tick();
      ControlSample control;
      control.step.control = run_.report;
      control.muscle_forces_N = run_.controller.f_muscle;
      TickRecord tick = tick_record(model_, run_.state, contact, run_.report);
      verdict.add(tick, run_.state, control);
    }
  }

 private:
  const Model& model_;
  GraspRun run_;

 public:
  LiveVerdict verdict;
};

/// A box that slides out of the fingers once they are wet, first a little and then all the way.
Scene wet_box(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {kCoarseBox, "contact.max_per_finger=5", "time.duration=2 s",
                                        "task.friction=[{at: 0.4 s, to: 0.3}, {at: 0.7 s, to: 0.05}]"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return scene_of("box_grasp", overrides);
}

// Fingers slip, are judged to do so, and lose the box later: the words are those of `thenar run`, which ends there, to
// the last letter, and they stay, for longer than any watch lasts, whatever the hand does without its object.
TEST(LiveVerdict, OfALossIsThatOfARunAndStays) {
  const Model model = build_model(wet_box());
  State state(model);
  const Verdict of_run = run_scene(model, state).verdict;
  ASSERT_EQ(of_run.outcome, Outcome::kLost);
  ASSERT_TRUE(of_run.lost_s);
  Watched live(model);
  live.until(*of_run.lost_s - 0.02);
  EXPECT_EQ(live.verdict.verdict().outcome, Outcome::kSlipping);
  for (const double later_s : {0.0, 1.0, 5.0}) {
    live.until(*of_run.lost_s + later_s);
    EXPECT_EQ(in_words(live.verdict.verdict()), in_words(of_run)) << later_s;
    EXPECT_EQ(live.verdict.verdict().lost_s, of_run.lost_s);
  }
  live.verdict.reset();
  EXPECT_EQ(live.verdict.verdict().outcome, Outcome::kHeld);
}

// A box that slips and sticks again is held again, as the window has always told: also one that has slid by more than
// the scene allows, and was caught.
TEST(LiveVerdict, TellsWhenTheBoxIsHeldAgain) {
  for (const auto& [lost, outcome] : {std::pair("2 mm", Outcome::kSlipping), {"0.15 mm", Outcome::kLost}}) {
    SCOPED_TRACE(lost);
    const Model model = build_model(
        wet_box({std::string("task.lost=") + lost, "task.friction=[{at: 0.4 s, to: 0.15}, {at: 0.405 s, to: 0.8}]"}));
    Watched live(model);
    live.until(0.6);
    EXPECT_EQ(live.verdict.verdict().outcome, outcome) << in_words(live.verdict.verdict());
    live.until(4.2);
    EXPECT_EQ(live.verdict.verdict().outcome, Outcome::kHeld) << in_words(live.verdict.verdict());
  }
}

}  // namespace
}  // namespace thenar::window::live_verdict_test
