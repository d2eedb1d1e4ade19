// SPDX-License-Identifier: Apache-2.0
// `thenar check`.

#include <gtest/gtest.h>

#include <string>

#include "tests/support/program.h"

namespace thenar::check_test {
namespace {

TEST(Program, ChecksAScene) {
  const ProgramResult check = thenar_program("check " + config("minimal.yaml"));
  EXPECT_EQ(check.code, 0);
  EXPECT_NE(check.text.find("rigid, one contact point each"), std::string::npos);
  EXPECT_NE(check.text.find("muscles (control.muscles)"), std::string::npos) << "left out";
  const std::string box = thenar_program("check " + config("box_grasp.yaml")).text;
  EXPECT_NE(box.find("23 muscles"), std::string::npos);
  EXPECT_EQ(box.find("what becomes of the grasp"), std::string::npos) << "nothing is run unasked";
  EXPECT_NE(box.find("--parts"), std::string::npos) << box;
}

TEST(Program, ChecksWhatStiffnessThereIs) {
  const std::string title = "stiffness of the object that muscles can give it at 0.3 s";
  const std::string coarse = " --set object.points=6000";
  const std::string stiff = thenar_program("check " + config("box_stiff.yaml") + coarse).text;
  EXPECT_NE(stiff.find(title), std::string::npos) << stiff;
  EXPECT_NE(stiff.find("along all directions up to "), std::string::npos) << stiff;
  EXPECT_NE(stiff.find("of what the scene asks for up to "), std::string::npos) << stiff;
  EXPECT_EQ(stiff.find("the scene asks for more than there is"), std::string::npos) << stiff;
  const std::string more =
      thenar_program("check " + config("box_stiff.yaml") + coarse +
                     " --set 'control.muscles.object_stiffness.translation=[900 N/m, 900 N/m, 900 N/m]'")
          .text;
  EXPECT_NE(more.find("the scene asks for more than there is: "), std::string::npos) << more;
  EXPECT_NE(more.find(" of the object lacks "), std::string::npos) << more;
  const std::string none = thenar_program("check " + config("box_grasp.yaml") + coarse).text;
  EXPECT_EQ(none.find("stiffness of the object"), std::string::npos) << none;
}

TEST(Program, ChecksWhatASceneCouldLeaveOut) {
  const std::string scene = "check --parts " + config("box_grasp.yaml") +
                            " --set object.points=2000 --set 'time.duration=0.4 s' --set 'tolerance={force: 0.5 %}'";
  const std::string check = thenar_program(scene).text;
  const auto line_of = [&](const std::string& part) {
    const std::size_t at = check.find(part, check.find("what its parts cost and give"));
    return at == std::string::npos ? "" : check.substr(at, check.find('\n', at) - at);
  };
  EXPECT_TRUE(line_of("muscles (control.muscles)").ends_with("could be left out")) << check;
  const std::string fingertips = line_of("deformation of the fingertips (fingertips)");
  EXPECT_TRUE(fingertips.ends_with("  needed")) << check;
  EXPECT_NE(fingertips.find(" .. "), std::string::npos) << "an interval with each median: " << check;
  EXPECT_NE(check.find("model: auto would leave out"), std::string::npos) << check;
  EXPECT_NE(thenar_program(scene + " --set contact.friction=0.1").text.find("what becomes of the grasp\n  lost: "),
            std::string::npos);
}

TEST(Program, ChecksWhatTwoLoopsMakeOfAScene) {
  const std::string stick = thenar_program("check " + config("stick.yaml")).text;
  EXPECT_NE(stick.find("closer than 0.3 mm, or that may come so close"), std::string::npos) << stick;
  EXPECT_NE(stick.find("spring of 500 N/m and 0.5 N m/rad"), std::string::npos) << stick;
  EXPECT_EQ(stick.find("control_delay)"), std::string::npos) << stick;
  const std::string late = thenar_program("check " + config("stick.yaml") + " --set 'time.control_delay=5 ms'").text;
  EXPECT_NE(late.find("5 ms after their snapshot"), std::string::npos) << late;
}

TEST(Program, ChecksWhatIsAroundAnObject) {
  const std::string rest = thenar_program("check " + config("resting_box.yaml")).text;
  EXPECT_NE(rest.find("environment     slope: a plane at [300, 0, 0] mm, friction 0.3\n"), std::string::npos) << rest;
  EXPECT_NE(rest.find("gives way to the object by 0.1 um/N"), std::string::npos) << rest;
  const std::string hole = thenar_program("check " + config("resting_box.yaml") +
                                          " --set 'environment.bodies=[{shape: {hole: {diameter: 20 mm, depth: 30 mm, "
                                          "chamfer: 2 mm}}, position: [0 mm, 0 mm, -9 mm]}]'")
                               .text;
  EXPECT_NE(hole.find("1: a plane with a hole of 20 mm, 30 mm deep, chamfer 2 mm at [0, 0, -9] mm"), std::string::npos)
      << hole;
}

TEST(Program, ChecksFingertipsOnSlides) {
  const std::string ball = thenar_program("check " + config("slides_ball.yaml")).text;
  EXPECT_NE(ball.find("hand            none: fingertips on slides, no inertia\n"), std::string::npos) << ball;
  EXPECT_NE(ball.find("slides          tip1: radius 8 mm, from [31.15, 0, 0] mm along [-1, 0, 0], by 2 N; damping 10 N "
                      "s/m, range -1000 .. 1000 mm\n"),
            std::string::npos)
      << ball;
  EXPECT_EQ(ball.find("N m s"), std::string::npos) << ball;
  const std::string others =
      thenar_program("check " + config("slides_ball.yaml") +
                     " --set 'hand.slides=[{at: [31 mm, 0 mm, 0 mm], along: [-1, 0, 0], radius: 8 mm, spring: "
                     "{stiffness: 1 N/mm, rest: 2 mm}}, {at: [-31 mm, 0 mm, 0 mm], along: [1, 0, 0], radius: 8 mm, "
                     "path: [{by: [1 mm, 0 mm, 0 mm], over: 1 s}, {by: [0 mm, 3 mm, 0 mm], over: 2 s}]}]'")
          .text;
  EXPECT_NE(others.find("by a spring of 1000 N/m at rest 2 mm along it"), std::string::npos) << others;
  EXPECT_NE(others.find("tip2: radius 8 mm, from [-31, 0, 0] mm on a path to [-30, 3, 0] mm in 3 s, whatever resists"),
            std::string::npos)
      << others;
}

// What looks for a grasp of a hand says that there is none.
TEST(Program, FindsNoGraspForFingertipsOnSlides) {
  const ProgramResult grasp = thenar_program("grasp " + config("slides_ball.yaml"));
  EXPECT_EQ(grasp.code, 2);
  EXPECT_NE(grasp.text.find("slides_ball.yaml: hand.slides: are no hand to find a grasp for"), std::string::npos)
      << grasp.text;
}

}  // namespace
}  // namespace thenar::check_test
