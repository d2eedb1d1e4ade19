// The two loops as a user meets them: what `profile`, `run --realtime` and `run --lockstep` print, write and refuse.
// Counts and forms are asserted, never times.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::profile_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A short profile of the least scene, as a user without real-time rights has it.
Outcome short_profile(const std::string& arguments, const std::string& before = "") {
  return thenar_program("profile " + config("minimal.yaml") +
                            " --contact-rate 1kHz --control-rate 200Hz --duration 0.4s --no-realtime " + arguments,
                        before);
}

void expect_latencies(const json& times) {
  for (const char* key : {"p50_us", "p99_us", "p999_us", "max_us"}) EXPECT_TRUE(times.at(key).is_number()) << key;
  EXPECT_LE(times.at("p50_us"), times.at("p99_us"));
  EXPECT_LE(times.at("p99_us"), times.at("p999_us"));
  EXPECT_LE(times.at("p999_us"), times.at("max_us"));
}

// One vocabulary: what must fit into which period, in all that speaks of budgets; and what it means to keep a rate.
TEST(Profile, SaysWhichTimeMustFitIntoWhichPeriod) {
  const std::string fits = "start jitter + compute must fit into 1000 us, the period";
  const std::string control_fits = "start jitter + tick must fit into 5000 us, the period";
  const Outcome profile = short_profile("");
  EXPECT_NE(profile.text.find(fits), std::string::npos) << profile.text;
  EXPECT_NE(profile.text.find(control_fits), std::string::npos) << profile.text;
  EXPECT_NE(profile.text.find("kept [%]"), std::string::npos) << profile.text;
  const Outcome run = thenar_program("run " + config("minimal.yaml") +
                                     " --realtime --contact-rate 1kHz --control-rate 200Hz --time 0.4 --no-realtime");
  EXPECT_NE(run.text.find(fits), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("on both threads together: must fit into no period"), std::string::npos) << run.text;
  const Outcome doctor = thenar_program("doctor");
  EXPECT_EQ(doctor.code, 0);
  EXPECT_EQ(doctor.text.find("cannot keep"), std::string::npos) << doctor.text;
  const bool keeps = doctor.text.find("can keep contact at ") != std::string::npos;
  EXPECT_EQ(keeps, doctor.text.find("must fit `contact: compute`") != std::string::npos) << doctor.text;
  EXPECT_EQ(!keeps, doctor.text.find("may not keep contact at 1 kHz") != std::string::npos) << doctor.text;
}

