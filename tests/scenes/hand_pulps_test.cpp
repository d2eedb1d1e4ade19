// SPDX-License-Identifier: Apache-2.0
// Pulps in a hand file: spheres, ellipsoids and capsules, and what is refused.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::hand_pulps_test {
namespace {

using Eigen::Vector3d;

constexpr const char* kRadius = "radius: 0.0080,";

/// configs/hand.yaml with other words for the index's pulp, or for others.
std::filesystem::path hand_with(const std::string& words, const std::string& in_place_of = kRadius) {
  std::ifstream in(config_file("hand"));
  std::stringstream all;
  all << in.rdbuf();
  std::string text = all.str();
  text.replace(text.find(in_place_of), in_place_of.size(), words);
  const std::filesystem::path file = scratch() / "hand.yaml";
  std::ofstream(file) << text;
  return file;
}

Fingertip index_with(const std::string& words) { return load_hand(hand_with(words)).fingertips[1]; }

std::string refusal(const std::string& words, const std::string& in_place_of = kRadius) {
  try {
    (void)load_hand(hand_with(words, in_place_of));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

// One word that is wrong is one error, not one of every line that builds on it.
TEST(HandFile, TellsOneFaultOnce) {
  EXPECT_EQ(refusal("finger: index, segment: I_dital", "finger: index, segment: I_distal"),
            (scratch() / "hand.yaml").string() +
                ":31:28: fingertips[1].segment: no segment is named 'I_dital', did you mean 'I_distal'?");
  EXPECT_EQ(refusal("finger: thumb", "finger: index"),
            (scratch() / "hand.yaml").string() + ":31:12: fingertips[1].finger: is there twice: 'thumb'");
  EXPECT_EQ(refusal("name: T_CMC_FE", "name: T_CMC_AA"),
            (scratch() / "hand.yaml").string() + ":8:10: joints[1].name: is there twice: 'T_CMC_FE'");
}

// The first file of a process, too; and what is wrong once is one fault.
TEST(HandFile, IsRefusedForWhatIsWrong) {
  const std::filesystem::path file = scratch() / "empty.yaml";
  std::ofstream(file) << "";
  EXPECT_THROW((void)load_hand(file), ConfigError);
  const std::string said = refusal("segment: T_proximal", "segment: T_distal");
  EXPECT_NE(said.find("fingertips[1].segment: must be moved by"), std::string::npos) << said;
  const std::string both = refusal("{via: {segment: palm, pos: [0, 0, 0]}, dir: {", "{dir: {");
  EXPECT_NE(both.find("only one of via, dir may be given"), std::string::npos) << both;
  EXPECT_EQ(both.find("no segment is named ''"), std::string::npos) << both;
}

TEST(HandPulps, AreSpheresEllipsoidsAndCapsules) {
  const Fingertip sphere = index_with(kRadius);
  EXPECT_FALSE(sphere.shape);
  EXPECT_EQ(sphere.radius_m, 8e-3);

  const Fingertip ellipsoid = index_with("semi_axes: [0.011, 0.008, 0.0065],");
  ASSERT_TRUE(ellipsoid.shape);
  EXPECT_EQ(ellipsoid.shape->form, PulpShape::Form::kEllipsoid);
  EXPECT_EQ(ellipsoid.radius_m, 6.5e-3);
  EXPECT_EQ(ellipsoid.shape->half_m, Vector3d(0.011, 0.008, 0.0065));
  // Through it the pulp's normal; along it the bone's direction, x, as far as that lies across; all right-handed.
  const Eigen::Matrix3d& axes = ellipsoid.shape->axes;
  EXPECT_LE((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-14);
  EXPECT_LE((axes.col(2) - ellipsoid.normal).norm(), 1e-14);
  EXPECT_NEAR(axes.col(0).z(), 0.0, 1e-14);
  EXPECT_GT(axes.col(0).x(), 0.9);

  const Fingertip capsule = index_with("radius: 0.0070, length: 0.012,");
  ASSERT_TRUE(capsule.shape);
  EXPECT_EQ(capsule.shape->form, PulpShape::Form::kCapsule);
  EXPECT_EQ(capsule.shape->half_m, Vector3d(0.006, 0.007, 0.007));
  EXPECT_EQ(capsule.shape->axes.col(0), Vector3d::UnitX()) << "along the bone";
  EXPECT_EQ(capsule.radius_m, 7e-3);

  const Fingertip turned =
      index_with("semi_axes: [0.011, 0.008, 0.0065], pulp_axes: [[0, 0, 1], [1, 0, 0], [0, 1, 0]],");
  EXPECT_EQ(turned.shape->axes.col(0), Vector3d::UnitY());
}

TEST(HandPulps, WhatIsNoPulpIsRefusedAtItsPlace) {
  const auto expect = [](const std::string& words, const std::string& key, const std::string& what) {
    const std::string said = refusal(words);
    EXPECT_NE(said.find("hand.yaml:31:"), std::string::npos) << said;
    EXPECT_NE(said.find("fingertips[1]" + key + ": "), std::string::npos) << said;
    EXPECT_NE(said.find(what), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << "one fault, one line: " << said;
  };
  expect("semi_axes: [0.011, 0, 0.0065],", ".semi_axes[1]", "0 must be at least 1e-4");
  expect("semi_axes: [0.011, -0.008, 0.0065],", ".semi_axes[1]", "must be at least 1e-4");
  expect("semi_axes: [0.011, 0.008],", ".semi_axes", "3");
  expect("semi_axes: [0.05, 0.008, 0.008],", ".semi_axes", "the largest must be at most 4 times the least");
  expect("radius: 0.008, length: -0.01,", ".length", "must be at least 1e-4");
  expect("radius: 0.008, length: 0,", ".length", "must be at least 1e-4");
  expect("radius: 0.008, semi_axes: [0.011, 0.008, 0.0065],", ".radius", "an ellipsoid has semi_axes alone");
  expect("length: 0.01, semi_axes: [0.011, 0.008, 0.0065],", ".length", "an ellipsoid has semi_axes alone");
  expect("length: 0.01,", ".radius", "is missing: a pulp has a radius, or semi_axes");
  expect("", ".radius", "is missing: a pulp has a radius, or semi_axes");
  expect("radius: 0.008, pulp_axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],", ".pulp_axes", "a sphere has no axes");
  expect("radius: 0.008, length: 0.01, pulp_axes: [[1, 0, 0], [0, 1, 0], [0, 0, 2]],", ".pulp_axes", "");
  expect("radius: 0.008, semi_axis: [0.011, 0.008, 0.0065],", ".semi_axis", "semi_axes");
}

}  // namespace
}  // namespace thenar::hand_pulps_test
