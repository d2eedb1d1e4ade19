// SPDX-License-Identifier: Apache-2.0
// What a run of two loops prints of its times.

#include <gtest/gtest.h>

#include <string>

#include "tests/app/short_run.h"
#include "tests/support/program.h"

namespace thenar::loops_table_test {
namespace {

using namespace short_runs;

// One vocabulary: what must fit into which period, in all that speaks of budgets; and what it means to keep a rate.
TEST(LoopsTable, SaysWhichTimeMustFitIntoWhichPeriod) {
  const std::string fits = "start jitter + compute must fit into 1000 us, the period";
  const std::string control_fits = "start jitter + tick must fit into 5000 us, the period";
  const ProgramResult run = short_run("");
  EXPECT_NE(run.text.find(fits), std::string::npos) << run.text;
  EXPECT_NE(run.text.find(control_fits), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("kept [%]"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("on both threads together: must fit into no period"), std::string::npos) << run.text;
  const ProgramResult doctor = thenar_program("doctor");
  EXPECT_EQ(doctor.code, 0);
  EXPECT_EQ(doctor.text.find("cannot keep"), std::string::npos) << doctor.text;
  const bool keeps = doctor.text.find("can keep contact at ") != std::string::npos;
  EXPECT_EQ(keeps, doctor.text.find("must fit `contact: compute`") != std::string::npos) << doctor.text;
  EXPECT_EQ(!keeps, doctor.text.find("may not keep contact at 1 kHz") != std::string::npos) << doctor.text;
}

TEST(LoopsTable, PrintsSpeedBesideAccuracyAndWhatWasGranted) {
  const ProgramResult run = short_run("");
  ASSERT_EQ(run.code, 0) << run.text;
  for (const char* text :
       {"SCHED_OTHER", "two threads: ", "contact: start jitter", "control: whole tick", "contact residual, p99",
        "energy injected/dissipated", "frames, to contact", "publish a snapshot"}) {
    EXPECT_NE(run.text.find(text), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace thenar::loops_table_test
