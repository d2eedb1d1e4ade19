// SPDX-License-Identifier: Apache-2.0
#include "app/window/live_settings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <variant>

#include "app/window/session.h"
#include "engine/models/build_model.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/scene_text.h"
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
  goes_on(Set{{{"level", 2.0}}});
  EXPECT_EQ(shown.scenes(), 2);
  EXPECT_EQ(shown.status()["settings"]["level"], 2);
  goes_on(Set{{{"kernel", "gaussian"}}});
  goes_on(Set{{{"contact_Hz", 1000.0}, {"control_Hz", 50.0}}});
  goes_on(Set{{{"delay_periods", 2.0}}});
  EXPECT_GT(shown.value("frame_age_s"), 0.03);  // two to three periods of 20 ms, and with none one at most
  goes_on(Set{{{"level", 0.0}, {"kernel", "boussinesq"}, {"delay_periods", 0.0}, {"contact_Hz", 500.0}}});
}

// While a grasp is taken its scene is made, and somebody may move a slider meanwhile.
TEST(LiveSettings, WhatIsSetMeanwhileComesAlong) {
  const LiveSettings before = live_settings(build_model(held_box()));
  LiveSettings begun = before;
  begun.values["internal_force_N"] = 1.25;  // By which the grasp was found,
  begun.values["contact_Hz"] = 1000.0;
  EXPECT_EQ(carried_over(before, before, begun), begun);
  ASSERT_EQ(before.value("kernel"), LiveValue("boussinesq"));
  const Set set{{{"friction", 0.875}, {"level", 2.0}, {"kernel", "gaussian"}}};
  LiveSettings now = before;
  LiveSettings expected = begun;  // which stays.
  for (LiveSettings* const changed : {&now, &expected}) {
    for (const auto& [name, value] : set.changes) changed->values[name] = value;
  }
  EXPECT_EQ(carried_over(before, now, begun), expected);
  // Rigid fingertips have no kernel.
  LiveSettings rigid = begun;
  rigid.values.erase("kernel");
  rigid.values.erase("level");
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
  EXPECT_EQ(key->live.name, name);
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
  for (const Scene& scene : {held_box(), scene_of("resting_box")}) {
    LiveSettings begun = live_settings(build_model(scene));
    begun.values["contact_Hz"] = 3000.0;  // So that each rate has its whole range, but where the two meet.
    begun.values["control_Hz"] = 20.0;
    std::set<std::string> listed, accepted;
    const ordered_json own = settings_json(begun);
    for (const auto& [name, value] : own.items()) {
      if (!value.is_null()) accepted.insert(name);
    }
    for (const ordered_json& one : settings_list(begun)) {
      EXPECT_TRUE(listed.insert(one.at("name").get<std::string>()).second) << one;
      expect_as_accepted(one, begun);
    }
    EXPECT_EQ(listed, accepted) << scene.name;
  }
}

// What is set is what the key of the scene says: the same run, as if its file had it.
TEST(LiveSettings, ChangeTheKeysThatTheyName) {
  Model model = build_model(held_box());
  const LiveSettings begun = live_settings(model);
  LiveSettings now = begun;
  const Set set{{{"friction", 0.625},
                 {"tolerance", 1e-5},
                 {"max_sweeps", 17.0},
                 {"contact_Hz", 2000.0},
                 {"control_Hz", 50.0},
                 {"delay_periods", 2.0},
                 {"internal_force_N", 1.5}}};
  ASSERT_EQ(change(set, now), "");
  apply(begun, now, model.scene);
  EXPECT_EQ(model.scene.contact.friction, 0.625);
  EXPECT_EQ(model.scene.contact.tolerance, 1e-5);
  EXPECT_EQ(model.scene.contact.max_sweeps, 17);
  EXPECT_EQ(model.scene.step_s, 1.0 / 2000.0);
  EXPECT_EQ(model.scene.control_period_s, 1.0 / 50.0);
  EXPECT_EQ(model.scene.control_delay_s, 2.0 / 50.0);
  EXPECT_EQ(model.scene.control->internal_force_N, 1.5);
}

/// A box that muscles hold with a stiffness that is chosen, above a table: it has all that can be changed.
Scene box_with_all() {
  return scene_of("box_stiff", {kCoarseBox,
                                "environment={friction: 0.3, bodies: [{shape: {plane: true},"
                                " position: [0 m, 0 m, -1 m]}]}"});
}