TEST(Profile, WritesEveryNumberThatItPromises) {
  const fs::path out = scratch();
  const Outcome run = short_profile("--out " + out.string() + " --trace " + (out / "trace.json").string());
  ASSERT_EQ(run.code, 0) << run.text;
  const auto profile = json::parse(read(out / "profile.json"));
  for (const char* key : {"policy", "priority", "core", "locked", "spin_us", "timer_slack_ns", "remark"}) {
    EXPECT_TRUE(profile.at("scheduling").contains(key)) << key;
  }
  const json& contact = profile.at("loops").at("contact");
  expect_latencies(contact.at("jitter"));
  expect_latencies(contact.at("compute"));
  EXPECT_EQ(contact.at("ticks").get<int>() + contact.at("slipped").get<int>(), 400) << "every tick is done or slipped";
  EXPECT_GE(contact.at("overruns"), 0);
  EXPECT_GT(contact.at("rate_hz"), 0.0);
  EXPECT_EQ(contact.at("lost_samples"), 0);
  EXPECT_EQ(profile.at("loops").at("control").at("lost_samples"), 0);
  const json& control = profile.at("loops").at("control");
  expect_latencies(control.at("total"));
  expect_latencies(control.at("jitter"));
  for (const char* stage : {"find", "factors", "grasp_lcp"}) expect_latencies(control.at("stages").at(stage));
  EXPECT_TRUE(control.at("stages").at("muscle_lcp").at("p50_us").is_null()) << "the scene has no muscles";

  for (const json* exchange : {&profile.at("exchange"), &profile.at("snapshots")}) {
    EXPECT_GT(exchange->at("published"), 0);
    EXPECT_EQ(exchange->at("torn"), 0);
    EXPECT_EQ(exchange->at("unaccounted"), 0);
  }
  for (const char* key : {"publish_p50_ns", "publish_p99_ns", "acquire_p50_ns", "acquire_p99_ns"}) {
    EXPECT_GE(profile.at("exchange").at(key), 0.0) << key;
  }
  EXPECT_EQ(profile.at("handover").at("count"), profile.at("exchange").at("consumed")) << "a new frame is one taken";
  for (const char* key : {"p50_ms", "p99_ms", "max_ms"}) EXPECT_GE(profile.at("frame_age").at(key), 0.0) << key;
  EXPECT_TRUE(profile.at("handover").contains("kick_over_tick_p99"));
  EXPECT_TRUE(profile.at("ledger").contains("injected_over_dissipated"));
  EXPECT_LE(profile.at("residual_p99"), 1e-3) << "the tolerance in real time";
  EXPECT_EQ(profile.at("residual_above_1e-2"), 0);
  EXPECT_EQ(profile.at("not_finite"), 0);
  EXPECT_EQ(profile.at("object").at("held"), true);
  EXPECT_TRUE(profile.at("floor").is_null());
  EXPECT_LT(profile.at("max_penetration_um"), 100.0);
  EXPECT_TRUE(profile.at("warnings").empty()) << profile.at("warnings");
  for (const char* key : {"sweeps", "contacts", "hold", "wall_s", "simulated_s", "build", "settings"}) {
    EXPECT_TRUE(profile.contains(key)) << key;
  }
  for (const char* figure : {"jitter.svg", "handover.svg", "timeline.svg"}) {
    EXPECT_NE(read(out / figure).find("</svg>"), std::string::npos) << figure;
  }
  EXPECT_GT(json::parse(read(out / "trace.json")).at("traceEvents").size(), 400);
}

TEST(Profile, PrintsSpeedBesideAccuracyAndWhatWasGranted) {
  const Outcome run = short_profile("");
  ASSERT_EQ(run.code, 0) << run.text;
  for (const char* text : {"SCHED_OTHER", "contact: start jitter", "control: whole tick", "contact residual, p99",
                           "energy injected/dissipated", "frames, to contact", "publish a snapshot"}) {
    EXPECT_NE(run.text.find(text), std::string::npos) << text;
  }
}

TEST(Profile, TakesTheLastWordOnASetting) {
  const fs::path out = scratch();
  const auto settings = [&](const std::string& arguments) {
    const Outcome run = short_profile(arguments + " --out " + out.string());
    EXPECT_EQ(run.code, 0) << run.text;
    return json::parse(read(out / "profile.json")).at("settings");
  };
  EXPECT_EQ(settings("").at("tolerance"), 1e-7) << "what real time can afford";
  EXPECT_EQ(settings("").at("max_sweeps"), 60);
  EXPECT_EQ(settings("--set contact.tolerance=1e-5").at("tolerance"), 1e-5) << "a default gives way";
  EXPECT_EQ(settings("--tolerance 1e-4 --set contact.tolerance=1e-5").at("tolerance"), 1e-4) << "a flag does not";
}

