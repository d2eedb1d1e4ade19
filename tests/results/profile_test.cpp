#include "engine/results/profile.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <random>

#include "engine/loops/percentiles.h"
#include "engine/results/chrome_trace.h"
#include "engine/scenes/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::profile_test {
namespace {

using nlohmann::ordered_json;

// The definition, by counting: the smallest value that at least the share q of the sample does not exceed.
double percentile_by_counting(const std::vector<double>& values, double q) {
  double best = std::numeric_limits<double>::infinity();
  for (const double candidate : values) {
    const auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v <= candidate; });
    const bool enough = static_cast<double>(below) >= q * static_cast<double>(values.size()) - 1e-6;
    if (enough) best = std::min(best, candidate);
  }
  return best;
}

TEST(Percentiles, AreTheValuesFoundByCounting) {
  std::mt19937_64 random(3);
  for (const int n : {1, 2, 3, 10, 99, 100, 101, 999, 1000, 1001}) {
    std::vector<double> values(n);
    for (double& v : values) v = std::floor(uniform(random, 0.0, 50.0));  // with ties
    const Percentiles p = percentiles(values);
    EXPECT_EQ(p.p50, percentile_by_counting(values, 0.5)) << n;
    EXPECT_EQ(p.p99, percentile_by_counting(values, 0.99)) << n;
    EXPECT_EQ(p.p999, percentile_by_counting(values, 0.999)) << n;
    EXPECT_EQ(p.max, *std::max_element(values.begin(), values.end())) << n;
  }
}

TEST(Percentiles, OfNothingAreNaN) {
  EXPECT_TRUE(std::isnan(percentiles({}).p50));
  EXPECT_TRUE(std::isnan(percentiles({std::nan("")}).max));
}

constexpr std::int64_t kStep_ns = 1'000'000;
constexpr int kPeriod = 5;  // Steps a control period.

/// A run of two loops whose every number is known. Contact ticks start 10 us late and take 20 us, every 100th 30 us
/// late and 50 us. A frame is new in every 5th tick, where the thumb's force steps by 0.4 N, against 0.1 N elsewhere.
struct SyntheticRun {
  explicit SyntheticRun(int ticks)
      : model(build_model(scene_of("minimal", {"time.control_period=5 ms", "time.duration=1 s"}))),
        profile(model),
        state(model) {
    double force_N = 1.0;
    for (int i = 0; i < ticks; ++i) {
      if (i % kPeriod == 0) profile.add(control_sample(i));
      force_N += (i % 2 == 0 ? 1.0 : -1.0) * (i % kPeriod == 0 ? 0.4 : 0.1);
      profile.add(contact_sample(i, force_N));
    }
    report.ticks = ticks;
    report.overruns = 4;
    report.slipped = 3;
    report.frames = {.published = 11, .consumed = 7, .superseded = 3, .in_flight = 1};
    report.snapshots = {.published = 11, .consumed = 7, .superseded = 2, .in_flight = 1};
    report.contact.policy = "SCHED_FIFO";
    report.contact.core = 1;
  }

  ContactSample contact_sample(int i, double force_N) {
    const bool hundredth = i % 100 == 99;
    ContactSample sample;
    sample.deadline_ns = i * kStep_ns;
    sample.start_ns = sample.deadline_ns + (hundredth ? 30'000 : 10'000);
    sample.end_ns = sample.start_ns + (hundredth ? 50'000 : 20'000);
    sample.after = state;
    sample.after.tick = i + 1;
    for (FingerLoad& load : sample.after.load) {
      load.normal_N = 1.0;
      load.normal = load.force_N = Eigen::Vector3d::UnitZ();
    }
    sample.after.load[0].force_N.x() = force_N;
    TickReport& tick = sample.step.tick;
    tick.sequence = i / kPeriod;
    tick.frame_age = i % kPeriod + 1;
    tick.handed_over = i % kPeriod == 0;
    tick.held = i >= 600 && i < 610;
    tick.contacts = 3;
    tick.solve.sweeps = 4;
    tick.solve.residual = i == 42 ? 0.5 : 1e-4;
    tick.ledger.injected_J = 1e-6;
    tick.ledger.dissipated_J = 4e-6;
    sample.step.publish_ns = 50;
    sample.step.acquire_ns = tick.handed_over ? 300 : 7;  // Only the ticks that took one count.
    return sample;
  }

  static ControlSample control_sample(int i) {
    ControlSample sample;
    sample.deadline_ns = i * kStep_ns - 400'000;
    sample.start_ns = sample.deadline_ns + 1'000;
    sample.end_ns = sample.start_ns + 200'000;
    sample.step.sequence = i / kPeriod;
    sample.step.snapshot_tick = i;
    sample.step.published = true;
    sample.step.control.find_s = 100e-6;
    sample.step.control.factors_s = 50e-6;
    sample.step.control.grasp_s = 5e-6;
    sample.slipped = i == 0 ? 2 : 0;
    return sample;
  }

