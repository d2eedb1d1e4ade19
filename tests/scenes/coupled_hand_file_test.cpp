// SPDX-License-Identifier: Apache-2.0
// Hand files with joints that follow others: what is read, and what is refused with which words.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "engine/formats/files.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::coupled_hand_file_test {
namespace {

/// hand.yaml with these words behind the limits of a joint; "I_DIP_FE" has "follows: I_PIP_FE".
std::filesystem::path hand_with(const std::string& joint, const std::string& words) {
  std::string text = read_file(config_file("hand"));
  const std::size_t at = text.find('}', text.find("{name: " + joint));
  const std::filesystem::path file = scratch() / "hand.yaml";
  std::ofstream(file) << text.insert(at, ", " + words);
  return file;
}

std::string refusal(const std::string& joint, const std::string& words) {
  try {
    (void)load_hand(hand_with(joint, words));
  } catch (const ConfigError& error) {
    const std::string said = error.what();
    const std::size_t file = said.find("hand.yaml:");
    return file == said.npos ? said : said.substr(file + 10);
  }
  return "";
}

TEST(CoupledHandFile, ReadsAJointThatFollows) {
  const Hand hand = load_hand(hand_with("I_DIP_FE", "follows: I_PIP_FE, ratio: 0.7, offset: 0.1"));
  ASSERT_EQ(hand.joints.size(), 11U);
  ASSERT_EQ(hand.followers.size(), 1U);
  const Follower& follower = hand.followers.front();
  EXPECT_EQ(follower.joint.name, "I_DIP_FE");
  EXPECT_EQ(hand.joints[follower.leader].name, "I_PIP_FE");
  EXPECT_EQ(follower.ratio, 0.7);
  EXPECT_EQ(follower.offset_rad, 0.1);
  EXPECT_EQ(hand.joint(11).name, "I_DIP_FE");
  EXPECT_EQ(hand.leader(11), 6);
  EXPECT_EQ(hand.fingertips[1].joints, 3);
  EXPECT_EQ(hand.fingertips[1].followers, 1);
  EXPECT_EQ(hand.fingertips[2].first_joint, 7);
  EXPECT_EQ(hand.fingertips[2].followers, 0);
  const Segment& distal = hand.segments[hand.fingertips[1].segment];
  EXPECT_EQ(distal.joints, 3);
  EXPECT_EQ(distal.followers, 1);
  EXPECT_EQ(hand.muscles.size(), 23U);
  const Hand equal = load_hand(hand_with("I_DIP_FE", "follows: I_PIP_FE"));
  EXPECT_EQ(equal.followers.front().ratio, 1.0);
  EXPECT_EQ(equal.followers.front().offset_rad, 0.0);
}

TEST(CoupledHandFile, RefusesWithThePlace) {
  EXPECT_EQ(refusal("I_DIP_FE", "follows: I_PIP"), "14:147: joints[7].follows: no joint is named 'I_PIP'");
  EXPECT_NE(refusal("I_DIP_FE", "follows: M_PIP_FE").find("joints[7].follows: 'M_PIP_FE' is a joint of another finger"),
            std::string::npos);
  EXPECT_NE(refusal("I_PIP_FE", "follows: I_DIP_FE").find("joints[6].follows: 'I_DIP_FE' is no nearer to the palm"),
            std::string::npos);
  EXPECT_NE(refusal("I_DIP_FE", "follows: I_PIP_FE, ratio: 0").find("with a ratio of zero"), std::string::npos);
  EXPECT_NE(refusal("I_DIP_FE", "follows: I_PIP_FE, ratio: 101").find("joints[7].ratio: 101 must be at most 100"),
            std::string::npos);
  EXPECT_NE(refusal("I_DIP_FE", "follows: I_PIP_FE, offset: 3").find("no range of 'I_PIP_FE' keeps what follows it"),
            std::string::npos);
  EXPECT_NE(refusal("I_DIP_FE", "ratio: 0.7").find("joints[7].ratio: is of a joint that follows another one"),
            std::string::npos);
  EXPECT_NE(refusal("I_DIP_FE", "offset: 0.7").find("joints[7].offset: is of a joint that follows another one"),
            std::string::npos);
}

// The posture of a scene has an angle for each joint that turns by itself, and the finger's range is that of both.
TEST(CoupledHandFile, ASceneHasNoAngleForIt) {
  const std::string hand = "hand.model=" + hand_with("I_DIP_FE", "follows: I_PIP_FE, ratio: 2").string();
  const auto with = [&](const std::string& posture) { return scene_of("minimal", {hand, "hand.posture=" + posture}); };
  const Scene scene = with("[0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0.7 rad, 0 rad, 0 rad, 0 rad, 0 rad]");
  EXPECT_EQ(scene.posture.size(), 11);
  const auto said = [&](const std::string& posture) -> std::string {
    try {
      (void)with(posture);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(said("[0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0.7 rad, 1.4 rad, 0 rad, 0 rad, 0 rad, 0 rad]"),
            "--set hand.posture: must be a list of 11 values, one for each joint, not 12");
  EXPECT_NE(said("[0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0 rad, 0.8 rad, 0 rad, 0 rad, 0 rad, 0 rad]")
                .find("(I_PIP_FE) is 0.8 rad and must lie within 0 .. 0.7854 rad, 0 .. 45 deg"),
            std::string::npos);
}

}  // namespace
}  // namespace thenar::coupled_hand_file_test