// 100 kHz is more than any tick keeps: that is warned of, in a sentence, unless the run is to be quiet.
TEST(Profile, WarnsOfOverrunsUnlessQuiet) {
  const std::string command =
      "profile " + config("box_grasp.yaml") + " --contact-rate 100kHz --duration 0.1s --no-realtime";
  const Outcome run = thenar_program(command);
  EXPECT_NE(run.text.find("overran"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("in the last second"), std::string::npos) << run.text;
  EXPECT_EQ(thenar_program(command + " --quiet").text.find("overran"), std::string::npos);
}

TEST(Profile, ReportsALostObjectAtTheEnd) {
  const Outcome run = thenar_program("profile " + config("box_grasp.yaml") +
                                     " --contact-rate 1kHz --duration 0.9s --no-realtime --set contact.friction=0.1");
  EXPECT_EQ(run.code, 7) << run.text;
  EXPECT_NE(run.text.find("failed: lost: at 0."), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("contact: start jitter"), std::string::npos) << "the profile is told all the same";
}

TEST(Profile, FailsWithoutGraspForcesAtTheStart) {
  const Outcome run =
      thenar_program("profile " + config("box_grasp.yaml") + " --no-realtime --set control.grasp.friction=0 --quiet");
  EXPECT_EQ(run.code, 6);
  EXPECT_NE(run.text.find("no grasp forces exist at 0.000 s"), std::string::npos) << run.text;
}

TEST(Profile, SaysHowToGetTheFloor) {
  const fs::path out = scratch();
  const Outcome run = short_profile("--floor --out " + out.string(), "PATH=/nowhere ");
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_NE(run.text.find("apt-get install rt-tests"), std::string::npos) << run.text;
  EXPECT_TRUE(json::parse(read(out / "profile.json")).at("floor").is_null());
}

// A cyclictest of our own tells what is known: 98 loops start 5 us late, one 7 us, one 2 ms, which is off its
// histogram.
TEST(Profile, ReadsCyclictestsHistogram) {
  const fs::path out = scratch();
  std::ofstream(out / "cyclictest") << "#!/bin/sh\necho \"$@\" >> " << (out / "asked").string()
                                    << "\ncat <<EOF\n# Histogram\n004999 000000\n005000 000098\n007000 000001\n"
                                       "# Total: 000000099\n# Min Latencies: 05000\n# Avg Latencies: 05020\n"
                                       "# Max Latencies: 2000000\n# Histogram Overflows: 00001\nEOF\n";
  fs::permissions(out / "cyclictest", fs::perms::owner_all);
  const Outcome run = short_profile("--floor --out " + out.string(), "PATH=" + out.string() + ":$PATH ");
  ASSERT_EQ(run.code, 0) << run.text;
  const auto floor = json::parse(read(out / "profile.json")).at("floor");
  EXPECT_EQ(floor.at("pairs"), 5);
  ASSERT_EQ(floor.at("ratios").size(), 5);
  EXPECT_EQ(floor.at("cyclictest_p99_us"), json({7.0, 7.0, 7.0, 7.0, 7.0}));
  std::vector<double> ratios = floor.at("ratios");
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(ratios[i] * 7.0, floor.at("jitter_p99_us").at(i), 1e-9);
  }
  std::sort(ratios.begin(), ratios.end());
  EXPECT_EQ(floor.at("ratio_p99_median"), ratios[2]);
  EXPECT_EQ(floor.at("spin").at("spin_us"), 50.0);
  EXPECT_EQ(floor.at("remark"), "") << "nothing was asked for, so both ran alike";
  // Asked for what our own thread had: 400 loops of 1 ms under the ordinary policy.
  const std::string asked = read(out / "asked");
  EXPECT_NE(asked.find("-i 1000 -l 400 "), std::string::npos) << asked;
  EXPECT_NE(asked.find("--policy=other"), std::string::npos) << asked;
}

TEST(RunRealtime, WritesWhatARunInOneLoopWritesAndItsLoops) {
  const fs::path out = scratch();
  const Outcome run = thenar_program("run " + config("box_grasp.yaml") +
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
    const Outcome run =
        thenar_program("run " + config("box_grasp.yaml") +
                           " --realtime --contact-rate 1kHz --control-rate 200Hz --time 0.3 --quiet" + how,
                       "ulimit -s 256; ");
    EXPECT_TRUE(run.code == 0 || run.code == 12) << run.code << ": " << run.text;  // 12: records were lost
  }
}

