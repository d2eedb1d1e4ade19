// SPDX-License-Identifier: Apache-2.0
// The picture of a grasp: whatever the number of fingers, all panels lie in the picture, and none on another; nor does
// a force's label on another's.

#include "engine/figures/grasp_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "engine/grasp/state.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::grasp_picture_test {
namespace {

/// A panel, in shares of the picture's width and height, from its lower left corner.
struct Panel {
  double left, right, bottom, top;
};

std::vector<Panel> panels(const std::string& script) {
  std::vector<Panel> found;
  const std::regex margin("set ([lrbt])margin at screen ([0-9.]+)");
  for (std::sregex_iterator i(script.begin(), script.end(), margin), end; i != end; ++i) {
    const char side = (*i)[1].str().front();
    const double place = std::stod((*i)[2]);
    if (side == 'l') found.push_back({place, 0.0, 0.0, 0.0});
    if (found.empty()) continue;
    if (side == 'r') found.back().right = place;
    if (side == 'b') found.back().bottom = place;
    if (side == 't') found.back().top = place;
  }
  return found;
}

/// The middles of the forces' labels [mm].
std::vector<Eigen::Vector2d> labels(const std::string& script) {
  const std::string begin = "$forces << EOD\n";
  const std::size_t from = script.find(begin) + begin.size();
  std::istringstream lines(script.substr(from, script.find("EOD", from) - from));
  std::vector<Eigen::Vector2d> found;
  double x = 0.0, y = 0.0, dx = 0.0, dy = 0.0;
  std::string text;
  for (Eigen::Vector2d label; lines >> x >> y >> dx >> dy >> label.x() >> label.y() && std::getline(lines, text);) {
    found.push_back(label);
  }
  return found;
}

void expect_clear(const std::vector<Eigen::Vector2d>& labels) {
  // A label is 19 mm wide and 5.5 mm high; its place is written to a thousandth.
  constexpr double kWide = 19.0 - 2e-3, kHigh = 5.5 - 2e-3;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector2d apart = (labels[i] - labels[j]).cwiseAbs();
      EXPECT_TRUE(apart.x() >= kWide || apart.y() >= kHigh)
          << labels[i].transpose() << " lies on " << labels[j].transpose();
    }
  }
}

// What lies 5.5 mm below -30.3 mm is, rounded, less than 5.5 mm away from it: looking for a place must end there, too.
TEST(GraspPicture, HasLabelsThatAreClearOfEachOther) {
  const Model model = build_model(scene_of("minimal", {"object.points=1000"}));
  std::mt19937_64 random(1);
  for (int i = 0; i < 40; ++i) {
    State state(model);
    // Every other time all forces are the same.
    const Eigen::Vector3d middle_m = 1e-3 * (i - 30) * Eigen::Vector3d::Ones();
    for (FingerLoad& load : state.load) {
      load.normal_N = 1.0;
      load.force_N = i % 2 == 0 ? Eigen::Vector3d::UnitZ() : random_direction(random);
      load.centre_m = middle_m + (i % 2 == 0 ? 0.0 : 10e-3) * random_direction(random);
    }
    const std::vector<Eigen::Vector2d> all = labels(grasp_picture_script(model, state));
    ASSERT_EQ(all.size(), static_cast<std::size_t>(model.fingers()));
    expect_clear(all);
  }
}

TEST(GraspPicture, HasRoomForAllFingers) {
  // A caption stands above its panel: 13 points in 700 pixels, and half as much to breathe.
  constexpr double kCaption = 20.0 / 700.0;
  for (const char* name : {"box_grasp", "leap_carry", "human5_carry"}) {
    const Model model = build_model(scene_of(name, {}));
    const std::vector<Panel> all = panels(grasp_picture_script(model, State(model)));
    ASSERT_EQ(all.size(), 1U + model.scene.hand.fingertips.size()) << name;
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_GE(all[i].left, 0.0) << name << i;
      EXPECT_LE(all[i].right, 1.0) << name << i;
      EXPECT_GE(all[i].bottom, 0.0) << name << i;
      EXPECT_LE(all[i].top + (i == 0 ? 0.0 : kCaption), 1.0) << name << i;
      for (std::size_t j = 0; j < i; ++j) {
        const double over_x = std::min(all[i].right, all[j].right) - std::max(all[i].left, all[j].left);
        const double over_y = std::min(all[i].top, all[j].top) + kCaption - std::max(all[i].bottom, all[j].bottom);
        EXPECT_TRUE(over_x <= 0.0 || over_y <= 0.0) << name << ": " << i << " lies on " << j;
      }
    }
  }
}

}  // namespace
}  // namespace thenar::grasp_picture_test
