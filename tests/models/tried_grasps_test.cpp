// SPDX-License-Identifier: Apache-2.0
// Grasps that are tried before they are offered, and fingers that settle: engine/finder/rehearse.h and settle.h, on
// models of scenes.

#include <gtest/gtest.h>

#include "engine/control/control_tick.h"
#include "engine/finder/rehearse.h"
#include "engine/finder/settle.h"
#include "engine/grasp/contact_tick.h"
#include "engine/models/build_model.h"
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

// Muscles that are too weak to hold it are named, with what they lack; joint torques would hold it.
TEST(Rehearse, NamesMusclesThatAreTooWeak) {
  Model model = box_model({"task={}"});
  for (Muscle& muscle : model.scene.hand.muscles) muscle.max_force_N = 0.05;
  const FoundGrasp grasp = grasp_that_goes(model.scene.object.X_WO.linear().col(1));
  const Rehearsal weak = rehearse(model, grasp);
  EXPECT_FALSE(weak.held());
  EXPECT_NE(weak.weakness.find("N beyond its limit"), std::string::npos) << weak.trouble << ": " << weak.weakness;
  // It is what the grasp takes, of which the real muscles give more, and not what a lost one would.
  const std::string before = "would have to pull with at least ";
  for (std::size_t at = weak.weakness.find(before); at != std::string::npos; at = weak.weakness.find(before, at + 1)) {
    EXPECT_LT(std::stod(weak.weakness.substr(at + before.size())), 60.0) << weak.weakness;
  }
  model.scene.control->muscles.reset();
  const Rehearsal by_torques = rehearse(model, grasp);
  EXPECT_TRUE(by_torques.held()) << by_torques.trouble;
  EXPECT_EQ(by_torques.weakness, "");
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
  ContactMemory memory(model);
  ContactScratch work(model);
  const ControlReport report = control_tick(model, state, controller, frame);
  (void)contact_tick(model, frame, memory, work, state);
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
  ASSERT_TRUE(settled.start);
  // What a run begins with is what its fingers carry: the controller knows of it from the first tick on.
  const State state(settled);
  for (int k = 0; k < settled.fingers(); ++k) EXPECT_GT(state.load[k].normal_N, 0.0);
}

/// The largest force of a muscle as a share of its limit, in some of the first ticks of a run.
double muscle_share(const Model& model, int from, int to) {
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  double share = 0.0;
  for (int tick = 0; tick < to; ++tick) {
    (void)control_tick(model, state, controller, frame);
    (void)contact_tick(model, frame, memory, work, state);
    if (tick < from) continue;
    for (Eigen::Index m = 0; m < controller.f_muscle.size(); ++m) {
      share =
          std::max(share, controller.f_muscle[m] / model.scene.hand.muscles[static_cast<std::size_t>(m)].max_force_N);
    }
  }
  return share;
}

// An object at rest asks the same of the muscles in every tick. What settle() leaves, 0.2 % of the load, the
// controller's force loop raises to some percent of a torque; pulps that began without tangential load asked for more
// than half as much again.
TEST(Settle, MakesTheFirstTickLikeTheHundredth) {
  const Model model = box_model({"hand.settle=true", "task={}"});
  const double later = muscle_share(model, 100, 120);
  EXPECT_NEAR(muscle_share(model, 0, 10), later, 0.1 * later);
  EXPECT_GT(std::abs(muscle_share(box_model({"task={}"}), 0, 10) / later - 1.0), 0.2) << "as it is without";
}

// The pulps begin with the whole force that is asked of them, in all directions, and the object stays where it is.
TEST(Settle, BeginsWithWhatCarriesTheWeight) {
  const Model model = box_model({"hand.settle=true", "task={}"});
  State state(model);
  Controller controller(model);
  Frame frame(model);
  const ControlReport report = control_tick(model, state, controller, frame);
  const PerFinger<FingerLoad> loads = first_loads(model, frame);
  double tangential_N = 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    const Vector3d off_N = report.f_desired.col(k) - loads[k].force_N;
    EXPECT_LT(off_N.norm(), 0.004 * loads[k].normal_N)
        << k << ": two bounds of what is left, the posture's and the shear's";
    tangential_N += (loads[k].force_N - loads[k].normal * loads[k].normal.dot(loads[k].force_N)).norm();
  }
  EXPECT_GT(tangential_N, 0.5 * model.scene.object.mass_kg * model.scene.gravity.norm());
}

TEST(Settle, IsNothingToScenesThatDoNotAskForIt) {
  const Model model = box_model();
  EXPECT_FALSE(model.start);
  EXPECT_EQ(State(model).load[0].normal_N, 0.0);
}

}  // namespace
}  // namespace thenar::tried_grasps_test
