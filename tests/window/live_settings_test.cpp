#include "app/window/live_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <variant>

#include "app/window/session.h"
#include "engine/scenes/build_model.h"
#include "engine/scenes/key_table.h"
#include "tests/support/scenes.h"
#include "tests/window/shown_session.h"

namespace thenar::window::live_settings_test {
namespace {

using namespace shown_session;
using nlohmann::ordered_json;

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

/// What reading and making the change come to: the settings as a status has them, or nothing if it is refused.
std::optional<ordered_json> changed(const std::string& name, const ordered_json& value, LiveSettings settings) {
  const ReadMessage read = read_message(ordered_json{{"type", "set"}, {name, value}}.dump());
  if (!read.message || !change(std::get<Set>(*read.message), settings).empty()) return std::nullopt;
  return settings_json(settings);
}

/// A setting of the list is what the server takes, in its range, and what its key says.
void expect_as_accepted(const ordered_json& one, const LiveSettings& begun) {
  const std::string name = one.at("name");
  SCOPED_TRACE(name);
  const Key* const key = find_key(scene_keys(), one.at("key").get<std::string>());
  ASSERT_NE(key, nullptr);
  EXPECT_EQ(one.at("what"), key->sentence);
  EXPECT_EQ(find_live_key(scene_keys(), name), key);
  EXPECT_EQ(one.at("default"), settings_json(begun).at(name));
  EXPECT_FALSE(changed(name, "none of these", begun));
  if (one.at("type") == "choice") {
    ASSERT_GT(one.at("choices").size(), 1U);
    for (const ordered_json& word : one.at("choices")) {
      const std::optional<ordered_json> now = changed(name, word, begun);
      ASSERT_TRUE(now) << word;
      EXPECT_EQ(now->at(name), word);
    }
    return;
  }
  const double least = one.at("least"), most = name == "control_Hz" ? 2000.0 : one.at("most").get<double>();
  for (const double value : {least, most}) {
    const std::optional<ordered_json> now = changed(name, value, begun);
    ASSERT_TRUE(now) << value;
    EXPECT_EQ(now->at(name), value);
  }
  const double beyond = one.at("type") == "whole" ? 1.0 : 1e-6 * most;
  EXPECT_FALSE(changed(name, least - beyond, begun));
  EXPECT_FALSE(changed(name, most + beyond, begun));
  const bool takes_parts = changed(name, least + std::min(0.5, 0.5 * (most - least)), begun).has_value();
  EXPECT_NE(one.at("type") == "whole", takes_parts);
}

// The page makes its controls of the list: it must be all that the server takes, in the ranges that it takes.
TEST(LiveSettings, TheTableOfKeysIsWhatTheServerAccepts) {
  std::set<std::string> all;
  for (const Scene& scene : {held_box(), scene_of("resting_box")}) {
    LiveSettings begun = live_settings(build_model(scene));
    begun.contact_Hz = 3000.0;  // So that each rate has its whole range, but where the two meet.
    begun.control_Hz = 20.0;
    std::set<std::string> listed, accepted;
    const ordered_json own = settings_json(begun);
    for (const auto& [name, value] : own.items()) {
      if (!value.is_null()) accepted.insert(name);
    }
    for (const ordered_json& one : settings_list(begun)) {
      listed.insert(one.at("name").get<std::string>());
      expect_as_accepted(one, begun);
    }
    EXPECT_EQ(listed, accepted) << scene.name;
    all.merge(listed);
  }
  for (const Key& key : scene_keys()) {
    // Of several numbers: tests/window/live_stiffness_test.cpp.
    if (key.items != 1) continue;
    EXPECT_TRUE(key.live.name.empty() || all.contains(std::string(key.live.name))) << key.path;
  }
}

// What is set is what the key of the scene says: the same run, as if its file had it.
TEST(LiveSettings, ChangeTheKeysThatTheyName) {
  Model model = build_model(held_box());
  const LiveSettings begun = live_settings(model);
  LiveSettings now = begun;
  now.friction = 0.625;
  now.tolerance = 1e-5;
  now.max_sweeps = 17;
  now.contact_Hz = 2000.0;
  now.control_Hz = 100.0;
  now.delay_periods = 2;
  now.internal_force_N = 1.5;
  apply(begun, now, model.scene);
  EXPECT_EQ(model.scene.contact.friction, 0.625);
  EXPECT_EQ(model.scene.contact.tolerance, 1e-5);
  EXPECT_EQ(model.scene.contact.max_sweeps, 17);
  EXPECT_EQ(model.scene.step_s, 1.0 / 2000.0);
  EXPECT_EQ(model.scene.control_period_s, 1.0 / 100.0);
  EXPECT_EQ(model.scene.control_delay_s, 2.0 / 100.0);
  EXPECT_EQ(model.scene.control->internal_force_N, 1.5);
}

/// A box whose task changes friction at two times of its own.
Scene box_with_steps() {
  Scene scene = held_box();
  scene.task.friction = {{0.3, 0.7}, {1.2, 0.9}};
  return scene;
}

// Whoever sets friction sets all of it, also to the value that the scene had: no step of the task comes after.
TEST(LiveSettings, FrictionThatIsSetTakesThePlaceOfTheTasksSteps) {
  Model model = build_model(box_with_steps());
  const LiveSettings begun = live_settings(model);
  LiveSettings now = begun;
  Set sweeps, same;
  sweeps.max_sweeps = 17;
  ASSERT_EQ(change(sweeps, now), "");
  apply(begun, now, model.scene);
  EXPECT_EQ(model.friction(2.0), 0.9);
  same.friction = begun.friction;
  const LiveSettings before = now;
  ASSERT_EQ(change(same, now), "");
  EXPECT_NE(now, before);
  apply(before, now, model.scene);
  EXPECT_EQ(model.friction(2.0), begun.friction);
  EXPECT_FALSE(carried_over(before, now, begun).friction_steps);
}

TEST(Session, KeepsFrictionThatSomebodySets) {
  ShownSession shown(box_with_steps());
  const double own = box_with_steps().contact.friction;
  ASSERT_TRUE(shown.comes([&] { return shown.value("friction") == 0.7; }));
  const auto says = [&](double friction) {
    const ReadMessage read = read_message(ordered_json{{"type", "set"}, {"friction", friction}}.dump());
    EXPECT_EQ(shown.receive(*read.message), "");
    return shown.comes([&] { return shown.value("friction") == friction; });
  };
  ASSERT_TRUE(says(own));
  ASSERT_TRUE(shown.passes(1.3));
  EXPECT_EQ(shown.value("friction"), own);
  ASSERT_TRUE(says(0.15));  // Wet.
  EXPECT_EQ(shown.status()["settings"]["friction"], 0.15);
}

TEST(LiveSettings, AreListedWhereTheSceneHasThem) {
  const auto names = [](const Scene& scene) {
    std::set<std::string> found;
    for (const ordered_json& one : settings_list(live_settings(build_model(scene)))) found.insert(one.at("name"));
    return found;
  };
  const std::set<std::string> rigid = names(scene_of("minimal"));
  EXPECT_TRUE(rigid.contains("friction"));
  EXPECT_FALSE(rigid.contains("kernel") || rigid.contains("level"));
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
