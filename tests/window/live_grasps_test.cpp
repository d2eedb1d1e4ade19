// SPDX-License-Identifier: Apache-2.0
// Grasps that a page has searched for while the scene runs, and has run.

#include "app/window/live_grasps.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "engine/recordings/state_message.h"
#include "engine/results/tick_fields.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scratch.h"
#include "tests/window/shown_session.h"

namespace thenar::window::live_grasps_test {
namespace {

using namespace shown_session;

// A search gives way to all others: on a busy machine it has a twentieth of a core, or less, and needs some seconds.
constexpr std::chrono::seconds kSearchPatience{600};

/// The newest message once the search of this number has ended.
ordered_json ended(ShownSession& shown, int search) {
  const auto has_ended = [&] {
    const ordered_json grasps = shown.grasps();
    return grasps.value("search", 0) == search && grasps["running"] == false;
  };
  EXPECT_TRUE(shown.comes(has_ended, kSearchPatience));
  return shown.grasps();
}

/// The scene that a page saves.
Scene saved(const ordered_json& grasp) {
  const std::filesystem::path file = scratch() / "grasp.yaml";
  std::filesystem::copy_file(std::string(THENAR_CONFIGS) + "/hand.yaml", file.parent_path() / "hand.yaml",
                             std::filesystem::copy_options::overwrite_existing);
  std::ofstream(file) << grasp["scene"].get<std::string>();
  return load_scene(file);
}

/// Forces of the three fingers on the object, in the newest state.
Eigen::VectorXd forces_N(ShownSession& shown) {
  Eigen::VectorXd forces(9);
  for (int i = 0; i < 9; ++i) forces[i] = shown.value("force_N", static_cast<std::size_t>(i));
  return forces;
}

/// Whether the time begins again, from where it was after `time_s`, and comes there.
bool begins_and_passes(ShownSession& shown, double time_s) {
  return shown.comes([&] { return shown.value("time_s") < time_s; }) && shown.passes(time_s);
}

TEST(LiveGrasps, AreFoundWhileTheSceneRunsAndTheOneTakenRuns) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.6));
  EXPECT_EQ(shown.grasps()["search"], 0);
  const double before_s = shown.value("time_s");
  ASSERT_EQ(shown.receive(Find{2}), "");
  const ordered_json found = ended(shown, 1);
  EXPECT_GT(shown.value("time_s"), before_s) << "the loops do not wait for a search";
  EXPECT_EQ(shown.scenes(), 1);
  EXPECT_TRUE(found["refusal"].is_null()) << found["refusal"];
  EXPECT_EQ(found["taken"], 0);
  ASSERT_GE(found["grasps"].size(), 1U);
  ASSERT_LE(found["grasps"].size(), 2U);
  for (const ordered_json& grasp : found["grasps"]) {
    EXPECT_GT(grasp["margin"].get<double>(), 0.0);
    EXPECT_GT(grasp["press_N"].get<double>(), 0.0);
    EXPECT_EQ(grasp["hand"]["poses"].size(), 12 * grasp["hand"]["segments"].size());
    EXPECT_EQ(grasp["hand"]["fingers"].size(), grasp["fingers"].size());
    EXPECT_EQ(grasp["object"].size(), 12U);
  }

  ASSERT_EQ(shown.receive(Take{1, 1}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.grasps()["taken"] == 1 && shown.scenes() == 2; }));
  ASSERT_TRUE(begins_and_passes(shown, 0.6));
  EXPECT_EQ(shown.status()["outcome"], "held") << shown.status()["reason"];
  // It began where the grasp was found. At rest, and without the task, it stays there within a pulp's give.
  const ordered_json& object = found["grasps"][0]["object"];
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(shown.value("object", i), object[i].get<double>(), 1e-3);

  ASSERT_EQ(shown.receive(Take{1, 0}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.grasps()["taken"] == 0 && shown.scenes() == 3; }));
  ASSERT_TRUE(begins_and_passes(shown, 0.3));
  const Scene own = held_box();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(shown.value("object", static_cast<std::size_t>(i)), own.object.X_WO.translation()[i], 1e-3);
  }
}