/// Another value than `now` that the list allows, and that leaves the control rate at most the contact rate.
ordered_json other_value(const ordered_json& one) {
  const ordered_json& now = one.at("default");
  if (one.at("type") == "choice") return one.at("choices")[now == one.at("choices")[0] ? 1 : 0];
  const double least = one.at("least"), most = one.at("most");
  if (one.at("type") == "numbers") return {0.25 * most, 0.5 * most, 0.75 * most};
  if (one.at("type") == "whole") return now == most ? least : now.get<double>() + 1.0;
  return 0.5 * (now.get<double>() + (one.at("name") == "control_Hz" ? least : most));
}

// A row with a live name is all that it takes: pages hear of it, and what they set is its key in the scene's text. Once
// it is set back the text is as it was: no other key was changed.
TEST(LiveSettings, AreTheRowsOfTheTableThatHaveALiveName) {
  const Scene scene = box_with_all();
  const LiveSettings begun = live_settings(build_model(scene));
  std::set<std::string> listed, live;
  for (const Key& key : scene_keys()) {
    EXPECT_TRUE(key.live.name.empty() || live.emplace(key.live.name).second) << key.path;
  }
  for (const ordered_json& one : settings_list(begun)) {
    const std::string name = one.at("name");
    SCOPED_TRACE(name);
    listed.insert(name);
    const ReadMessage read = read_message(ordered_json{{"type", "set"}, {name, other_value(one)}}.dump());
    ASSERT_TRUE(read.message) << read.refusal;
    LiveSettings wished = begun;
    ASSERT_EQ(change(std::get<Set>(*read.message), wished), "");
    EXPECT_NE(wished, begun);
    Scene changed = scene;
    apply(begun, wished, changed);
    EXPECT_NE(scene_text(changed, {}), scene_text(scene, {}));
    apply(wished, begun, changed);
    EXPECT_EQ(scene_text(changed, {}), scene_text(scene, {})) << "nothing else was changed";
  }
  EXPECT_EQ(listed, live);
}

// What is read from a file in other terms than the scene has it, and what the file does not say, stays to the last bit.
TEST(LiveSettings, LeaveAllElseAsItIs) {
  for (const char* name : {"box_grasp", "unknown_friction", "resting_box"}) {
    SCOPED_TRACE(name);
    Scene scene =
        scene_of(name, {kCoarseBox, "time.step=0.3 ms", "time.control_period=0.7 ms", "time.control_delay=0.5 ms"});
    scene.task.translate = Move{Eigen::Vector3d(1.0, 2.0, 3.0).normalized(), 1.7e-3};
    const LiveSettings begun = live_settings(build_model(scene));
    LiveSettings now = begun;
    ASSERT_EQ(change(Set{{{"friction", 0.625}}}, now), "");
    Scene changed = scene;
    apply(begun, now, changed);
    EXPECT_EQ(changed.contact.friction, 0.625);
    EXPECT_EQ(changed.step_s, scene.step_s);
    EXPECT_EQ(changed.control_period_s, scene.control_period_s);
    EXPECT_EQ(changed.control_delay_s, scene.control_delay_s);
    EXPECT_TRUE(!scene.control || changed.control->grasp_friction == scene.control->grasp_friction);
    EXPECT_TRUE(!scene.environment || changed.environment->place == scene.environment->place);
    EXPECT_EQ(changed.task.translate->axis, scene.task.translate->axis);
    EXPECT_EQ(changed.task.translate->amount, scene.task.translate->amount);
  }
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
  ASSERT_EQ(change(Set{{{"max_sweeps", 17.0}}}, now), "");
  apply(begun, now, model.scene);
  EXPECT_EQ(model.friction(2.0), 0.9);
  const LiveSettings before = now;
  ASSERT_EQ(change(Set{{{"friction", begun.number("friction")}}}, now), "");
  EXPECT_NE(now, before);
  apply(before, now, model.scene);
  EXPECT_EQ(model.friction(2.0), begun.number("friction"));
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
  EXPECT_EQ(shown.receive(Set{{{"level", 2.0}}}), "kernel and level need deformable fingertips");
  EXPECT_EQ(shown.receive(Set{{{"contact_Hz", 500.0}}}), "control_Hz must not be more than contact_Hz");  // 1000
  EXPECT_EQ(shown.receive(Set{{{"contact_Hz", 500.0}, {"control_Hz", 500.0}}}), "");
  EXPECT_EQ(shown.receive(Set{{{"internal_force_N", 3.0}}}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.status()["settings"]["internal_force_N"] == 3.0; }));
  EXPECT_TRUE(shown.status()["settings"]["level"].is_null());
  ShownSession box(held_box());
  // 320 leaves: 5 control points
  EXPECT_EQ(box.receive(Set{{{"level", 6.0}}}), "level leaves a fingertip fewer than 8 control points");
}

}  // namespace
}  // namespace thenar::window::live_settings_test
