// SPDX-License-Identifier: Apache-2.0
// Files of hands that ask for more than they are: of the stack, of memory, of time.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/imports/imported.h"

namespace thenar::import_bounds_test {
namespace {

/// What is said of hand.xml, of this text, beside these files.
std::string refusal_with(const std::vector<std::pair<std::string, std::string>>& files, const std::string& text) {
  const std::filesystem::path folder = scratch();
  for (const auto& [name, inside] : files) std::ofstream(folder / name) << inside;
  std::ofstream(folder / "hand.xml") << text;
  try {
    (void)read_bodies(folder / "hand.xml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(ImportBounds, IsAsDeepAsOneFileMayBe) {
  std::vector<std::pair<std::string, std::string>> chain, frames;
  for (int i = 0; i < 400; ++i) {
    chain.emplace_back("i" + std::to_string(i), "<a><include file='i" + std::to_string(i + 1) + "'/></a>");
  }
  chain.emplace_back("i400", "<a/>");
  EXPECT_NE(refusal_with(chain, "<mujoco><include file='i0'/></mujoco>").find("included files deep"),
            std::string::npos);
  std::string open, close;
  for (int i = 0; i < 150; ++i) {
    open += "<frame>";
    close += "</frame>";
  }
  frames.emplace_back("f0", "<a>" + open + "<include file='f1'/>" + close + "</a>");
  frames.emplace_back("f1", "<a>" + open + close + "</a>");
  const std::string world = "<mujoco><worldbody><body name='a'><include file='f0'/></body></worldbody></mujoco>";
  EXPECT_NE(refusal_with(frames, world).find("included files deep"), std::string::npos);
}

TEST(ImportBounds, AttributesAndDefaultsAreBounded) {
  std::string attributes, classes;
  for (int i = 0; i < 90; ++i) attributes += " a" + std::to_string(i) + "='1'";
  const std::string body = "<worldbody><body name='a'/></worldbody></mujoco>";
  EXPECT_EQ(refusal_with({}, "<mujoco><default><geom" + attributes + "/></default>" + body), "");
  for (int i = 90; i < 200; ++i) attributes += " a" + std::to_string(i) + "='1'";
  EXPECT_NE(refusal_with({}, "<mujoco><default><geom" + attributes + "/></default>" + body)
                .find("has more than 100 attributes"),
            std::string::npos);
  for (int i = 0; i < 20'000; ++i) classes += "<default class='c" + std::to_string(i) + "'><geom/></default>";
  EXPECT_NE(refusal_with({}, "<mujoco><default>" + classes + "</default>" + body)
                .find("is beyond 10000 elements of defaults"),
            std::string::npos);
  // One section after the other adds to the same class.
  std::string sections;
  for (int i = 0; i < 150; ++i) sections += "<default><geom b" + std::to_string(i) + "='1'/></default>";
  EXPECT_NE(refusal_with({}, "<mujoco>" + sections + body).find("has more than 100 attributes"), std::string::npos);
}

// A class has what the enclosing one had where it stands, also where that goes on in another section.
TEST(ImportBounds, ClassesInheritWhatIsThereWhereTheyStand) {
  const std::string text =
      "<mujoco><compiler angle='radian'/><default><joint range='0 1'/><default class='c'><geom size='0.007'/></default>"
      "</default><default><joint range='0 2'/></default><worldbody><body name='a'><body name='b'>"
      "<joint name='by_c' class='c'/><joint name='by_main'/></body></body></worldbody></mujoco>";
  const std::filesystem::path file = scratch() / "hand.xml";
  std::ofstream(file) << text;
  const BodyTree tree = read_bodies(file);
  const std::vector<TreeJoint>& joints = tree.bodies.back().joints;
  ASSERT_EQ(joints.size(), 2U);
  EXPECT_EQ((*joints[0].range)[1], 1.0);
  EXPECT_EQ((*joints[1].range)[1], 2.0);
}

}  // namespace
}  // namespace thenar::import_bounds_test
