// SPDX-License-Identifier: Apache-2.0
#include "engine/results/profile.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "engine/models/build_model.h"
#include "tests/support/known_run.h"
#include "tests/support/scenes.h"

namespace thenar::profile_test {
namespace {

using namespace known_run;

using nlohmann::ordered_json;

TEST(LoopProfile, GivesTheNumbersOfAKnownRun) {
  const SyntheticRun known(1000);
  const ordered_json json = summarize(known.model, known.run);
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
  EXPECT_EQ(contact.at("residual_above_1e-2"), 1);
  EXPECT_EQ(contact.at("not_finite"), 0);
  EXPECT_EQ(contact.at("sweeps_p99"), 4);
  EXPECT_EQ(control.at("grasp_unsolved"), 0);
  EXPECT_EQ(json.at("handover").at("count"), 200);
  EXPECT_NEAR(json.at("handover").at("kick_N_max"), 0.4, 1e-6);
  EXPECT_NEAR(json.at("handover").at("tick_N_p99"), 0.1, 1e-6);
  EXPECT_NEAR(json.at("handover").at("kick_over_tick_p99"), 4.0, 1e-5);
  EXPECT_NEAR(json.at("ledger").at("injected_over_dissipated"), 0.25, 1e-12);
  EXPECT_EQ(json.at("hold").at("transitions"), 2);
  EXPECT_EQ(json.at("hold").at("ticks"), 10);
  EXPECT_NEAR(json.at("object").at("max_error_mm"), 0.0, 1e-9);
  EXPECT_NEAR(json.at("simulated_s"), 1.0, 1e-12);
  EXPECT_EQ(json.at("scheduling").at("policy"), "SCHED_FIFO");
}

TEST(LoopProfile, NamesNoNumberOfARunTooShortForIt) {
  const SyntheticRun known(50);
  const ordered_json json = summarize(known.model, known.run);
  EXPECT_TRUE(json.at("handover").at("kick_over_tick_p99").is_null()) << "the grip is not measured before 0.3 s";
  EXPECT_TRUE(json.at("object").at("max_error_mm").is_null()) << "nor is the path";
  // A run without a tick has a summary, too.
  const SyntheticRun none(0);
  EXPECT_TRUE(summarize(none.model, none.run).at("loops").at("contact").at("rate_hz").is_null());
}

TEST(LoopProfile, CountsNoForceStepAcrossALostRecord) {
  SyntheticRun known(400);
  known.run.profile.add(known.contact_sample(401, 100.0));  // tick 400 is missing
  const ordered_json json = summarize(known.model, known.run);
  EXPECT_NEAR(json.at("handover").at("kick_N_max"), 0.4, 1e-6);
}

// The largest error is that of the whole run from 0.3 s on, not that of its end: 20 mm in one tick.
TEST(LoopProfile, KeepsTheLargestErrorOfTheObject) {
  SyntheticRun known(1000);
  known.run.recording.ticks[500].position_m.x() += 20e-3;
  known.run.recording.ticks[100].position_m.x() += 50e-3;
  EXPECT_NEAR(summarize(known.model, known.run).at("object").at("max_error_mm"), 20.0, 1e-9);
}

TEST(LoopProfile, ClaimsNothingOfARunWhoseRecordsWereLost) {
  SyntheticRun known(1000);
  EXPECT_FALSE(lost_records(known.run.report));
  known.run.report.lost_samples = 2;
  known.run.report.lost_control_samples = 1;
  const ordered_json json = summarize(known.model, known.run);
  EXPECT_EQ(json.at("loops").at("contact").at("lost_samples"), 2);
  EXPECT_EQ(json.at("loops").at("control").at("lost_samples"), 1);
  const auto lost = lost_records(known.run.report);
  ASSERT_TRUE(lost);
  EXPECT_NE(lost->find("2 contact and 1 control"), std::string::npos) << *lost;
  // The recorder of such a run is told.
  Recorder recorder(known.model);
  recorder.miss(*lost);
  const Verdict verdict = recorder.finish(known.state, ControlReport(known.model.scene.hand), 1.0).verdict;
  EXPECT_TRUE(fails(known.model.scene, verdict.outcome)) << verdict.reason;
  EXPECT_NE(verdict.reason.find(*lost), std::string::npos) << verdict.reason;
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
  SyntheticRun known(1);
  const std::int64_t before = resident_bytes();
  LoopProfile profile;
  Recorder recorder(model);
  const ControlReport control(model.scene.hand);
  const Eigen::VectorXd muscle_forces_N;
  for (int i = 0; i < 1000; ++i) {
    const ContactSample sample = known.contact_sample(i, 1.0);
    recorder.see_tick(Tick{sample.after, sample.step.tick, control, muscle_forces_N});
    profile.add(sample);
    profile.add(SyntheticRun::control_sample(i));
  }
  // 1000 ticks of some 1000 bytes each, and 4 million of 100 at least if it were taken for all.
  EXPECT_LT(resident_bytes() - before, 20 << 20);
  EXPECT_EQ(std::ssize(profile.contact()), 1000);
}

}  // namespace
}  // namespace thenar::profile_test
