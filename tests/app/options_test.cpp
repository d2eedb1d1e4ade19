// SPDX-License-Identifier: Apache-2.0
// The command line.

#include <gtest/gtest.h>

#include <string>

#include "tests/support/program.h"

namespace thenar::options_test {
namespace {

TEST(Program, PrintsItsVersionAndHelp) {
  EXPECT_EQ(thenar_program("--version").code, 0);
  EXPECT_NE(thenar_program("--version").text.find("thenar 0."), std::string::npos);
  EXPECT_EQ(thenar_program("run --help").code, 0);
  EXPECT_NE(thenar_program("run --help").text.find("thenar run ["), std::string::npos);
  EXPECT_EQ(thenar_program("run --help").text.find(THENAR_PROGRAM), std::string::npos) << "usage without a path";
}

// Each of the programs becomes another one for what that does, once.
TEST(Program, IsOneOfSeveral) {
  const std::string studies = "sh -c '\"$0\"-studies \"$@\"' ";
  EXPECT_EQ(thenar_program("scenes", studies).text, thenar_program("scenes").text);
  EXPECT_EQ(thenar_program("hand hand", studies).text, thenar_program("hand hand").text);
  EXPECT_NE(thenar_program("--version=false demo", "timeout 20 ").code, 124);
}

TEST(Program, NamesTheSceneThatIsNearest) {
  const ProgramResult slip = thenar_program("run box_graps");
  EXPECT_EQ(slip.code, 3);
  EXPECT_EQ(slip.text, "box_graps: no such file, nor a scene that comes with the program, did you mean 'box_grasp'?\n");
  EXPECT_EQ(thenar_program("check ./box_grasp").text, "./box_grasp: no such file\n");
}

TEST(Program, NamesAnUnknownCommandAndTheNearest) {
  const ProgramResult slip = thenar_program("rn");
  EXPECT_EQ(slip.code, 2);
  EXPECT_NE(slip.text.find("'rn' is no command, did you mean 'run'?"), std::string::npos) << slip.text;
  EXPECT_NE(slip.text.find("thenar --help"), std::string::npos) << slip.text;
  const ProgramResult none = thenar_program("list configs");
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.text.find("'list' is no command; "), std::string::npos) << none.text;
  const ProgramResult renamed = thenar_program("profile " + config("minimal.yaml") + " --floor");
  EXPECT_EQ(renamed.code, 2);
  EXPECT_EQ(renamed.text,
            "thenar: 'profile' is no command: profile is run --realtime now; `thenar --help` lists all commands\n");
  const ProgramResult nothing = thenar_program("");
  EXPECT_EQ(nothing.code, 2);
  EXPECT_NE(nothing.text.find("name a command"), std::string::npos) << nothing.text;
}

}  // namespace
}  // namespace thenar::options_test
