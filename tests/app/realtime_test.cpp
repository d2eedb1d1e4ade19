// SPDX-License-Identifier: Apache-2.0
// The two loops as a user meets them: what `run --realtime` and `run --lockstep` print, write and refuse.
// Counts and forms are asserted, never times.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/app/short_run.h"
#include "tests/support/program.h"

namespace thenar::realtime_test {
namespace {

using namespace short_runs;

namespace fs = std::filesystem;
using nlohmann::json;

void expect_latencies(const json& times) {
  for (const char* key : {"p50_us", "p99_us", "p999_us", "max_us"}) EXPECT_TRUE(times.at(key).is_number()) << key;
  EXPECT_LE(times.at("p50_us"), times.at("p99_us"));
  EXPECT_LE(times.at("p99_us"), times.at("p999_us"));
  EXPECT_LE(times.at("p999_us"), times.at("max_us"));
}

TEST(RunRealtime, WritesEveryNumberOfItsLoops) {
  const fs::path out = scratch();
  const ProgramResult run = short_run("--out " + out.string() + " --trace " + (out / "trace.json").string());
  ASSERT_EQ(run.code, 0) << run.text;
  const auto summary = json::parse(read(out / "summary.json"));
  for (const char* key : {"policy", "priority", "core", "locked", "spin_us", "timer_slack_ns", "remark"}) {
    EXPECT_TRUE(summary.at("scheduling").contains(key)) << key;
  }
  const json& contact = summary.at("loops").at("contact");
  expect_latencies(contact.at("jitter"));
  expect_latencies(contact.at("compute"));
  EXPECT_EQ(contact.at("ticks").get<int>() + contact.at("slipped").get<int>(), 400) << "every tick is done or slipped";
  EXPECT_GE(contact.at("overruns"), 0);
  EXPECT_GT(contact.at("rate_hz"), 0.0);
  EXPECT_EQ(contact.at("lost_samples"), 0);
  EXPECT_EQ(summary.at("loops").at("control").at("lost_samples"), 0);
  const json& control = summary.at("loops").at("control");
  expect_latencies(control.at("total"));
  expect_latencies(control.at("jitter"));
  for (const char* stage : {"find", "factors", "grasp_lcp"}) expect_latencies(control.at("stages").at(stage));
  EXPECT_TRUE(control.at("stages").at("muscle_lcp").at("p50_us").is_null()) << "the scene has no muscles";

  for (const json* exchange : {&summary.at("exchange"), &summary.at("snapshots")}) {
    EXPECT_GT(exchange->at("published"), 0);
    EXPECT_EQ(exchange->at("torn"), 0);
    EXPECT_EQ(exchange->at("unaccounted"), 0);
  }
  for (const char* key : {"publish_p50_ns", "publish_p99_ns", "acquire_p50_ns", "acquire_p99_ns"}) {
    EXPECT_GE(summary.at("exchange").at(key), 0.0) << key;
  }
  EXPECT_EQ(summary.at("handover").at("count"), summary.at("exchange").at("consumed")) << "a new frame is one taken";
  for (const char* key : {"p50_ms", "p99_ms", "max_ms"}) EXPECT_GE(summary.at("frame_age").at(key), 0.0) << key;
  EXPECT_TRUE(summary.at("handover").contains("kick_over_tick_p99"));
  EXPECT_TRUE(summary.at("ledger").contains("injected_over_dissipated"));
  EXPECT_LE(summary.at("contacts").at("residual_p99"), 1e-3) << "the tolerance in real time";
  EXPECT_EQ(contact.at("residual_above_1e-2"), 0);
  EXPECT_EQ(contact.at("not_finite"), 0);
  EXPECT_GE(contact.at("sweeps_p99"), contact.at("sweeps_p50"));
  for (const char* key : {"grasp_unsolved", "muscle_unsolved", "stiffness_unanswered"})
    EXPECT_EQ(control.at(key), 0) << key;
  EXPECT_EQ(summary.at("grasp").at("held"), true);
  EXPECT_GE(summary.at("object").at("max_error_mm"), summary.at("object").at("rms_error_mm"));
  EXPECT_TRUE(summary.at("floor").is_null());
  EXPECT_LT(summary.at("contacts").at("max_penetration_um"), 100.0);
  EXPECT_TRUE(summary.at("warnings").empty()) << summary.at("warnings");
  for (const char* key : {"contacts", "hold", "wall_s", "simulated_s", "build", "settings"}) {
    EXPECT_TRUE(summary.contains(key)) << key;
  }
  for (const char* figure : {"jitter.svg", "handover.svg", "timeline.svg"}) {
    EXPECT_NE(read(out / figure).find("</svg>"), std::string::npos) << figure;
  }
  EXPECT_GT(json::parse(read(out / "trace.json")).at("traceEvents").size(), 400);
}

TEST(RunRealtime, TakesTheLastWordOnASetting) {
  const fs::path out = scratch();
  const auto settings = [&](const std::string& arguments) {
    const ProgramResult run = short_run(arguments + " --no-figures --out " + out.string());
    EXPECT_EQ(run.code, 0) << run.text;
    return json::parse(read(out / "summary.json")).at("settings");
  };
  EXPECT_EQ(settings("").at("tolerance"), 1e-7) << "what real time can afford";
  EXPECT_EQ(settings("").at("max_sweeps"), 60);
  EXPECT_EQ(settings("--set contact.tolerance=1e-5").at("tolerance"), 1e-5) << "a default gives way";
  EXPECT_EQ(settings("--tolerance 1e-4 --set contact.tolerance=1e-5").at("tolerance"), 1e-4) << "a flag does not";
}

// 100 kHz is more than any tick keeps: that is warned of, in a sentence, unless the run is to be quiet.
TEST(RunRealtime, WarnsOfOverrunsUnlessQuiet) {
  const std::string command =
      "run " + config("box_grasp.yaml") + " --realtime --contact-rate 100kHz --time 0.1 --no-realtime";
  const ProgramResult run = thenar_program(command);
  EXPECT_NE(run.text.find("overran"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("in the last second"), std::string::npos) << run.text;
  EXPECT_EQ(thenar_program(command + " --quiet").text.find("overran"), std::string::npos);
}

TEST(RunRealtime, ReportsALostObjectAtTheEnd) {
  const ProgramResult run =
      thenar_program("run " + config("box_grasp.yaml") +
                     " --realtime --contact-rate 1kHz --time 0.9 --no-realtime --set contact.friction=0.1");
  EXPECT_EQ(run.code, 7) << run.text;
  EXPECT_NE(run.text.find("failed: lost: at 0."), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("contact: start jitter"), std::string::npos) << "the times are printed all the same";
}

TEST(RunRealtime, WritesWhatARunInOneLoopWritesAndItsLoops) {
  const fs::path out = scratch();
  const ProgramResult run =
      thenar_program("run " + config("box_grasp.yaml") +
                     " --realtime --no-realtime --contact-rate 1kHz --control-rate 200Hz --time 0.4 "
                     "--out " +
                     out.string());
  ASSERT_EQ(run.code, 0) << run.text;
  const auto summary = json::parse(read(out / "summary.json"));
  EXPECT_EQ(summary.at("grasp").at("held"), true);
  EXPECT_EQ(summary.at("lcp").at("grasp_infeasible"), 0);
  expect_latencies(summary.at("loops").at("contact").at("jitter"));
  EXPECT_TRUE(summary.contains("scheduling"));
  const std::string signals = read(out / "signals.csv");
  EXPECT_EQ(std::count(signals.begin(), signals.end(), '\n') - 1, summary.at("loops").at("contact").at("ticks"));
  for (const char* figure : {"path.svg", "forces.svg", "muscles.svg", "grip.svg"})
    EXPECT_TRUE(fs::exists(out / figure));
  EXPECT_NE(run.text.find("SCHED_OTHER"), std::string::npos) << run.text;
}

// Threads have the stack that they need, whatever the shell leaves to each.
TEST(RunRealtime, RunsWithASmallStack) {
  for (const char* how : {" --no-realtime", ""}) {
    const ProgramResult run =
        thenar_program("run " + config("box_grasp.yaml") +
                           " --realtime --contact-rate 1kHz --control-rate 200Hz --time 0.3 --quiet" + how,
                       "ulimit -s 256; ");
    EXPECT_TRUE(run.code == 0 || run.code == 12) << run.code << ": " << run.text;  // 12: records were lost
  }
}

TEST(RunRealtime, StopsAtOnceWithoutGraspForces) {
  const ProgramResult run = thenar_program("run " + config("box_grasp.yaml") +
                                           " --realtime --no-realtime --set control.grasp.friction=0 --quiet");
  EXPECT_EQ(run.code, 6);
  EXPECT_NE(run.text.find("no grasp forces exist at 0.000 s"), std::string::npos) << run.text;
}

TEST(RunLockstep, GivesTheSameSignalsTwice) {
  const fs::path out = scratch();
  const std::string command = "run " + config("minimal.yaml") +
                              " --lockstep --contact-rate 2kHz --control-rate 200Hz --control-delay 3ms "
                              "--control-jitter 1ms --time 0.4 --quiet --out ";
  ASSERT_EQ(thenar_program(command + (out / "a").string()).code, 0);
  ASSERT_EQ(thenar_program(command + (out / "b").string()).code, 0);
  EXPECT_EQ(read(out / "a" / "signals.csv"), read(out / "b" / "signals.csv"));
  const std::string signals = read(out / "a" / "signals.csv");
  EXPECT_EQ(std::count(signals.begin(), signals.end(), '\n') - 1, 800);
}

}  // namespace
}  // namespace thenar::realtime_test
