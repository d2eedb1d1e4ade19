// SPDX-License-Identifier: Apache-2.0
// Friction and compliance of bodies around the object, changed while it runs.

#include <gtest/gtest.h>

#include <string>
#include <variant>

#include "app/window/live_settings.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"
#include "tests/window/shown_session.h"

namespace thenar::window::live_environment_test {
namespace {

using namespace shown_session;

/// On its slope, with loops that are slow enough for a machine that is busy.
Scene resting_box() { return scene_of("resting_box", {"time.step=2 ms"}); }

Set friction_of(double friction) { return {{{"around_friction", friction}}}; }
const Set kSofter{{{"around_m_per_N", 1e-6}}};

// tan(10 degrees) is 0.176: with less friction the box slides down, and with more it stays where it then is.
TEST(LiveEnvironment, ABoxSlidesOnASlopeThatIsWetAndStopsWhereItIsDry) {
  ShownSession shown(resting_box());
  ASSERT_TRUE(shown.passes(0.3));
  const double start_m = shown.value("object", 0);
  ASSERT_TRUE(shown.passes(0.6));
  EXPECT_NEAR(shown.value("object", 0), start_m, 1e-7) << "it lies still";
  EXPECT_EQ(shown.receive(friction_of(0.05)), "");
  ASSERT_TRUE(shown.comes([&] { return shown.value("object", 0) > start_m + 2e-3; }));
  EXPECT_EQ(shown.status()["settings"]["around_friction"], 0.05);
  EXPECT_NEAR(shown.value("touches_margin"), 0.0, 1e-6) << "all friction is used";
  EXPECT_EQ(shown.receive(friction_of(0.5)), "");
  ASSERT_TRUE(shown.comes([&] { return shown.value("touches_margin") > 0.3; }));
  const double now_s = shown.value("time_s");
  ASSERT_TRUE(shown.passes(now_s + 0.3));
  const double stopped_m = shown.value("object", 0);
  ASSERT_TRUE(shown.passes(now_s + 0.6));
  EXPECT_NEAR(shown.value("object", 0), stopped_m, 1e-7);
  EXPECT_EQ(shown.scenes(), 1) << "nothing of it is another scene";
}

/// The box in the hand, against which a table rises by 0.2 mm.
Scene pressed_box() {
  Scene scene = held_box();
  const Eigen::Isometry3d& X_WO = scene.object.X_WO;
  const double half_m = 0.5 * std::get<BoxShape>(scene.object.shape).size_m.z();
  EnvironmentBody table;
  table.shape = HalfSpace{};
  table.X_WE = X_WO * Eigen::Translation3d(0.0, 0.0, -half_m - 0.1e-3);
  table.friction = 0.5;
  table.moves = {{0.3e-3 * X_WO.linear().col(2), 0.1, 0.2}};
  scene.environment = Environment{{table}, 100e-9};
  return scene;
}

// The accurate solve beside the loops knows the environment, too: it finds what the loop found.
TEST(LiveEnvironment, IsPartOfWhatAnAccurateSolveSolves) {
  ShownSession shown(pressed_box());
  ASSERT_TRUE(shown.passes(0.8));
  ASSERT_GT(shown.vector("bodies_N").norm(), 0.05);
  ASSERT_TRUE(shown.comes([&] { return shown.value("reference_residual") >= 0.0; }));
  // The loop ends at a residual of 1e-7, or after 60 sweeps. W of this problem is formed anew: where it leaves out the
  // contacts with the table, the residual is 0.02.
  EXPECT_LT(shown.value("reference_residual"), 1e-4);
  EXPECT_LT(shown.value("reference_error"), 1e-3);
}

TEST(LiveEnvironment, ChangesTheKeysThatItNames) {
  Model model = build_model(resting_box());
  const LiveSettings begun = live_settings(model);
  EXPECT_EQ(begun.number("around_friction"), 0.3);
  EXPECT_EQ(begun.number("around_m_per_N"), 100e-9);
  LiveSettings now = begun;
  ASSERT_EQ(change(friction_of(0.7), now), "");
  ASSERT_EQ(change(kSofter, now), "");
  apply(begun, now, model.scene);
  EXPECT_EQ(model.scene.environment->bodies[0].friction, 0.7);
  EXPECT_EQ(model.scene.environment->compliance_m_per_N, 1e-6);
  EXPECT_EQ(carried_over(begun, now, begun), now);
  EXPECT_EQ(settings_json(now)["around_m_per_N"], 1e-6);
}

// One slider has one value: where bodies differ in friction, there is none for it.
TEST(LiveEnvironment, LeavesFrictionsAloneThatDiffer) {
  Scene scene = resting_box();
  scene.environment->bodies.push_back(scene.environment->bodies[0]);
  const auto is_offered = [](const Scene& of) {
    LiveSettings settings = live_settings(build_model(of));
    return change(friction_of(0.5), settings).empty();
  };
  EXPECT_TRUE(is_offered(scene));
  scene.environment->bodies[1].friction = 0.9;
  EXPECT_FALSE(is_offered(scene));
  LiveSettings settings = live_settings(build_model(scene));
  ASSERT_EQ(change(kSofter, settings), "");
  apply(live_settings(build_model(scene)), settings, scene);
  EXPECT_EQ(scene.environment->bodies[1].friction, 0.9);
}

TEST(LiveEnvironment, OfOtherScenesThereIsNone) {
  const Model model = build_model(held_box());
  LiveSettings settings = live_settings(model);
  EXPECT_NE(change(friction_of(0.5), settings), "");
  EXPECT_NE(change(kSofter, settings), "");
  EXPECT_EQ(settings, live_settings(model));
  EXPECT_FALSE(settings_json(settings).contains("around_m_per_N"));
}

TEST(LiveEnvironment, ReadsWhatLiesInItsRange) {
  EXPECT_TRUE(read_message(R"({"type": "set", "around_friction": 2.0, "around_m_per_N": 1e-9})").message);
  for (const char* wrong : {R"("around_friction": 2.1)", R"("around_friction": -0.1)", R"("around_m_per_N": 0)",
                            R"("around_m_per_N": 1e-4)", R"("around_m_per_N": "soft")"}) {
    EXPECT_FALSE(read_message(std::string(R"({"type": "set", )") + wrong + "}").message) << wrong;
  }
}

}  // namespace
}  // namespace thenar::window::live_environment_test
