// The picture of a grasp: whatever the number of fingers, all of it lies in the picture, and nothing on anything else.

#include "engine/results/grasp_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <string>
#include <vector>

#include "engine/grasp/state.h"
#include "engine/scenes/build_model.h"
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
