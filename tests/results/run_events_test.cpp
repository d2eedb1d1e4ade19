// SPDX-License-Identifier: Apache-2.0
// What happened in a run: from its scene, its ticks and its verdict, in the order of time.
#include "engine/results/run_events.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/scenes.h"

namespace thenar::run_events_test {
namespace {

/// Ticks every 0.1 s from 0.1 s on.
Recording recording_of(const Scene& scene, int ticks) {
  Recording recording;
  for (int i = 1; i <= ticks; ++i) recording.ticks.emplace_back(scene.hand).time_s = 0.1 * i;
  return recording;
}

std::vector<std::string> in_words(const std::vector<RunEvent>& events) {
  std::vector<std::string> words;
  for (const RunEvent& event : events) words.push_back(std::to_string(event.time_s).substr(0, 4) + " " + event.what);
  return words;
}

using Words = std::vector<std::string>;

TEST(RunEvents, FrictionAndTheGripsAnswersAndALoss) {
  const Scene scene = scene_of("box_wet");  // Its friction falls to 0.15 at 0.8 s.
  Recording recording = recording_of(scene, 10);
  for (int i = 8; i < 10; ++i) recording.ticks[i].last_reflex = {ReflexEvent::kSlip, 1, 0.85};
  recording.verdict.lost_s = 0.97;
  const std::string finger = scene.hand.fingertips[1].finger;
  EXPECT_EQ(in_words(run_events(scene, recording)),
            (Words{"0.80 friction falls to 0.15", "0.85 grip answers slip, " + finger, "0.97 lost"}));
  // A run that ends before has seen nothing of it.
  EXPECT_TRUE(run_events(scene, recording_of(scene, 7)).empty());
  EXPECT_TRUE(run_events(scene, {}).empty());
}

TEST(RunEvents, PhasesAsTheyBegin) {
  const Scene scene = scene_of("grip_lift");
  Recording recording = recording_of(scene, 6);
  const std::vector<int> phases{-1, 0, 0, 1, 2, 5};
  for (std::size_t i = 0; i < phases.size(); ++i) recording.ticks[i].phase = phases[i];
  EXPECT_EQ(in_words(run_events(scene, recording)), (Words{"0.20 close", "0.40 load", "0.50 lift", "0.60 task done"}));
  recording.ticks.pop_back();
  recording.verdict.outcome = Outcome::kTaskFailed;
  EXPECT_EQ(in_words(run_events(scene, recording)).back(), "0.50 task failed");
}

TEST(RunEvents, PushAndTarget) {
  const Scene scene = scene_of("box_push");
  ASSERT_TRUE(scene.task.push);
  const std::vector<RunEvent> events = run_events(scene, recording_of(scene, 1000));
  ASSERT_GE(events.size(), 2U);
  EXPECT_EQ(events[0].what, "push");
  EXPECT_EQ(events[0].time_s, scene.task.push->from_s);
  EXPECT_EQ(events[1].what, "push ends");
}

}  // namespace
}  // namespace thenar::run_events_test