  Model model;
  LoopProfile profile;
  State state;
  ThreadsReport report;
};

TEST(LoopProfile, GivesTheNumbersOfAKnownRun) {
  const SyntheticRun run(1000);
  const ordered_json json = profile_json(run.model, run.profile, run.report);
  const ordered_json& contact = json.at("loops").at("contact");
  EXPECT_NEAR(contact.at("rate_hz"), 1000.0, 0.1);
  EXPECT_EQ(contact.at("ticks"), 1000);
  EXPECT_EQ(contact.at("overruns"), 4);
  EXPECT_EQ(contact.at("slipped"), 3);
  EXPECT_DOUBLE_EQ(contact.at("jitter").at("p50_us"), 10.0);
  EXPECT_DOUBLE_EQ(contact.at("jitter").at("p99_us"), 10.0) << "99 % start no later";
  EXPECT_DOUBLE_EQ(contact.at("jitter").at("p999_us"), 30.0);
  EXPECT_DOUBLE_EQ(contact.at("compute").at("max_us"), 50.0);
  const ordered_json& control = json.at("loops").at("control");
  EXPECT_NEAR(control.at("rate_hz"), 200.0, 1e-9);
  EXPECT_EQ(control.at("ticks"), 200);
  EXPECT_EQ(control.at("slipped"), 2);
  EXPECT_DOUBLE_EQ(control.at("total").at("p50_us"), 200.0);
  EXPECT_NEAR(control.at("stages").at("find").at("p99_us"), 100.0, 1e-4);
  EXPECT_TRUE(control.at("stages").at("muscle_lcp").at("p50_us").is_null()) << "the scene has no muscles";

  EXPECT_EQ(json.at("exchange").at("unaccounted"), 0);
  EXPECT_EQ(json.at("snapshots").at("unaccounted"), 1);
  EXPECT_EQ(json.at("exchange").at("publish_p50_ns"), 50);
  EXPECT_EQ(json.at("exchange").at("acquire_p50_ns"), 300);
  EXPECT_DOUBLE_EQ(json.at("frame_age").at("p50_ms"), 3.0);
  EXPECT_DOUBLE_EQ(json.at("frame_age").at("max_ms"), 5.0);
  EXPECT_NEAR(json.at("residual_p99"), 1e-4, 1e-10);
  EXPECT_EQ(json.at("residual_above_1e-2"), 1);
  EXPECT_EQ(json.at("not_finite"), 0);
  EXPECT_EQ(json.at("handover").at("count"), 200);
  EXPECT_NEAR(json.at("handover").at("kick_N_max"), 0.4, 1e-6);
  EXPECT_NEAR(json.at("handover").at("tick_N_p99"), 0.1, 1e-6);
  EXPECT_NEAR(json.at("handover").at("kick_over_tick_p99"), 4.0, 1e-5);
  EXPECT_NEAR(json.at("ledger").at("injected_over_dissipated"), 0.25, 1e-12);
  EXPECT_EQ(json.at("hold").at("transitions"), 2);
  EXPECT_EQ(json.at("hold").at("ticks"), 10);
  EXPECT_EQ(json.at("object").at("held"), true);
  EXPECT_NEAR(json.at("object").at("final_error_mm"), 0.0, 1e-9);
  EXPECT_NEAR(json.at("simulated_s"), 1.0, 1e-12);
  EXPECT_EQ(json.at("scheduling").at("policy"), "SCHED_FIFO");
  EXPECT_TRUE(json.at("floor").is_null());
  EXPECT_EQ(json.at("object").at("outcome"), "held") << json.at("object").at("reason");
}

TEST(LoopProfile, NamesNoNumberOfARunTooShortForIt) {
  const SyntheticRun run(50);
  const ordered_json json = profile_json(run.model, run.profile, run.report);
  EXPECT_TRUE(json.at("handover").at("kick_over_tick_p99").is_null()) << "the grip is not measured before 0.3 s";
  // An empty one is still a profile.
  const SyntheticRun none(0);
  EXPECT_TRUE(profile_json(none.model, none.profile, none.report).at("loops").at("contact").at("rate_hz").is_null());
}

TEST(LoopProfile, CountsNoForceStepAcrossALostRecord) {
  SyntheticRun run(400);
  run.profile.add(run.contact_sample(401, 100.0));  // tick 400 is missing
  const ordered_json json = profile_json(run.model, run.profile, run.report);
  EXPECT_NEAR(json.at("handover").at("kick_N_max"), 0.4, 1e-6);
}

