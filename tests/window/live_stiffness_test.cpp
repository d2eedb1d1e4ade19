// SPDX-License-Identifier: Apache-2.0
// A stiffness of the object that is chosen by hand while its grasp runs.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <string>
#include <vector>

#include "app/window/live_settings.h"
#include "engine/models/build_model.h"
#include "engine/results/verdict.h"
#include "tests/support/scenes.h"
#include "tests/window/shown_session.h"

namespace thenar::window::live_stiffness_test {
namespace {

using namespace shown_session;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The box of box_stiff, which nobody pushes, with loops that are slow enough for a machine that is busy.
Scene stiff_box(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {kCoarseBox, "time.control_period=10 ms", "contact.max_sweeps=60"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  Scene scene = scene_of("box_stiff", overrides);
  scene.task = {};
  return scene;
}

Matrix3d matrix(ShownSession& shown, const std::string& name) {
  Matrix3d K;
  for (int i = 0; i < 9; ++i) K(i / 3, i % 3) = shown.value(name, static_cast<std::size_t>(i));
  return K;
}

double least_eigenvalue(const Matrix3d& K) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(0.5 * (K + K.transpose())).eigenvalues()[0];
}

double sum_of(ShownSession& shown, const std::string& name) {
  double sum = 0.0;
  for (std::size_t m = 0; m < 23; ++m) sum += shown.value(name, m);
  return sum;
}

Set asked(double along_N_per_m, double about_Nm_per_rad) {
  return {{{"asked_N_per_m", Vector3d::Constant(along_N_per_m).eval()},
           {"asked_Nm_per_rad", Vector3d::Constant(about_Nm_per_rad).eval()}}};
}

/// Waits until all of this is had, and the muscles, of which the slow ones take 40 ms, have had time to follow.
bool has(ShownSession& shown, double along_N_per_m) {
  return shown.comes([&] {
    return shown.value("asked_N_per_m") == along_N_per_m && shown.value("stiffness_share") == 1.0;
  }) && shown.passes(shown.value("time_s") + 0.3);
}

// K_o - K_des is positive semidefinite, and so are its blocks of three, to the 1e-6 of K_des that the solver leaves.
void expect_as_stiff_as_asked(ShownSession& shown) {
  const double along = shown.value("asked_N_per_m"), about = shown.value("asked_Nm_per_rad");
  EXPECT_GE(least_eigenvalue(matrix(shown, "stiffness_N_per_m")), (1.0 - 1e-5) * along);
  EXPECT_GE(least_eigenvalue(matrix(shown, "stiffness_Nm_per_rad")), (1.0 - 1e-5) * about);
}

TEST(LiveStiffness, MusclesPullHarderForMoreAndLessForLess) {
  ShownSession shown(stiff_box());
  EXPECT_EQ(shown.receive(asked(50.0, 0.02)), "");
  ASSERT_TRUE(has(shown, 50.0));
  // A grip that builds up may lack forces for what the scene asks for: it begins again, and is asked for less.
  EXPECT_EQ(shown.receive(Reset{}), "");
  ASSERT_TRUE(shown.passes(0.4));
  expect_as_stiff_as_asked(shown);
  const double few_N = sum_of(shown, "muscles_N");
  // The same torques by the least forces, whatever stiffness: the least there are. Muscles lag by some milliseconds.
  EXPECT_LE(sum_of(shown, "least_muscles_N"), few_N + 1.0);
  EXPECT_EQ(shown.receive(asked(150.0, 0.08)), "");
  ASSERT_TRUE(has(shown, 150.0));
  expect_as_stiff_as_asked(shown);
  const double many_N = sum_of(shown, "muscles_N");
  // Short-range stiffness is in proportion to force: three to four times the stiffness is not for a tenth more.
  EXPECT_GT(many_N, 1.1 * few_N);
  EXPECT_EQ(shown.status()["settings"]["asked_Nm_per_rad"], ordered_json({0.08, 0.08, 0.08}));
  EXPECT_EQ(shown.receive(asked(50.0, 0.02)), "");
  ASSERT_TRUE(has(shown, 50.0));
  EXPECT_LT(sum_of(shown, "muscles_N"), 0.5 * (few_N + many_N));
  // Forces that find their new size may show as chatter for a while.
  const std::string outcome = shown.status()["outcome"];
  EXPECT_TRUE(outcome == "held" || outcome == "unstable") << outcome << ": " << shown.status()["reason"];
  EXPECT_EQ(shown.scenes(), 1) << "nothing of it is another scene";
}

TEST(LiveStiffness, SaysWhatLacksWhereThereAreNoForces) {
  ShownSession shown(stiff_box());
  ASSERT_TRUE(shown.passes(0.4));
  EXPECT_FALSE(shown.value("lack_s") > kMeasuredFrom_s);  // While the grip builds up there may be none.
  EXPECT_EQ(shown.receive(asked(1000.0, 0.5)), "");
  ASSERT_TRUE(
      shown.comes([&] { return shown.value("stiffness_share") < 1.0 && shown.value("lack_s") > kMeasuredFrom_s; }));
  // Unit to rounding.
  EXPECT_NEAR(shown.vector("lack_axis").norm(), 1.0, 1e-9);
  const double along = shown.value("lack_N_per_m"), about = shown.value("lack_Nm_per_rad");
  EXPECT_NE(along > 0.0, about > 0.0) << along << ' ' << about;
  EXPECT_GT(sum_of(shown, "lack_muscles"), 0.0);
  ASSERT_TRUE(shown.comes([&] { return shown.status()["outcome"] == "over limits"; }));
  EXPECT_NE(shown.status()["reason"].get<std::string>().find("no muscle forces make the object so stiff"),
            std::string::npos);
  // What the object is given meanwhile is less, and is had.
  EXPECT_GT(least_eigenvalue(matrix(shown, "stiffness_N_per_m")), 0.0);
  EXPECT_EQ(shown.receive(asked(50.0, 0.02)), "");
  ASSERT_TRUE(has(shown, 50.0));
  expect_as_stiff_as_asked(shown);
}

TEST(LiveStiffness, ChangesTheKeysThatItNames) {
  Model model = build_model(stiff_box());
  const LiveSettings begun = live_settings(model);
  EXPECT_EQ(begun.value("asked_N_per_m"), LiveValue(Vector3d(150.0, 150.0, 150.0)));
  LiveSettings now = begun;
  ASSERT_EQ(change(Set{{{"asked_N_per_m", Vector3d(10.0, 20.0, 30.0)}}}, now), "");
  EXPECT_EQ(now.value("asked_Nm_per_rad"), begun.value("asked_Nm_per_rad"));
  apply(begun, now, model.scene);
  const ObjectStiffness& asked = *model.scene.control->muscles->object_stiffness;
  EXPECT_EQ(asked.translation_N_per_m, Vector3d(10.0, 20.0, 30.0));
  EXPECT_EQ(asked.rotation_Nm_per_rad, Vector3d(0.08, 0.08, 0.08));
  EXPECT_EQ(carried_over(begun, now, begun), now);
}

// The page makes its sliders of the list.
TEST(LiveStiffness, IsListedWithItsRange) {
  int listed = 0;
  for (const ordered_json& one : settings_list(live_settings(build_model(stiff_box())))) {
    if (one.at("type") != "numbers") continue;
    ++listed;
    const std::string name = one.at("name");
    const double most = one.at("most");
    const auto is_read = [&](const ordered_json& value) {
      return read_message(ordered_json{{"type", "set"}, {name, value}}.dump()).message.has_value();
    };
    EXPECT_TRUE(is_read({0.0, one.at("least"), most}));
    EXPECT_FALSE(is_read({0.0, 0.0, 1.001 * most}));
    EXPECT_FALSE(is_read({-1e-9, 0.0, 0.0}));
    EXPECT_FALSE(is_read({0.0, 0.0}));
    EXPECT_FALSE(is_read(most));
    EXPECT_EQ(one.at("default").size(), 3U);
  }
  EXPECT_EQ(listed, 2);
}

// Without a stiffness to choose there is no word of it, and no byte.
TEST(LiveStiffness, OfOtherScenesThereIsNone) {
  Scene only_muscles = stiff_box();
  only_muscles.control->muscles->object_stiffness.reset();
  for (const Scene& scene : {held_box(), only_muscles}) {
    const Model model = build_model(scene);
    LiveSettings settings = live_settings(model);
    EXPECT_NE(change(asked(100.0, 0.1), settings), "");
    EXPECT_EQ(settings, live_settings(model));
    EXPECT_EQ(settings_json(settings).size(), 9U);
    for (const ordered_json& one : settings_list(settings)) EXPECT_NE(one.at("type"), "numbers");
  }
  ShownSession shown(held_box());
  EXPECT_NE(shown.receive(asked(100.0, 0.1)), "");
}

}  // namespace
}  // namespace thenar::window::live_stiffness_test