TEST(LiveGrasps, AreRefusedInWords) {
  ShownSession shown(held_box());
  EXPECT_NE(shown.receive(StopFinding{}), "");
  EXPECT_NE(shown.receive(Take{0, 1}), "") << "nothing was found yet";
  ASSERT_EQ(shown.receive(Find{20}), "");
  EXPECT_NE(shown.receive(Find{1}), "") << "one search at a time";
  EXPECT_NE(shown.receive(Take{1, 1}), "") << "it is not found yet";
  ASSERT_EQ(shown.receive(StopFinding{}), "");
  const ordered_json stopped = ended(shown, 1);
  EXPECT_NE(stopped["grasps"].empty(), stopped["refusal"].is_null()) << "what was found until then, or why nothing";
  // Nothing can be held almost without friction, and the reason comes with what would help.
  ASSERT_EQ(shown.receive(Set{{{"friction", 0.01}}}), "");
  ASSERT_EQ(shown.receive(Find{1}), "");
  const ordered_json refused = ended(shown, 2);
  EXPECT_TRUE(refused["grasps"].empty());
  ASSERT_TRUE(refused["refusal"].is_object());
  EXPECT_NE(refused["refusal"]["reason"], "");
  EXPECT_NE(shown.receive(Take{1, 1}), "") << "of a search before";
  EXPECT_NE(shown.receive(Take{2, 1}), "");
}

// What is saved is the scene that runs: a file that loads, with the friction that was set when it was searched.
TEST(LiveGrasps, AreSavedAsScenes) {
  ShownSession shown(held_box());
  ASSERT_EQ(shown.receive(Set{{{"friction", 0.75}}}), "");
  ASSERT_EQ(shown.receive(Find{1}), "");
  const ordered_json found = ended(shown, 1);
  ASSERT_FALSE(found["grasps"].empty());
  const ordered_json& grasp = found["grasps"][0];
  const Scene scene = saved(grasp);
  EXPECT_EQ(scene.contact.friction, 0.75);
  EXPECT_FALSE(scene.grasp.has_value());
  // The text has nine digits or more.
  const auto object = pose_numbers(scene.object.X_WO);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(object[i], grasp["object"][i].get<double>(), 1e-8) << i;
  const ordered_json hand = posture_json(scene.hand, scene.posture);
  for (std::size_t i = 0; i < hand["poses"].size(); ++i) {
    EXPECT_NEAR(hand["poses"][i].get<double>(), grasp["hand"]["poses"][i].get<double>(), 1e-8) << i;
  }
}

// The first state of a scene whose fingers settle is pressed and sheared, and so is its start when it is taken again.
TEST(LiveGrasps, TheScenesOwnStartSettlesAgain) {
  ShownSession shown(held_box({"hand.settle=true"}));
  ASSERT_EQ(shown.receive(Pause{}), "");
  ASSERT_EQ(shown.receive(Reset{}), "");
  ASSERT_TRUE(shown.rests());
  ASSERT_EQ(shown.value("time_s"), 0.0);
  const Eigen::VectorXd start_N = forces_N(shown);
  ASSERT_EQ(shown.receive(Step{}), "");
  ASSERT_TRUE(shown.passes(0.0));
  const Eigen::VectorXd stepped_N = forces_N(shown);
  const double largest_N = start_N.cwiseAbs().maxCoeff();
  EXPECT_GT(largest_N, 0.1);

  ASSERT_EQ(shown.receive(Take{0, 0}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.scenes() == 2 && shown.value("time_s") == 0.0; }));
  // It settles to two thousandths of a finger's normal force or, where it has settled before, to four.
  EXPECT_LE((forces_N(shown) - start_N).cwiseAbs().maxCoeff(), 0.01 * largest_N);
  ASSERT_EQ(shown.receive(Step{}), "");
  ASSERT_TRUE(shown.passes(0.0));
  EXPECT_LE((forces_N(shown) - stepped_N).cwiseAbs().maxCoeff(), 0.01 * largest_N);
}