TEST(LoopProfile, ReportsWhatBecomesOfTheGraspAndGoesOn) {
  SyntheticRun run(400);
  run.state.X_WO.translation() += Eigen::Vector3d(0.02, 0.0, 0.0);
  run.profile.add(run.contact_sample(400, 1.0));
  run.profile.add(run.contact_sample(401, 1.0));
  const ordered_json json = profile_json(run.model, run.profile, run.report);
  EXPECT_EQ(json.at("object").at("outcome"), "off target");
  EXPECT_EQ(json.at("object").at("held"), false);
  EXPECT_TRUE(json.at("object").at("lost_at_s").is_null());
  EXPECT_NEAR(json.at("object").at("max_error_mm"), 20.0, 1e-3);
  const std::string reason = run.profile.verdict(run.report).reason;
  EXPECT_EQ(json.at("object").at("reason"), reason);
  EXPECT_NE(reason.find("20.0 mm off its target at 0.401 s"), std::string::npos) << reason;
}

TEST(LoopProfile, ClaimsNothingOfARunWhoseRecordsWereLost) {
  SyntheticRun run(1000);
  run.report.lost_samples = 2;
  run.report.lost_control_samples = 1;
  const ordered_json json = profile_json(run.model, run.profile, run.report);
  EXPECT_EQ(json.at("object").at("outcome"), "unknown");
  EXPECT_EQ(json.at("loops").at("contact").at("lost_samples"), 2);
  EXPECT_EQ(json.at("loops").at("control").at("lost_samples"), 1);
  const Verdict verdict = run.profile.verdict(run.report);
  EXPECT_TRUE(fails(run.model.scene, verdict.outcome));
  EXPECT_NE(verdict.reason.find("2 contact and 1 control"), std::string::npos) << verdict.reason;
  // What was seen to go wrong is known all the same.
  run.state.X_WO.translation() += Eigen::Vector3d(0.02, 0.0, 0.0);
  run.profile.add(run.contact_sample(1000, 1.0));
  EXPECT_EQ(run.profile.verdict(run.report).outcome, Outcome::kOffTarget);
}

// A long run, and a short time of it: only what has been recorded takes memory, which in real time is locked.
TEST(LoopProfile, TakesMemoryForWhatItHas) {
  const auto resident_bytes = [] {
    std::int64_t size = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> size >> resident;
    return resident * sysconf(_SC_PAGESIZE);
  };
  const Model model =
      build_model(scene_of("minimal", {"time.duration=1000 s", "time.step=0.25 ms", "time.control_period=1 ms"}));
  SyntheticRun run(1);
  const std::int64_t before = resident_bytes();
  LoopProfile profile(model);
  Recorder recorder(model);
  const ControlReport control;
  const Eigen::VectorXd muscle_forces_N;
  for (int i = 0; i < 1000; ++i) {
    const ContactSample sample = run.contact_sample(i, 1.0);
    recorder.see_tick(Tick{sample.after, sample.step.tick, control, muscle_forces_N});
    profile.add(sample);
    profile.add(SyntheticRun::control_sample(i));
  }
  // 1000 ticks of some 1000 bytes each, and 4 million of 100 at least if it were taken for all.
  EXPECT_LT(resident_bytes() - before, 20 << 20);
  EXPECT_EQ(std::ssize(profile.contact()), 1000);
}

TEST(ChromeTrace, HasSlicesThatNestAndDoNotOverlap) {
  const SyntheticRun run(1000);
  const auto trace = nlohmann::json::parse(chrome_trace(run.model, run.profile, 0.5));
  struct Slice {
    double from_us, to_us;
  };
  std::map<int, std::vector<Slice>> threads;
  std::map<std::pair<std::string, int>, double> starts;
  int ticks = 0, arrows = 0;
  for (const auto& event : trace.at("traceEvents")) {
    if (event.at("ph") == "X") {
      const double from_us = event.at("ts");
      EXPECT_GE(from_us, 0.0);
      threads[event.at("tid")].push_back({from_us, from_us + event.at("dur").get<double>()});
      ticks += event.at("name") == "contact tick" || event.at("name") == "contact tick, held";
    } else if (event.at("ph") == "s") {
      starts[{event.at("cat"), event.at("id")}] = event.at("ts");
    }
  }
  for (const auto& event : trace.at("traceEvents")) {
    if (event.at("ph") != "f") continue;
    ++arrows;
    EXPECT_LE(starts.at({event.at("cat"), event.at("id")}), event.at("ts")) << "nothing is used before it is published";
  }
  EXPECT_EQ(threads.size(), 2);
  EXPECT_NEAR(ticks, 500, 1);
  EXPECT_NEAR(arrows, 200, 3) << "a frame and a snapshot each period";
  for (auto& [thread, slices] : threads) {
    std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) {
      return a.from_us < b.from_us || (a.from_us == b.from_us && a.to_us > b.to_us);
    });
    std::vector<double> open;  // Where the slices around the next one end.
    for (const Slice& slice : slices) {
      while (!open.empty() && open.back() <= slice.from_us + 1e-6) open.pop_back();
      // Times are written to a nanosecond.
      if (!open.empty()) {
        EXPECT_LE(slice.to_us, open.back() + 2e-3) << "thread " << thread;
      }
      open.push_back(slice.to_us);
    }
  }
}

}  // namespace
}  // namespace thenar::profile_test
