// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::stiffness_test {
namespace {

const std::string kStiff = " --set 'control.muscles={stiffness: 23.4}' --set object.points=6000 ";

TEST(Program, SaysHowStiffAnObjectIsHeld) {
  const std::string file = (scratch() / "stiffness.json").string();
  const ProgramResult said = thenar_program("stiffness box_grasp --at '380 ms' --json " + file + kStiff);
  ASSERT_EQ(said.code, 0) << said.text;
  const auto figures = nlohmann::json::parse(read(file));
  EXPECT_EQ(figures.at("free"), "muscles");
  EXPECT_DOUBLE_EQ(figures.at("at_s").get<double>(), 0.38);
  EXPECT_EQ(figures.at("predicted").at("K").size(), 6U);
  // The least forces that hold the box let it turn away, so that nothing can be measured at rest.
  EXPECT_FALSE(figures.at("stable").get<bool>());
  EXPECT_TRUE(figures.at("measured").is_null());
  const double predicted = figures.at("modes")[0].at("rate_per_s"), measured = figures.at("slowest_measured_per_s");
  EXPECT_NEAR(measured, predicted, 0.1 * std::abs(predicted));
  EXPECT_NE(said.text.find("turns away"), std::string::npos) << said.text;
  EXPECT_NE(said.text.find("there is no rest"), std::string::npos) << said.text;
  EXPECT_NE(said.text.find("along all directions up to "), std::string::npos) << said.text;
  const auto& range = figures.at("range");
  EXPECT_FALSE(range.at("least").at("stable").get<bool>());
  const auto& along = range.at("translation_N_per_m");
  EXPECT_GT(along.at("most").get<double>(), 0.0);
  EXPECT_DOUBLE_EQ(along.at("near").at("asked").get<double>(), 0.99 * along.at("most").get<double>());
  EXPECT_GE(range.at("front").size(), 15U);

  const ProgramResult alone = thenar_program("stiffness box_grasp --no-probe --at 0.38" + kStiff);
  EXPECT_EQ(alone.code, 0) << alone.text;
  EXPECT_EQ(alone.text.find("the first of them measured"), std::string::npos) << alone.text;
}

/// What `model: auto` leaves out has no stiffness either.
TEST(Program, TellsNoStiffnessOfMusclesThatASceneDoesNotNeed) {
  const ProgramResult said =
      thenar_program("stiffness box_grasp --no-probe --set model=auto --set 'time.duration=300 ms'" + kStiff);
  EXPECT_EQ(said.code, 2);
  EXPECT_NE(said.text.find("auto leaves out what this is about"), std::string::npos) << said.text;
}

TEST(Program, RefusesTheStiffnessOfMusclesWithoutIt) {
  const ProgramResult stiffless = thenar_program("stiffness minimal"), none = thenar_program("stiffness leap_carry");
  EXPECT_EQ(stiffless.code, 2);
  EXPECT_NE(stiffless.text.find("name control.muscles.stiffness"), std::string::npos) << stiffless.text;
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.text.find("its hand has no muscles"), std::string::npos) << none.text;
  EXPECT_EQ(thenar_program("stiffness box_grasp --free fingers" + kStiff).code, 2);
  EXPECT_EQ(thenar_program("stiffness box_grasp --at -1" + kStiff).code, 2);
  EXPECT_EQ(thenar_program("stiffness box_gasp").code, 3);
}

}  // namespace
}  // namespace thenar::stiffness_test