// A grasp that is taken keeps what was set before it was searched, and so does the next search.
TEST(LiveGrasps, ASearchAfterATakeKeepsWhatWasSet) {
  ShownSession shown(held_box());
  ASSERT_EQ(shown.receive(Set{{{"friction", 0.75}, {"contact_Hz", 1000.0}, {"internal_force_N", 3.0}}}), "");
  const auto found = [&](int search) {
    EXPECT_EQ(shown.receive(Find{1}), "");
    const ordered_json message = ended(shown, search);
    EXPECT_FALSE(message["grasps"].empty()) << message["refusal"];
    return message;
  };
  const ordered_json first = found(1);
  ASSERT_FALSE(first["grasps"].empty());
  EXPECT_EQ(saved(first["grasps"][0]).step_s, 1e-3);
  ASSERT_EQ(shown.receive(Take{1, 1}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.grasps()["taken"] == 1; }));
  const ordered_json second = found(2);
  ASSERT_FALSE(second["grasps"].empty());
  EXPECT_TRUE(second["taken"].is_null()) << "it runs still, and is none of this search";
  EXPECT_EQ(second["grasps"][0]["scene"], first["grasps"][0]["scene"]);
  // With the scene's own start come its own settings.
  ASSERT_EQ(shown.receive(Take{2, 0}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.grasps()["taken"] == 0; }));
  const ordered_json third = found(3);
  ASSERT_FALSE(third["grasps"].empty());
  EXPECT_EQ(third["taken"], 0);
  const Scene own = saved(third["grasps"][0]);
  EXPECT_EQ(own.step_s, held_box().step_s);
  EXPECT_EQ(own.contact.friction, held_box().contact.friction);
}

// A recording has a column for each number of each finger, by its name: a grasp of other fingers would not fit in.
TEST(LiveGrasps, KeepTheFingersOfARecording) {
  SessionSettings settings = ShownSession::quiet();
  settings.record_folder = scratch();
  settings.record = settings.record_folder / "session.mcap";
  settings.asked = AskedScene{held_box(), "hand.yaml", "", 3};
  settings.asked->scene.hand.fingertips[1].finger = "pointer";
  ShownSession shown(held_box(), settings);
  ASSERT_EQ(shown.receive(Find{2}), "");
  const ordered_json found = ended(shown, 1);
  ASSERT_FALSE(found["grasps"].empty()) << found["refusal"];
  ASSERT_EQ(found["grasps"][0]["fingers"][1], "pointer");
  EXPECT_NE(shown.receive(Take{1, 1}), "");
  EXPECT_EQ(shown.receive(Take{1, 0}), "");
  // Without a recording it is taken, and one that begins then has its fingers.
  ASSERT_EQ(shown.receive(StopRecording{}), "");
  ASSERT_EQ(shown.receive(Take{1, 1}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.grasps()["taken"] == 1; }));
  ASSERT_EQ(shown.receive(Record{}), "");
  EXPECT_EQ(shown.receive(Take{1, 1}), "");
  EXPECT_NE(shown.receive(Take{1, 0}), "");
}

// A page that takes one grasp after the other gets no more than a scene a second, and the last one in the end.
TEST(LiveGrasps, TakesThatPourInAreHeededOnceASecond) {
  ShownSession shown(held_box());
  ASSERT_EQ(shown.receive(Find{2}), "");
  ASSERT_FALSE(ended(shown, 1)["grasps"].empty());
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(shown.receive(Take{1, (i + 1) % 2}), "");
    std::this_thread::sleep_for(milliseconds(15));
  }
  EXPECT_EQ(shown.receive(Take{1, 1}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.grasps()["taken"] == 1; }));
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_LE(shown.scenes(), 3 + static_cast<int>(took_s));
}

}  // namespace
}  // namespace thenar::window::live_grasps_test