TEST(RunRealtime, StopsAtOnceWithoutGraspForces) {
  const Outcome run = thenar_program("run " + config("box_grasp.yaml") +
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

struct BadFlag {
  const char* name;
  const char* arguments;
  const char* message;
};

class TwoLoopsRefuse : public testing::TestWithParam<BadFlag> {};

TEST_P(TwoLoopsRefuse, NamingTheFlag) {
  const std::string arguments = GetParam().arguments;
  const auto space = arguments.find(' ');
  const Outcome run =
      thenar_program(arguments.substr(0, space) + " " + config("minimal.yaml") + arguments.substr(space));
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.text.find(GetParam().message), 0) << run.text;
}

INSTANTIATE_TEST_SUITE_P(
    Flags, TwoLoopsRefuse,
    testing::Values(
        BadFlag{"NoUnit", "profile --contact-rate 4000", "--contact-rate: 4000 has no unit: use Hz or kHz"},
        BadFlag{"WrongUnit", "profile --contact-rate '4 ms'", "--contact-rate: 4 ms is not a frequency"},
        BadFlag{"ZeroRate", "profile --control-rate 0Hz", "--control-rate: 0Hz must lie within 1 Hz"},
        BadFlag{"NegativeRate", "profile --contact-rate=-4kHz", "--contact-rate: -4kHz must lie within"},
        BadFlag{"NotARate", "profile --control-rate fast", "--control-rate: 'fast' is not a frequency"},
        BadFlag{"NoTime", "profile --duration 30", "--duration: 30 has no unit"},
        BadFlag{"RateForTime", "profile --spin 20kHz", "--spin: 20kHz is not a time"},
        BadFlag{"BadTolerance", "profile --tolerance 1mm", "--tolerance: 1mm must be a plain number"},
        BadFlag{"ControlFaster", "profile --contact-rate 1kHz --control-rate 2kHz",
                "--control-rate: 2kHz must not be faster than --contact-rate"},
        BadFlag{"ControlFasterThanTheDefault", "profile --control-rate 8kHz",
                "--control-rate: 8kHz must not be faster than the contact loop: give --contact-rate"},
        BadFlag{"NotATime", "run --time abc", "--time: 'abc' is not a time"},
        BadFlag{"ZeroTime", "run --time 0", "--time: 0 s must lie within"},
        BadFlag{"EmptyTime", "run --time ''", "--time: '' is not a time"},
        BadFlag{"EmptyOut", "run --out ''", "--out: needs a name"},
        BadFlag{"EmptyTrace", "profile --trace ''", "--trace: needs a name"},
        BadFlag{"TraceIntoAFolder", "profile --trace /", "--trace: / is a folder"},
        BadFlag{"TraceOverTheProfile", "profile --out nowhere --trace nowhere/../nowhere/profile.json",
                "--trace: nowhere/../nowhere/profile.json is a file of --out's own"},
        BadFlag{"RateOfOneLoop", "run --contact-rate 4kHz", "--contact-rate: needs --realtime or --lockstep"},
        BadFlag{"SpinOfLockstep", "run --lockstep --spin 50us", "--spin requires --realtime"},
        BadFlag{"NoSuchCore", "profile --core 4711", "--core: 4711 is none of the cores that the program may use: "},
        BadFlag{"NoCore", "profile --core last", "--core: last is none of the cores"},
        BadFlag{"CoreOfOneLoop", "run --core 0", "--core requires --realtime"},
        BadFlag{"DelayOfThreads", "run --realtime --control-delay 5ms", "--control-delay requires --lockstep"},
        BadFlag{"AutoOfLockstep", "run --lockstep --control-rate auto", "--control-rate: auto needs --realtime"},
        BadFlag{"TwoRunners", "run --realtime --lockstep", "--realtime excludes --lockstep"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace thenar::profile_test
