// Grasps that are tried before they are offered, and fingers that settle: engine/finder/rehearse.h and settle.h, on
// models of scenes.

#include <gtest/gtest.h>

#include "engine/finder/rehearse.h"
#include "engine/finder/settle.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/control_tick.h"
#include "engine/scenes/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::tried_grasps_test {
namespace {

using Eigen::Vector3d;

Model box_model(const std::vector<std::string>& changes = {}) {
  std::vector<std::string> all{"object.points=6000"};
  all.insert(all.end(), changes.begin(), changes.end());
  return build_model(scene_of("box_grasp", all));
}

/// A grasp of which nothing is known but the way it is to go.
FoundGrasp grasp_that_goes(const Vector3d& way_W) {
  FoundGrasp grasp;
  grasp.travel_W = way_W;
  return grasp;
}

// The published grasp holds; on ice it does not, and says what happened. The model is lent: it comes back as it was,
// and a second rehearsal gives the same bits.
TEST(Rehearse, TellsWhatHoldsFromWhatDoesNot) {
  Model model = box_model({"task={}"});
  const FoundGrasp grasp = grasp_that_goes(model.scene.object.X_WO.linear().col(1));
  const Rehearsal one = rehearse(model, grasp), two = rehearse(model, grasp);
  EXPECT_TRUE(one.held()) << one.trouble << " after " << one.lasted;
  EXPECT_EQ(one.trouble, "");
  EXPECT_GT(one.muscle_share, 0.0);
  EXPECT_EQ(one.muscle_share, two.muscle_share);
  EXPECT_EQ(model.scene.step_s, 1e-3);
  EXPECT_FALSE(model.scene.task.translate);

  model.scene.contact.friction = 0.1;
  const Rehearsal ice = rehearse(model, grasp);
  EXPECT_FALSE(ice.held());
  EXPECT_LT(ice.lasted, 1.0);
  EXPECT_FALSE(ice.trouble.empty());
}

// The scene's own task is what is rehearsed, where it has one: a push that no grasp bears ends it.
TEST(Rehearse, RunsTheTaskOfTheScene) {
  Model model = box_model({"task.push={force: [0 N, 60 N, 0 N], at: [0 mm, 0 mm, 0 mm], from: 1.2 s, over: 1 s}"});
  const Rehearsal pushed = rehearse(model, grasp_that_goes(Vector3d::UnitX()));
  EXPECT_FALSE(pushed.held());
  EXPECT_GT(pushed.lasted, 1.2 / 2.5 - 0.01);
}

/// The largest share by which a finger's load is off what it is asked for, after the first tick.
double first_miss(const Model& model) {
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactWorkspace work(model);
  const ControlReport report = control_tick(model, state, controller, frame);
  (void)contact_tick(model, frame, work, state);
  double worst = 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    const Vector3d n = report.contacts[k].axes.col(0);
    worst = std::max(worst, std::abs(1.0 - state.load[k].normal_N / n.dot(report.f_desired.col(k))));
  }
  return worst;
}

// Fingers of which one is 1 mm off, which is most of its load, press at the first tick with what they are asked for,
// within what settle() leaves, 0.5 %, and the little that bodies move in a tick.
TEST(Settle, MendsAPostureByHand) {
  const std::string off =
      "hand.posture=[0.0863 rad, 0.2539 rad, -0.1260 rad, 0.6359 rad, 0.2484 rad, -0.0424 rad, 0.5342 rad, 0.56 rad, "
      "0.4201 rad, -0.0783 rad, 0.5537 rad, 0.5189 rad]";
  EXPECT_GT(first_miss(box_model({off})), 0.2);
  const Model settled = box_model({off, "hand.settle=true"});
  EXPECT_LT(first_miss(settled), 0.02);
  ASSERT_TRUE(settled.start_load);
  // What a run begins with is what its fingers carry: the controller knows of it from the first tick on.
  const State state(settled);
  for (int k = 0; k < settled.fingers(); ++k) EXPECT_GT(state.load[k].normal_N, 0.0);
}

TEST(Settle, IsNothingToScenesThatDoNotAskForIt) {
  const Model model = box_model();
  EXPECT_FALSE(model.start_load);
  EXPECT_EQ(State(model).load[0].normal_N, 0.0);
}

}  // namespace
}  // namespace thenar::tried_grasps_test
