// SPDX-License-Identifier: Apache-2.0
// What a run tells of what is around the object.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/models/build_model.h"
#include "engine/recordings/recording_scene.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "tests/results/watched_runs.h"
#include "tests/support/scenes.h"

namespace thenar::environment_results_test {
namespace {

using namespace watched_runs;
using Eigen::Vector3d;
using nlohmann::ordered_json;

constexpr double kWeight_N = 0.1 * 9.80665;

struct AroundIt {
  explicit AroundIt(const std::vector<std::string>& overrides)
      : model(build_model(scene_of("resting_box", overrides))), state(model), recording(run_scene(model, state)) {
    told = summarize(model, recording).at("environment");
  }

  Model model;
  State state;
  Recording recording;
  ordered_json told;
};

// The table carries the weight, and on a slope of 10 degrees cos(10 deg) of it is its normal force. The box lies as it
// is placed, so the first tick and the last one carry it; 0.5 %: c f of the placing that its position does not have.
TEST(Environment, TellsOfTheWeightThatRests) {
  const AroundIt run({"time.duration=0.5 s"});
  EXPECT_EQ(run.told.at("ticks_with_contact"), 500);
  EXPECT_NEAR(run.told.at("first_touch_s"), 1e-3, 1e-12);
  EXPECT_NEAR(run.told.at("last_touch_s"), 0.5, 1e-12);
  EXPECT_TRUE(std::isnan(run.told.at("lift_off_s").get<double>()));
  EXPECT_NEAR(run.told.at("max_normal_N"), kWeight_N * std::cos(10.0 / kDegrees), 5e-3 * kWeight_N);
  EXPECT_NEAR(run.told.at("min_vertical_N"), kWeight_N, 5e-3 * kWeight_N);
  EXPECT_NEAR(run.told.at("max_vertical_N"), kWeight_N, 1e-6);
  // Four corners share the load, the lower ones more: one that bore all would give way by c f_n.
  EXPECT_GT(run.told.at("max_penetration_um"), 0.1 * kWeight_N / 4.0 * std::cos(10.0 / kDegrees));
  EXPECT_LT(run.told.at("max_penetration_um"), 0.1 * kWeight_N);
  EXPECT_EQ(run.recording.verdict.outcome, Outcome::kResting);
  EXPECT_EQ(run.recording.verdict.reason,
            "from 0.100 s on the object rests on its environment, and no finger holds it");
  EXPECT_FALSE(fails(run.model.scene, run.recording.verdict.outcome)) << "nothing was asked of the hand";
}

// A table that falls faster than the box, whose damping lets it sink at 98 mm/s: it lifts off, and is lost 50 ms later.
TEST(Environment, TellsWhenTheObjectLiftsOff) {
  const AroundIt run(
      {"time.duration=0.5 s",
       "environment={friction: 0.3, bodies: [{name: table, shape: {plane: true}, position: [0 mm, 0 mm, -20 "
       "mm], move: [{by: [0 mm, 0 mm, -200 mm], from: 0.2 s, over: 0.2 s}]}]}",
       "object.position=[305 mm, 0 mm, 10 mm]", "object.rotation=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"});
  const double off_s = run.told.at("lift_off_s");
  EXPECT_EQ(run.told.at("last_touch_s"), off_s);
  EXPECT_GT(off_s, 0.2);
  EXPECT_LT(off_s, 0.23) << "minimum jerk passes 98 mm/s after 14 ms";
  ASSERT_TRUE(run.recording.verdict.lost_s);
  EXPECT_NEAR(*run.recording.verdict.lost_s, off_s + kUnloaded_s, 2.5e-3);
  EXPECT_EQ(run.recording.verdict.outcome, Outcome::kLost);
}

// Nor has a scene without gravity anything vertical, nor one that touches nothing a first touch.
TEST(Environment, TellsNothingWhereThereIsNothing) {
  const AroundIt run({"time.duration=20 ms", "gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]",
                      "environment.bodies=[{shape: {sphere: 5 mm}, position: [0 mm, 0 mm, 500 mm]}]"});
  EXPECT_EQ(run.told.at("ticks_with_contact"), 0);
  EXPECT_EQ(run.told.at("max_normal_N"), 0.0);
  for (const char* key : {"first_touch_s", "last_touch_s", "lift_off_s", "min_vertical_N", "max_vertical_N"}) {
    EXPECT_TRUE(std::isnan(run.told.at(key).get<double>())) << key;
  }
}

// Its columns are added together, and nothing else changes.
TEST(Environment, AddsItsColumns) {
  const AroundIt run({"time.duration=5 ms"});
  Scene scene = run.model.scene;
  scene.environment.reset();
  const Model without = build_model(scene);
  State state(without);
  const std::vector<std::string> fewer = signal_table(without, run_scene(without, state)).names;
  const SignalTable table = signal_table(run.model, run.recording);
  const auto its = static_cast<std::ptrdiff_t>(10 + 3 * run.model.scene.environment->bodies.size());
  ASSERT_EQ(std::ssize(table.names), std::ssize(fewer) + its);
  std::vector<std::string> others = table.names;
  const auto is_its = [](const std::string& name) { return name.find("environment_") != name.npos; };
  const auto first = std::ranges::find_if(others, is_its);
  EXPECT_TRUE(std::all_of(first, first + its, is_its));
  others.erase(first, first + its);
  EXPECT_EQ(others, fewer);
  const auto last = [&](const std::string& name) {
    const auto at = std::ranges::find(table.names, "environment_" + name) - table.names.begin();
    return table.numbers(4, at);
  };
  const EnvironmentReport& report = run.recording.ticks.back().contact.environment;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    EXPECT_EQ(last("force_" + axis + "_N"), report.wrench[i]);
    EXPECT_EQ(last("moment_" + axis + "_N_mm"), 1e3 * report.wrench[3 + i]);
  }
  EXPECT_EQ(last("normal_N"), report.normal_N);
  EXPECT_EQ(last("contacts"), report.contacts);
  EXPECT_EQ(last("active"), report.active);
  EXPECT_EQ(last("penetration_um"), 1e6 * report.penetration_m);
  EXPECT_EQ(report.active, 4);
  const ordered_json summary = summarize(without, Recording());
  EXPECT_FALSE(summary.contains("environment"));
}

// Viewers that do not know Thenar see the bodies: each in a frame of its own, where it is, and its force.
TEST(Environment, OthersSeeItsBodies) {
  const AroundIt run({"time.duration=5 ms",
                      "environment.bodies=[{name: slope, shape: {plane: true}, position: [300 mm, 0 mm, 0 mm],"
                      " rotation: [[0.984807753012208, 0, 0.173648177666930], [0, 1, 0],"
                      " [-0.173648177666930, 0, 0.984807753012208]]},"
                      "{shape: {box: [1 mm, 2 mm, 3 mm]}, position: [0 mm, 0 mm, 200 mm]},"
                      "{shape: {sphere: 3 mm}, position: [0 mm, 0 mm, 300 mm]},"
                      "{shape: {cylinder: {radius: 3 mm, length: 4 mm}}, position: [0 mm, 0 mm, 400 mm]}]"});
  const ordered_json entities = object_entities(run.model, 0.0).at("entities");
  ASSERT_EQ(entities.size(), 5U);
  const auto farthest_m = [](const ordered_json& entity) {
    double most_m = 0.0;
    for (const ordered_json& p : entity.at("triangles").at(0).at("points"))
      most_m = std::max(most_m, std::hypot(p.at("x").get<double>(), p.at("y").get<double>(), p.at("z").get<double>()));
    return most_m;
  };
  EXPECT_EQ(entities.at(1).at("frame_id"), "around/slope");
  EXPECT_NEAR(farthest_m(entities.at(2)), 0.5e-3 * std::sqrt(14.0), 1e-7);
  EXPECT_NEAR(farthest_m(entities.at(3)), 3e-3, 1e-7);
  EXPECT_NEAR(farthest_m(entities.at(4)), 1e-3 * std::hypot(3.0, 2.0), 1e-7);
  GraspRun loops(run.model);
  loops.tick();
  Picture picture(run.model);
  take_picture(loops.state, loops.memory, loops.work, picture);
  const ordered_json frames =
      frame_transforms(run.model, picture, Eigen::Isometry3d::Identity(), 1e-3).at("transforms");
  EXPECT_EQ(frames.back().at("child_frame_id"), "around/4");
  EXPECT_NEAR(frames.back().at("translation").at("z").get<double>(), 0.4, 1e-12);
  const ordered_json bodies = force_entities(run.model, picture, 1e-3).at("entities").back();
  EXPECT_EQ(bodies.at("id"), "bodies");
  EXPECT_EQ(bodies.at("arrows").size(), 1U) << "the others bear nothing";
}

/// Fingers open after 0.2 s of 0.5 s, and the environment carries the object from then on, until `until_s`.
Watched put_down(double until_s) {
  Watched run = steady_run([](int i) { return i < 200 ? 2.0 : 0.0; });
  for (TickRecord& tick : run.ticks) {
    if (tick.time_s > 0.2 && tick.time_s < until_s) tick.contact.environment.normal_N = 1.0;
  }
  return run;
}

TEST(Verdict, WhatTheEnvironmentCarriesIsNotLost) {
  EXPECT_EQ(put_down(0.0).outcome(), Outcome::kLost);
  const std::string rests = in_words(put_down(1.0).verdict());
  EXPECT_TRUE(rests.starts_with("resting: from 0.201 s on the object rests on its environment, and no finger holds it"))
      << rests;
  // Less than 50 ms without any load is no loss, and what the environment has carried is none.
  EXPECT_EQ(put_down(0.46).outcome(), Outcome::kResting);
  const Verdict falls = put_down(0.4).verdict();
  EXPECT_EQ(falls.outcome, Outcome::kLost);
  EXPECT_NEAR(falls.lost_s.value_or(0.0), 0.4 + kUnloaded_s, 1.5e-3);
  // Nor is what fingers hold, and something else touches.
  Watched held = steady_run();
  for (TickRecord& tick : held.ticks) tick.contact.environment.normal_N = 1.0;
  EXPECT_EQ(held.outcome(), Outcome::kHeld);
}

TEST(Verdict, NamesTheFingerThatIsLeft) {
  Watched run = put_down(1.0);
  for (TickRecord& tick : run.ticks) tick.force[0].normal_N = 1.0;
  EXPECT_NE(run.verdict().reason.find("and one finger alone holds it"), std::string::npos) << run.verdict().reason;
}

// A solve without an answer counts where only the environment touches, too: above 1 % of such ticks no run is right.
TEST(Verdict, CountsSolvesOfTheEnvironmentAlone) {
  for (const auto& [unsolved, outcome] : {std::pair{2, Outcome::kResting}, {8, Outcome::kSolverFailed}}) {
    Watched run = put_down(1.0);
    for (int i = 0; i < 300; ++i) {
      TickReport& contact = run.ticks[200 + static_cast<std::size_t>(i)].contact;
      contact.environment.contacts = 4;
      contact.solve.residual = i < unsolved ? 0.1 : 1e-9;
    }
    EXPECT_EQ(run.outcome(), outcome) << unsolved;
  }
}

}  // namespace
}  // namespace thenar::environment_results_test
