// SPDX-License-Identifier: Apache-2.0
#include "app/window/session.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/loops/live_input.h"
#include "engine/loops/realtime.h"
#include "engine/recordings/recorded_run.h"
#include "tests/support/messages.h"
#include "tests/support/scratch.h"
#include "tests/window/shown_session.h"

namespace thenar::window::session_test {
namespace {

using namespace shown_session;

TEST(Session, ShowsAGraspThatRunsAndItsFigures) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(1.0));
  EXPECT_EQ(shown.scenes(), 1);
  EXPECT_EQ(shown.status()["running"], true);
  EXPECT_EQ(shown.status()["outcome"], "held") << shown.status()["reason"];
  EXPECT_TRUE(shown.status()["note"].is_null());
  EXPECT_EQ(shown.status()["settings"]["friction"], 0.8);
  EXPECT_EQ(shown.status()["settings"]["kernel"], "boussinesq");
  EXPECT_NEAR(shown.status()["settings"]["contact_Hz"].get<double>(), 500.0, 1e-9);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_GT(shown.value("normal_N", k), 0.1) << k;
  EXPECT_GT(shown.value("contacts"), 0.0);
  EXPECT_GT(shown.value("contact_Hz"), 0.0);
  EXPECT_LE(shown.value("realtime_factor"), 1.1);
  EXPECT_GT(shown.value("find_us"), 0.0);
  EXPECT_GT(shown.value("solve_us"), 0.0);
  EXPECT_TRUE(std::isnan(shown.value("pull_force_N")));
  // The accurate solve of a tick that stopped at a residual of 1e-7 differs little from it.
  ASSERT_TRUE(shown.comes([&] { return shown.value("reference_error") >= 0.0; }));
  EXPECT_LT(shown.value("reference_error"), 1e-2);
  EXPECT_LT(shown.value("reference_residual"), 1e-2);
}

// The thread that receives the loops' records is away for longer than there is room for them: 2 s.
TEST(Session, SaysWhenRecordsWereLost) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.3));
  EXPECT_EQ(shown.value("lost_records"), 0.0);
  EXPECT_EQ(shown.status()["outcome"], "held") << shown.status()["reason"];
  // On a busy machine there may be fewer ticks than that, and it is tried again.
  for (int tries = 0; tries < 10 && shown.value("lost_records") == 0.0; ++tries) {
    const int before = shown.states();
    shown.be_away(2800);
    ASSERT_TRUE(shown.comes([&] { return shown.states() > before + 1; }));
  }
  ASSERT_TRUE(shown.comes([&] { return shown.value("lost_records") > 0.0; }));
  EXPECT_TRUE(shown.comes([&] {
    return shown.status()["reason"].get<std::string>().find("were lost") != std::string::npos;
  })) << shown.status()["reason"];
  // They stay lost, also when the loops begin another run.
  const double lost = shown.value("lost_records");
  shown.receive(Pause{});
  ASSERT_TRUE(shown.comes([&] { return shown.status()["running"] == false; }));
  shown.receive(Resume{});
  ASSERT_TRUE(shown.passes(shown.value("time_s") + 0.1));
  EXPECT_GE(shown.value("lost_records"), lost);
}

TEST(Session, CostsNoPictureWhileNobodyLooks) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.1));
  shown.set_pages(0);
  ASSERT_TRUE(shown.looks(2));  // The loops know, though a picture or two may be on their way.
  const int before = shown.states();
  ASSERT_TRUE(shown.looks(100));  // 0.3 s, in which a page would have nine.
  EXPECT_LE(shown.states(), before + 2);
  shown.set_pages(1);
  EXPECT_TRUE(shown.comes([&] { return shown.states() > before + 2; }));
}

TEST(Session, PausesStepsResumesAndResets) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.2));
  EXPECT_NE(shown.receive(Step{}), "");
  EXPECT_EQ(shown.receive(Pause{}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.status()["paused"] == true && shown.status()["running"] == false; }));
  ASSERT_TRUE(shown.rests());
  const double paused_s = shown.value("time_s");
  ASSERT_TRUE(shown.rests());
  EXPECT_EQ(shown.value("time_s"), paused_s);

  // Three steps of a control period.
  for (int i = 0; i < 3; ++i) EXPECT_EQ(shown.receive(Step{}), "");
  ASSERT_TRUE(shown.rests());
  EXPECT_NEAR(shown.value("time_s"), paused_s + 0.03, 1e-9);

  EXPECT_EQ(shown.receive(Resume{}), "");
  ASSERT_TRUE(shown.passes(paused_s + 0.1));
  EXPECT_EQ(shown.receive(Reset{}), "");
  EXPECT_TRUE(shown.comes([&] { return shown.value("time_s") < paused_s; }));
  EXPECT_TRUE(shown.passes(paused_s));
}

