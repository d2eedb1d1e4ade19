// SPDX-License-Identifier: Apache-2.0
// The line that shows how far a command is.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/program.h"
#include "tests/support/scratch.h"

namespace thenar::progress_test {
namespace {

namespace fs = std::filesystem;

TEST(Solve, ShowsHowFarItIsOnATerminal) {
  const fs::path file = data("small/14_grasp4.json");
  const std::string words = "1 of 1: " + file.string() + " by active_set";
  const ProgramResult piped = thenar_program("solve --repeat 1 " + file.string());
  EXPECT_EQ(piped.text.find(words), std::string::npos);
  const ProgramResult seen = thenar_program("solve --repeat 1 " + file.string() + "\" /dev/null", "script -qec \"");
  if (seen.code == 127) GTEST_SKIP() << "no script(1) here";
  EXPECT_NE(seen.text.find(words), std::string::npos) << seen.text;
}

// A start whose samples take more than a second says what it is at, and leaves room for the results.
TEST(Run, SaysWhatALongStartIsAtOnATerminal) {
  const std::string words = "\rmaking ready: the object's samples, ";
  ProgramResult seen;
  for (int points = 120000; seen.text.find(words) == std::string::npos && points <= 1000000; points *= 2) {
    const std::string run = "run " + config("box_grasp.yaml") +
                            " --time '1 ms' --set object.points=" + std::to_string(points) + " --out " +
                            (scratch() / "out").string();
    seen = thenar_program(run + "\" /dev/null", "script -qec \"");
    if (seen.code == 127) GTEST_SKIP() << "no script(1) here";
  }
  EXPECT_NE(seen.text.find(words), std::string::npos) << seen.text;
  EXPECT_LT(seen.text.rfind("making ready"), seen.text.rfind("\r\x1b[K")) << seen.text;
}

}  // namespace
}  // namespace thenar::progress_test
