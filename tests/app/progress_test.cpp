// The line that shows how far a command is.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/program.h"

namespace thenar::progress_test {
namespace {

namespace fs = std::filesystem;

TEST(Solve, ShowsHowFarItIsOnATerminal) {
  const fs::path file = data("small/14_grasp4.json");
  const std::string words = "1 of 1: " + file.string() + " by active_set";
  const Outcome piped = thenar_program("solve --repeat 1 " + file.string());
  EXPECT_EQ(piped.text.find(words), std::string::npos);
  const Outcome seen = thenar_program("solve --repeat 1 " + file.string() + "\" /dev/null", "script -qec \"");
  if (seen.code == 127) GTEST_SKIP() << "no script(1) here";
  EXPECT_NE(seen.text.find(words), std::string::npos) << seen.text;
}

}  // namespace
}  // namespace thenar::progress_test