TEST(Session, ShowsTheStartToAPageThatComesInAPause) {
  ShownSession shown(held_box());
  shown.set_pages(0);
  shown.receive(Pause{});
  ASSERT_TRUE(shown.comes([&] { return shown.status().value("paused", false); }));
  shown.receive(Reset{});
  ASSERT_TRUE(shown.rests());
  shown.set_pages(1);
  ASSERT_TRUE(shown.comes([&] { return shown.value("time_s") == 0.0; }));
}

TEST(Session, RunsSlowly) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.1));
  shown.receive(Pause{});
  ASSERT_TRUE(shown.rests());
  const double from_s = shown.value("time_s");
  shown.receive(Speed{0.01});  // a tick in 0.2 s
  const auto begin = std::chrono::steady_clock::now();
  shown.receive(Resume{});
  ASSERT_TRUE(shown.passes(from_s + 0.005));
  // However busy the machine is it is no faster than that, but for a tick at each end.
  const double simulated_s = shown.value("time_s") - from_s;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(simulated_s, 0.01 * took.count() + 0.004);
  shown.receive(Pause{});
  ASSERT_TRUE(shown.comes([&] { return shown.status()["running"] == false; }));
}

/// Pulls the box at its centre to a handle until it rests, which it does when it has stayed within 10 um for 0.3 s. If
/// this thread was kept from repeating the pull in time it has let go: the box moves, and is waited for again.
ShownSession::Pulled pulled_to_rest(ShownSession& shown, const Eigen::Vector3d& handle) {
  ShownSession::Pulled stood = shown.pulled(), now = stood;
  EXPECT_TRUE(shown.comes([&] {
    EXPECT_EQ(shown.receive(Pull{Eigen::Vector3d::Zero(), handle, std::nullopt}), "");
    now = shown.pulled();
    if (std::isnan(now.force_N[0]) || (now.object - stood.object).norm() > 1e-5) stood = now;
    return now.time_s > stood.time_s + 0.3;
  }));
  return now;
}

// Without its integral the controller holds against a force like a spring: 300 N/m. So the box goes F / p, with F of
// the pull's own spring, until someone lets go.
TEST(Session, APullMovesTheBoxByForceOverStiffnessAndLetsGo) {
  ShownSession shown(held_box({"control.position.i=0 N/(m*s)", "control.rotation.i=0 N*m/(rad*s)"}));
  ASSERT_TRUE(shown.passes(1.0));
  const Eigen::Vector3d rest = shown.vector("object");
  const Eigen::Vector3d way(0.0, 0.0, 0.008);
  const ShownSession::Pulled pulled = pulled_to_rest(shown, rest + way);
  const Eigen::Vector3d &force = pulled.force_N, moved = pulled.object - rest;
  EXPECT_NEAR(force.norm(), thenar::kPullStiffness_N_per_m * (way - moved).norm(), 0.02 * force.norm());
  EXPECT_LT((moved - force / 300.0).norm(), 0.05 * force.norm() / 300.0) << moved.transpose();
  // The dead man: nobody repeats it.
  ASSERT_TRUE(shown.comes([&] { return std::isnan(shown.value("pull_force_N")); }));
  EXPECT_GT(shown.value("latency_us"), 0.0);
  // Other input does not bring it back.
  shown.receive(Poke{Eigen::Vector3d(0.01, 0.0, 0.0), std::nullopt});
  ASSERT_TRUE(shown.passes(0.1));
  EXPECT_TRUE(std::isnan(shown.value("pull_force_N")));
}

TEST(Session, MovesTheTargetAndTheBoxFollows) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.5));
  const Eigen::Vector3d shift(-0.02, 0.0, 0.0);
  shown.receive(Target{shift, Eigen::Vector3d::Zero(), std::nullopt});
  ASSERT_TRUE(shown.comes([&] { return (shown.vector("path_target_m") - shift).norm() < 1e-9; }));
  EXPECT_TRUE(shown.comes([&] { return (shown.vector("position_m") - shift).norm() < 0.5e-3; }));
  EXPECT_EQ(shown.status()["outcome"], "held") << shown.status()["reason"];
  shown.receive(Reset{});
  ASSERT_TRUE(shown.comes([&] { return shown.vector("path_target_m").isZero(0.0) && shown.value("time_s") > 0.3; }));
}

// At rest in the task's first grip 0.2 would just do: the fingers press with the cones of 0.55 in mind. A box that is
// moved against its viscosity needs more.
TEST(Session, LosesTheBoxWithoutFrictionAndFindsItAfterAReset) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.5));
  EXPECT_EQ(shown.receive(Set{{{"friction", 0.2}}}), "");
  shown.receive(Target{{0.0, 0.02, 0.0}, Eigen::Vector3d::Zero(), std::nullopt});
  // Once the fingers have slid away there may be no grasp forces, either: the graver word.
  ASSERT_TRUE(shown.comes([&] {
    const std::string outcome = shown.status()["outcome"];
    return outcome == "lost" || outcome == "solver failed";
  }));
  EXPECT_EQ(shown.status()["running"], true);
  EXPECT_EQ(shown.receive(Set{{{"friction", 0.8}}}), "");
  EXPECT_EQ(shown.receive(Reset{}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.status()["outcome"] == "held"; }));
  ASSERT_TRUE(shown.passes(1.0));
  EXPECT_EQ(shown.status()["outcome"], "held") << shown.status()["reason"];
}

