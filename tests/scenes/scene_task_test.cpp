// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/scenes/config.h"
#include "tests/support/scenes.h"

namespace thenar::scene_task_test {
namespace {

using testing::HasSubstr;

/// What is wrong with grip_lift with these changes; empty: nothing.
std::string fault(const std::vector<std::string>& changes) {
  try {
    static_cast<void>(scene_of("grip_lift", changes));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

std::string with_phases(const std::string& list) { return fault({"task.phases=[" + list + "]"}); }

const std::string kClose = "{close: {press: 0.3 N, speed: 20 mm/s}}", kLoad = "{load: {over: 0.5 s}}",
                  kLift = "{lift: {by: [0 mm, 0 mm, 1 mm], over: 1 s}}",
                  kPlace = "{place: {by: [0 mm, 0 mm, -1 mm], over: 1 s}}",
                  kRelease = "{release: {open: 5 mm, speed: 20 mm/s}}",
                  kApproach = "{approach: {by: [0 mm, 0 mm, 1 mm], over: 1 s}}";

// Phases follow one another as fingers can.
TEST(SceneTask, OrdersThatCannotBeAreRefused) {
  const auto list = [](const std::vector<std::string>& phases) {
    std::string all;
    for (const std::string& phase : phases) all += (all.empty() ? "" : ", ") + phase;
    return with_phases(all);
  };
  EXPECT_EQ(list({kApproach, kClose, kLoad, kLift, kPlace, kRelease, kApproach, kClose}), "");
  EXPECT_EQ(list({kLift, kPlace, kLoad, kLift, kRelease}), "") << "it may begin in the hand";
  EXPECT_EQ(list({kClose, kRelease}), "");
  EXPECT_THAT(list({kClose, kLift}), HasSubstr("task.phases[1].lift: needs fingers that hold the object"));
  EXPECT_THAT(list({kClose, kLoad, kLoad}), HasSubstr("task.phases[2].load: takes over what fingers press"));
  EXPECT_THAT(list({kLift, kClose}), HasSubstr("task.phases[1].close: goes with open fingers"));
  EXPECT_THAT(list({kClose, kRelease, kRelease}), HasSubstr("task.phases[2].release: has nothing to let go of"));
  EXPECT_THAT(list({kPlace, kPlace}), HasSubstr("task.phases[1].place: needs fingers that hold the object"));
}

TEST(SceneTask, WhatPhasesNeedIsToldAtTheirPlace) {
  EXPECT_THAT(with_phases(""), HasSubstr("task.phases: names no phase"));
  EXPECT_THAT(with_phases("{close: {press: 1 N, speed: 1 mm/s}, load: {over: 1 s}}"), HasSubstr("only one of"));
  EXPECT_THAT(with_phases("{grab: {}}"), HasSubstr("task.phases[0].grab"));
  EXPECT_THAT(with_phases("{close: {press: 1 N}}"), HasSubstr("task.phases[0].close.speed: this key is missing"));
  EXPECT_THAT(with_phases("{lift: {by: [0 mm, 0 mm, 1 mm], over: 2 s, within: 1 s}}"),
              HasSubstr("task.phases[0].lift.within: must not be less than the 2 s that it takes"));
  EXPECT_THAT(fault({"task.translate={by: [0 mm, 0 mm, 1 mm], from: 0 s, over: 1 s}"}),
              HasSubstr("task.translate: moves the target by time"));
  EXPECT_THAT(fault({"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}), HasSubstr("task.phases: place needs gravity"));
  EXPECT_THAT(fault({"control.law=paper"}), HasSubstr("task.phases: need control.law: feedforward"));
}

// One number of a phase, as a sweep changes it.
TEST(SceneTask, AChangeReachesIntoTheList) {
  const Scene scene = scene_of("grip_lift", {"task.phases[2].lift.over=2 s", "task.phases[2].lift.within=3 s"});
  EXPECT_EQ(scene.task.phases[2].over_s, 2.0);
  EXPECT_EQ(scene.task.phases[2].within_s, 3.0);
  EXPECT_EQ(scene.task.phases[1].over_s, 0.5);
  EXPECT_EQ(scene_of("grip_lift", {"environment.bodies[0].friction=0.7"}).environment->bodies[0].friction, 0.7);
  EXPECT_THAT(fault({"task.phases[9].lift.over=2 s"}), HasSubstr("task.phases[9] is not in the file's list"));
  EXPECT_THAT(fault({"task.phases[2].load.over=2 s"}), HasSubstr("only one of"));
  for (const char* index : {"[]", "[00]", "[-1]", "[1", "[99999999999999999999]"})
    EXPECT_NE(fault({std::string("environment.bodies") + index + ".friction=0.7"}), "") << index;
}

}  // namespace
}  // namespace thenar::scene_task_test
