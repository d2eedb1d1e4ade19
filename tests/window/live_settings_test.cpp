#include "app/window/live_settings.h"

#include <gtest/gtest.h>

#include <string>

#include "app/window/session.h"
#include "tests/support/scenes.h"
#include "tests/window/shown_session.h"

namespace thenar::window::live_settings_test {
namespace {

using namespace shown_session;

TEST(Session, ChangesLevelKernelRatesAndDelayAndHoldsTheBox) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.6));
  const auto goes_on = [&](const Set& set) {
    ASSERT_EQ(shown.receive(set), "");
    const double from_s = shown.value("time_s");
    ASSERT_TRUE(shown.passes(from_s + 0.5));
    EXPECT_LT(shown.value("time_s"), from_s + 30.0);  // time goes on from where it was
    // The forces find their new size within some ticks, which may show as chatter for a while.
    const std::string outcome = shown.status()["outcome"];
    EXPECT_TRUE(outcome == "held" || outcome == "unstable") << outcome << ": " << shown.status()["reason"];
    EXPECT_LT((shown.vector("position_m") - shown.vector("path_target_m")).norm(), 1e-3);
  };
  Set level;
  level.level = 2;
  goes_on(level);
  EXPECT_EQ(shown.scenes(), 2);
  EXPECT_EQ(shown.status()["settings"]["level"], 2);
  Set kernel;
  kernel.kernel = "gaussian";
  goes_on(kernel);
  Set rates;
  rates.contact_Hz = 1000.0;
  rates.control_Hz = 50.0;
  goes_on(rates);
  Set delay;
  delay.delay_periods = 2;
  goes_on(delay);
  EXPECT_GT(shown.value("frame_age_s"), 0.03);  // two to three periods of 20 ms, and with none one at most
  Set back;
  back.level = 0;
  back.kernel = "boussinesq";
  back.delay_periods = 0;
  back.contact_Hz = 500.0;
  goes_on(back);
}

// While a grasp is taken its scene is made, and somebody may move a slider meanwhile.
TEST(LiveSettings, WhatIsSetMeanwhileComesAlong) {
  const LiveSettings before = live_settings(build_model(held_box()));
  LiveSettings begun = before;
  begun.internal_force_N = 1.25;  // By which the grasp was found,
  begun.contact_Hz = 1000.0;
  EXPECT_EQ(carried_over(before, before, begun), begun);
  LiveSettings now = before;
  now.friction = 0.875;
  now.level = 2;
  now.kernel = before.kernel == PulpKernel::kGaussian ? PulpKernel::kBoussinesq : PulpKernel::kGaussian;
  LiveSettings expected = begun;  // which stays.
  expected.friction = now.friction;
  expected.level = now.level;
  expected.kernel = now.kernel;
  EXPECT_EQ(carried_over(before, now, begun), expected);
  // Rigid fingertips have no kernel.
  LiveSettings rigid = begun;
  rigid.kernel.reset();
  rigid.level.reset();
  EXPECT_EQ(carried_over(before, now, rigid), rigid);
}

TEST(Session, RefusesWhatTheSceneCannotDo) {
  ShownSession shown(scene_of("minimal"));
  Set level, rates, fine;
  level.level = 2;
  EXPECT_NE(shown.receive(level), "");
  rates.contact_Hz = 500.0;  // control has 1000
  EXPECT_NE(shown.receive(rates), "");
  rates.control_Hz = 500.0;
  EXPECT_EQ(shown.receive(rates), "");
  fine.internal_force_N = 3.0;
  EXPECT_EQ(shown.receive(fine), "");
  ASSERT_TRUE(shown.comes([&] { return shown.status()["settings"]["internal_force_N"] == 3.0; }));
  EXPECT_TRUE(shown.status()["settings"]["level"].is_null());
  ShownSession box(held_box());
  level.level = 6;  // 320 leaves: 5 control points
  EXPECT_NE(box.receive(level), "");
}

}  // namespace
}  // namespace thenar::window::live_settings_test
