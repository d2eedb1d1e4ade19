// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::insertion_program_test {
namespace {

namespace fs = std::filesystem;

TEST(Program, TellsHowAPegGoesIn) {
  const fs::path folder = scratch() / "peg";
  const ProgramResult said = thenar_program("insertion peg --set object.points=9000 --out " + folder.string());
  EXPECT_EQ(said.code, 0) << said.text;
  for (const char* words : {"c / mu", "how they touched", "one point", "against the theory of a peg"})
    EXPECT_NE(said.text.find(words), std::string::npos) << words << " in\n" << said.text;
  const auto figures = nlohmann::json::parse(read(folder / "insertion.json"));
  EXPECT_EQ(figures.at("end"), "in");
  EXPECT_GT(figures.at("phases").size(), 2U);
  EXPECT_TRUE(read(folder / "insertion.csv").starts_with("time_s,touch,depth_mm,"));
  if (fs::exists(folder / "insertion.svg")) {  // Where there is gnuplot.
    EXPECT_NE(read(folder / "insertion.svg").find("the jamming diagram"), std::string::npos);
  } else {
    EXPECT_NE(said.text.find("gnuplot"), std::string::npos) << said.text;
  }
}

/// Of a peg whose scene does not need its hole there is nothing to tell.
TEST(Program, StudiesNoInsertionThatASceneDoesNotNeed) {
  const ProgramResult none = thenar_program(
      "insertion peg --set object.points=9000 --set model=auto --set tolerance='{position: 100 mm, rotation: 90 deg, "
      "force: 9000 %, moment: 9000 %, margin: 1}'");
  EXPECT_EQ(none.code, 2) << none.text;
  EXPECT_NE(none.text.find("the environment (environment)"), std::string::npos) << none.text;
}

TEST(Program, RefusesAnInsertionWithoutPegOrHole) {
  const ProgramResult box = thenar_program("insertion resting_box"), alone = thenar_program("insertion minimal");
  for (const ProgramResult& said : {box, alone}) {
    EXPECT_EQ(said.code, 2);
    EXPECT_NE(said.text.find("its object is no peg"), std::string::npos) << said.text;
    EXPECT_EQ(std::count(said.text.begin(), said.text.end(), '\n'), 1) << said.text;
  }
  EXPECT_EQ(thenar_program("insertion peg --set environment.friction=-1").code, 2);
  EXPECT_EQ(thenar_program("insertion pegg").code, 3);
}

}  // namespace
}  // namespace thenar::insertion_program_test