// Wishes that pour in, refused or not, do not keep the grasp from running.
TEST(Session, RunsOnUnderAFloodOfWishes) {
  ShownSession shown(held_box());
  ASSERT_TRUE(shown.passes(0.1));
  const double end_s = shown.value("time_s") + 0.5;
  for (int i = 0; shown.value("time_s") < end_s && i < 100'000; ++i) {
    Set set{{{"friction", 0.7 + 0.001 * (i % 100)}}};
    EXPECT_EQ(shown.receive(set), "");
    set.changes["control_Hz"] = 1999.0;
    EXPECT_NE(shown.receive(set), "");
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_GE(shown.value("time_s"), end_s);
  EXPECT_EQ(shown.status()["outcome"], "held") << shown.status()["reason"];
}

// The recording has its own states, also of other fingertips and while nobody looks: fifty of each simulated second.
TEST(Session, RecordsWhileItRuns) {
  SessionSettings settings = ShownSession::quiet();
  settings.record = thenar::scratch() / "session.mcap";
  settings.recording.contacts = true;
  double first_s = 0.0;
  {
    ShownSession shown(held_box(), settings);
    ASSERT_TRUE(shown.passes(0.3));
    shown.receive(Set{{{"level", 2.0}}});
    ASSERT_TRUE(shown.passes(shown.value("time_s") + 0.3));
    first_s = shown.value("time_s");
    shown.set_pages(0);
    ASSERT_TRUE(shown.looks(100));
    shown.set_pages(1);
    ASSERT_TRUE(shown.passes(first_s));
    shown.end();
  }
  const thenar::RecordedRun run = thenar::read_recording(settings.record);
  EXPECT_TRUE(run.reading.whole);
  const Eigen::VectorXd times_s = run.times_s();
  ASSERT_GE(times_s.size(), 30);
  for (Eigen::Index i = 1; i < times_s.size(); ++i) {
    // Where the loops rest there is one more.
    EXPECT_LE(times_s[i] - times_s[i - 1], 1.0 / thenar::kRecordingRate_Hz + 1e-9);
    EXPECT_GE(times_s[i], times_s[i - 1]);
  }
  EXPECT_GT(times_s[times_s.size() - 1], first_s);
  // Every tick's contacts, one block after the other.
  ASSERT_FALSE(run.contact_blocks.empty());
  double end_s = run.contact_blocks.front().time_s;
  for (const thenar::ContactBlock& block : run.contact_blocks) {
    EXPECT_NEAR(block.time_s, end_s, 1e-9);
    end_s = block.time_s + block.ticks * block.step_s;
  }
  EXPECT_GT(end_s, first_s);
  int scenes = 0, statuses = 0;
  for (const thenar::KeptMessage& message : thenar::messages_in(settings.record).messages) {
    scenes += message.topic == "/scene";
    statuses += message.topic == "/status";
  }
  EXPECT_EQ(scenes, 2);
  EXPECT_GE(statuses, 2);
}

// Each other level is another scene in the recording, of 1 MB. A page that sets levels without end gets one a second,
// and the last one in the end.
TEST(Session, LevelsThatPourInDoNotFillTheRecording) {
  SessionSettings settings = ShownSession::quiet();
  settings.record = thenar::scratch() / "session.mcap";
  ShownSession shown(held_box(), settings);
  ASSERT_TRUE(shown.passes(0.1));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 200 || (shown.scenes() < 2 && i < 6000); ++i) {
    EXPECT_EQ(shown.receive(Set{{{"level", 1.0 + i % 2}}}), "");
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(shown.receive(Set{{{"level", 3.0}}}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.status()["settings"]["level"] == 3; }));
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  shown.end();
  int scenes = 0;
  for (const auto& message : thenar::messages_in(settings.record).messages) scenes += message.topic == "/scene";
  EXPECT_GE(scenes, 3) << "the first, one of those between, the last";
  EXPECT_LE(scenes, 3 + static_cast<int>(took_s));
}

TEST(Session, WaitsWhereNoForcesHoldTheStart) {
  ShownSession shown(held_box({"control.grasp.friction=0"}));
  ASSERT_TRUE(shown.comes([&] { return shown.status().contains("note") && shown.status()["note"].is_string(); }));
  EXPECT_EQ(shown.status()["running"], false);
  EXPECT_EQ(shown.value("time_s"), 0.0);
}

}  // namespace
}  // namespace thenar::window::session_test
