// SPDX-License-Identifier: Apache-2.0
// What the program ends with after a run, and why.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::exit_code_test {
namespace {

namespace fs = std::filesystem;

TEST(Program, SaysWhichFingerSlippedWhenTheObjectIsLost) {
  const fs::path out = scratch();
  const ProgramResult run =
      thenar_program("run " + config("box_grasp.yaml") + " --set contact.friction=0.2 --out " + out.string());
  EXPECT_EQ(run.code, 7);
  EXPECT_NE(run.text.find("failed: lost: at 0."), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("the thumb slipped "), std::string::npos) << run.text;
  EXPECT_TRUE(fs::exists(out / "summary.json")) << "a failed run keeps its results";
}

// Pressed with 15 N the box asks more of muscles than they have: a run that nobody may call held.
TEST(Program, SaysWhichLimitARunPasses) {
  const ProgramResult run =
      thenar_program("run " + config("box_grasp.yaml") +
                     " --set object.points=2000 --set contact.level=2 --time '0.6 s' --format json "
                     "--set 'control.grasp.internal_force=15 N'");
  EXPECT_EQ(run.code, 11);
  const std::size_t end = run.text.rfind('}');
  const auto summary = nlohmann::json::parse(run.text.substr(run.text.find('{'), end - run.text.find('{') + 1));
  EXPECT_EQ(summary.at("grasp").at("outcome"), "over limits");
  EXPECT_EQ(summary.at("grasp").at("held"), false);
  EXPECT_EQ(summary.at("muscles").at("max_activation").get<double>(), 1.0) << "and no more";
  const auto& beyond = summary.at("grasp").at("beyond").at(0);
  EXPECT_EQ(beyond.at("unit"), "N");
  EXPECT_GT(beyond.at("value").get<double>(), beyond.at("limit").get<double>());
  EXPECT_GE(beyond.at("at_s").get<double>(), beyond.at("first_s").get<double>());
  EXPECT_NE(run.text.find("failed: over limits: the muscle "), std::string::npos) << run.text;
}

// The word is as true without a controller, but nothing was asked that could fail.
TEST(Program, WithoutAControllerASlidingObjectIsNoFailure) {
  const ProgramResult run = thenar_program("run " + config("slide.yaml") + " --set object.points=3000");
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_NE(run.text.find("slipping"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("the thumb slipped "), std::string::npos) << run.text;
}

// No finger holds a box that rests on a slope: that is told, and is no loss.
TEST(Program, WhatRestsIsNoFailure) {
  const ProgramResult run = thenar_program("run " + config("resting_box.yaml") + " --time '0.3 s'");
  EXPECT_EQ(run.code, 0) << run.text;
  for (const char* words :
       {"  from 0.100 s on the object rests on its environment, and no finger holds it\n",
        "\nenvironment\n  ticks in which it is touched                     300  from 0.001 s  to 0.3 s\n"}) {
    EXPECT_NE(run.text.find(words), std::string::npos) << run.text;
  }
}

TEST(Program, NamesTheConeAndTheMissingForceOfAnInfeasibleGrasp) {
  const ProgramResult run = thenar_program("run " + config("box_grasp.yaml") + " --set control.grasp.friction=0");
  EXPECT_EQ(run.code, 6);
  EXPECT_NE(run.text.find("the thumb's friction cone (mu_c = 0) lacks"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("N of tangential force"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("any mu_c > 0 with enough squeeze would do"), std::string::npos) << run.text;
}

}  // namespace
}  // namespace thenar::exit_code_test
