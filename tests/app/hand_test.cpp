// SPDX-License-Identifier: Apache-2.0
// `thenar hand`.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::hand_test {
namespace {

const std::string kTips = " --tips thumb=thumb_2:@24/1/-3mm,fore=fore_cap,little=little_tip:7mm";

TEST(Program, ListsAndDrawsAHandByName) {
  const std::filesystem::path picture = scratch() / "leap.png";
  const ProgramResult list = thenar_program("hand leap --out " + picture.string());
  EXPECT_EQ(list.code, 0) << list.text;
  EXPECT_NE(list.text.find("4 fingers, 16 joints, 0 muscles"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("I_MCP                     -18.0 .. 127.8 deg"), std::string::npos) << list.text;
  EXPECT_NE(list.text.find("thumb and ring"), std::string::npos) << list.text;
  EXPECT_TRUE(std::filesystem::exists(picture));
}

// A hand's name or file is as good for `thenar check`, which takes scenes, too.
TEST(Program, ChecksAHandAsItListsAndDrawsIt) {
  const std::filesystem::path picture = scratch() / "leap.png";
  const std::string list = thenar_program("hand leap").text;
  EXPECT_EQ(thenar_program("check leap").text, list);
  const ProgramResult file = thenar_program("check " + config("hands/leap.yaml"));
  EXPECT_EQ(file.text.substr(file.text.find(": ")), list.substr(list.find(": "))) << "but for the file's name";
  const ProgramResult drawn = thenar_program("check leap --out " + picture.string());
  EXPECT_EQ(drawn.code, 0) << drawn.text;
  EXPECT_TRUE(std::filesystem::exists(picture));

  const ProgramResult slip = thenar_program("check leep"), scene = thenar_program("check minimum");
  EXPECT_EQ(slip.code, 3);
  EXPECT_EQ(slip.text, "leep: no such file, nor a scene or hand that comes with the program, did you mean 'leap'?\n");
  EXPECT_NE(scene.text.find("did you mean 'minimal'?"), std::string::npos) << scene.text;
  const std::string a_scene = config("minimal.yaml"), a_hand = config("hands/leap.yaml");
  EXPECT_EQ(thenar_program("run " + a_hand).text,
            a_hand + ": is a hand, which a scene names in hand.model, and no scene\n");
  EXPECT_EQ(thenar_program("hand " + a_scene).text,
            a_scene + ": is a scene, which names its hand in hand.model, and no hand\n");
  for (const char* arguments :
       {"check leap --set contact.friction=1", "check leap --parts", "check minimal --out a.png"})
    EXPECT_EQ(thenar_program(arguments).code, 2) << arguments;
}

TEST(Program, ImportsAHandAndSaysWhatWasGuessed) {
  const std::string out = (scratch() / "gripper.yaml").string();
  const ProgramResult made = thenar_program("hand import " + data("hands/gripper.xml") + kTips + " --out " + out);
  EXPECT_EQ(made.code, 0) << made.text;
  EXPECT_NE(made.text.find("note: joint 'wrist_turn' is locked"), std::string::npos) << made.text;
  EXPECT_NE(made.text.find("3 fingers, 9 joints, 5 muscles"), std::string::npos) << made.text;
  const std::string text = read(out);
  EXPECT_NE(text.find("# thenar hand import gripper.xml --tips thumb=thumb_2"), std::string::npos) << text;
  EXPECT_NE(text.find("# - joint 'wrist_turn' is locked"), std::string::npos) << text;
  EXPECT_NE(thenar_program("hand " + out).text.find("fore_spread"), std::string::npos);
}

TEST(Program, RefusesWhatNoHandCanBeMadeOf) {
  const std::string out = (scratch() / "hand.yaml").string();
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    const ProgramResult said = thenar_program("hand " + arguments);
    EXPECT_EQ(said.code, 2) << said.text;
    EXPECT_NE(said.text.find(words), std::string::npos) << said.text;
  };
  const std::string file = data("hands/gripper.xml");
  refused("import " + file + " --tips thumb=thumb_9 --out " + out, "did you mean 'thumb_1'?");
  refused("import " + file + " --tips thumb --out " + out, "write it as FINGER=BODY");
  refused("import " + file + kTips + " --out " + file, "would replace");
  refused("import " + file + kTips, "--out");
  refused("", "name a hand file, or import");
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_EQ(thenar_program("hand import none.xml --tips a=b --out " + out).code, 3);
  const ProgramResult unknown = thenar_program("hand alegro");
  EXPECT_EQ(unknown.code, 3);
  EXPECT_NE(unknown.text.find("nor a hand that comes with the program, did you mean 'allegro'?"), std::string::npos)
      << unknown.text;
}

// The figures are those of the study, and say what limits them.
TEST(Program, SaysWhatTheMusclesOfAHandCanGive) {
  const std::string file = (scratch() / "capacity.json").string(), coarse = " --set object.points=6000";
  const ProgramResult said = thenar_program("hand capacity box_grasp --friction 0.8 --json " + file + coarse);
  ASSERT_EQ(said.code, 0) << said.text;
  const auto figures = nlohmann::json::parse(read(file));
  const auto& pinch = figures.at("pinch");
  EXPECT_EQ(pinch.at("status"), "optimal");
  const double thumb_N = pinch.at("force_N"), others_N = pinch.at("normal_N").at("index").get<double>() +
                                                         pinch.at("normal_N").at("major").get<double>();
  EXPECT_NEAR(pinch.at("normal_N").at("thumb").get<double>(), thumb_N, 1e-6);
  EXPECT_NEAR(others_N, thumb_N, 0.05 * thumb_N) << "faces of a box are parallel";
  EXPECT_NE(said.text.find(fmt::format("largest pinch, friction 0.8: {:.1f} N by the thumb", thumb_N)),
            std::string::npos)
      << said.text;
  EXPECT_NE(said.text.find("92 N (men), 68 N (women)"), std::string::npos) << said.text;
  double shares = 0.0;
  for (const auto& limit : pinch.at("limiting")) {
    shares += limit.at("share").get<double>();
    EXPECT_NE(said.text.find(limit.at("muscle")), std::string::npos) << said.text;
  }
  EXPECT_NEAR(shares, 1.0, 1e-6);
  ASSERT_EQ(figures.at("fingers").size(), 3U);
  EXPECT_EQ(figures.at("fingers")[1].at("ring").size(), 12U);

  const ProgramResult slippery = thenar_program("hand capacity box_grasp --friction 0.1" + coarse);
  EXPECT_NE(slippery.text, said.text);
}

TEST(Program, RefusesTheCapacityOfAHandWithoutPostureOrMuscles) {
  const ProgramResult alone = thenar_program("hand capacity human5"), none = thenar_program("hand capacity leap_carry");
  EXPECT_EQ(alone.code, 2);
  EXPECT_NE(alone.text.find("is a hand, which has no posture: name a scene"), std::string::npos) << alone.text;
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.text.find("its hand has no muscles"), std::string::npos) << none.text;
  EXPECT_EQ(thenar_program("hand capacity box_grasp --friction -1").code, 2);
  EXPECT_EQ(thenar_program("hand capacity box_gasp").code, 3);
}

TEST(Program, RunsASceneWithAHandByNameAndRefusesMusclesOfAHandWithoutThem) {
  const std::string angles =
      " --set 'hand.posture=[0.3 rad, 0.3 rad, 0.3 rad, 0.3 rad, 0.5 rad, 0 rad, 0.5 rad, 0.5 rad, 0.5 rad, 0 rad, "
      "0.5 rad, 0.5 rad, 0.5 rad, 0 rad, 0.5 rad, 0.5 rad]'";
  const ProgramResult check = thenar_program("check " + config("box_grasp.yaml") +
                                             " --set hand.model=leap --set control.muscles=true" + angles);
  EXPECT_EQ(check.code, 2) << check.text;
  EXPECT_NE(check.text.find("this hand has none: write false, and torques drive its joints"), std::string::npos)
      << check.text;
  const ProgramResult far = thenar_program("check " + config("box_grasp.yaml") +
                                           " --set hand.model=leap --set control.muscles=false" + angles);
  EXPECT_EQ(far.code, 0) << far.text;
  EXPECT_NE(far.text.find("16 joints"), std::string::npos) << far.text;
}

}  // namespace
}  // namespace thenar::hand_test
