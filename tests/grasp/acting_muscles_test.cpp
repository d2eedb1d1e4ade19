// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/acting_muscles.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::acting_muscles_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDrag = 1e5;  // [N m s] So much that joints turn by less than 1e-7 rad in a tick.

/// The hand of box_grasp with the object out of its reach, driven by a table of muscle forces: rows of a time and one
/// force a muscle.
Scene free_hand(const std::string& muscles, const std::vector<std::pair<double, VectorXd>>& table,
                double viscosity_Nms = kDrag, const std::vector<std::string>& more = {}) {
  std::vector<std::string> changes = {kCoarseBox, "fingertips.leaves=80", "object.position=[500 mm, 400 mm, 0 mm]",
                                      "control.muscles=" + muscles, "control.gain=1 N*m/rad"};
  changes.insert(changes.end(), more.begin(), more.end());
  Scene scene = scene_of("box_grasp", changes);
  scene.joint_viscosity = viscosity_Nms;
  DriveTable drive;
  drive.muscles = true;
  drive.time_s.resize(std::ssize(table));
  drive.values.resize(std::ssize(scene.hand.muscles), std::ssize(table));
  for (std::size_t i = 0; i < table.size(); ++i) {
    drive.time_s[static_cast<Index>(i)] = table[i].first;
    drive.values.col(static_cast<Index>(i)) = table[i].second;
  }
  scene.control->drive = drive;
  return scene;
}

HandPose pose_at(const Hand& hand, const JointVector& q) {
  HandPose pose;
  forward_kinematics(hand, q, pose);
  return pose;
}

/// H = -dl/dq by central differences of the tendons' lengths: to 1e-10 of arms of 10 mm.
MatrixXd arms(const Hand& hand, const JointVector& q) {
  constexpr double h = 1e-5;
  MatrixXd H(q.size(), std::ssize(hand.muscles));
  for (Index i = 0; i < q.size(); ++i) {
    const JointVector step = h * JointVector::Unit(q.size(), i);
    H.row(i) =
        (muscle_lengths(hand, pose_at(hand, q - step)) - muscle_lengths(hand, pose_at(hand, q + step))) / (2.0 * h);
  }
  return H;
}

Index index_of(const Hand& hand, const std::string& name) {
  return std::ranges::find(hand.muscles, name, &Muscle::name) - hand.muscles.begin();
}

VectorXd random_forces(const Hand& hand, double most_N, std::mt19937_64& random) {
  VectorXd f(std::ssize(hand.muscles));
  for (double& f_m : f) f_m = uniform(random, 0.05, 1.0) * most_N;
  f[index_of(hand, "EDC")] = 0.0;  // It is on two fingers, whose bellies pull with different forces.
  return f;
}

/// Fingers turned by up to so much from where their muscles are at rest.
void turn_fingers(GraspRun& run, double most_rad, std::mt19937_64& random) {
  for (Index i = 0; i < run.state.q.size(); ++i) {
    const Joint& joint = run.model.scene.hand.joints[static_cast<std::size_t>(i)];
    run.state.q[i] = std::clamp(run.state.q[i] + uniform(random, -most_rad, most_rad), joint.lower_rad + 0.02,
                                joint.upper_rad - 0.02);
  }
}

/// The largest difference between b dq/dt and H(q) pulls + weight in a tick, over the largest such torque.
double balance_error(GraspRun& run) {
  const Hand& hand = run.model.scene.hand;
  const JointVector before = run.state.q;
  run.tick();
  const VectorXd drag = run.model.scene.joint_viscosity * (run.state.q - before) / run.model.scene.step_s;
  const VectorXd weight = gravity_torques(hand, pose_at(hand, run.state.q), run.model.scene.gravity);
  const VectorXd tau = arms(hand, run.state.q) * run.state.pull_N - weight;
  return (drag - tau).cwiseAbs().maxCoeff() / tau.cwiseAbs().maxCoeff();
}

// What pulls is what moves a free finger: b dq/dt = H f - g, with H by differences, while activations rise and fall,
// and with fibres stretched by what a push of the fingers leaves, within their range and far beyond it. Between frames
// joints turn by less than 2e-7 rad, and arms change by about as much of themselves.
TEST(ActingMuscles, DriveTheFingersWithTheForcesThatAreTold) {
  std::mt19937_64 random(3);
  const Hand hand = scene_of("box_grasp").hand;
  for (const std::string muscles : {"true", "{activation: 12 ms, deactivation: 45 ms}", "{stiffness: 23.4}",
                                    "{stiffness: 23.4, activation: 12 ms, deactivation: 45 ms}"}) {
    for (const double turn_rad : {0.0, 0.03, 0.4}) {
      for (const char* period : {"1 ms", "4 ms"}) {
        SCOPED_TRACE(muscles + " " + std::to_string(turn_rad) + " " + period);
        const VectorXd low = random_forces(hand, 10.0, random), high = random_forces(hand, 40.0, random);
        const Model model = build_model(
            free_hand(muscles, {{0.0, low}, {0.004, low}, {0.0041, high}, {0.012, high}, {0.0121, low}, {1.0, low}},
                      kDrag, {std::string("time.control_period=") + period}));
        GraspRun run(model);
        turn_fingers(run, turn_rad, random);
        for (int tick = 0; tick < 24; ++tick) {
          ASSERT_LE(balance_error(run), 1e-6) << tick;
          ASSERT_GE(run.state.pull_N.minCoeff(), 0.0) << tick;
        }
      }
    }
  }
}

/// The force with which one muscle alone drives a finger, from the joint that it turns with the longest arm. Nothing
/// else acts.
double force_by_motion(GraspRun& run, Index muscle) {
  const JointVector before = run.state.q;
  run.tick();
  const VectorXd h = arms(run.model.scene.hand, run.state.q).col(muscle);
  Index joint = 0;
  h.cwiseAbs().maxCoeff(&joint);
  return run.model.scene.joint_viscosity * (run.state.q[joint] - before[joint]) / run.model.scene.step_s / h[joint];
}

// Each muscle by itself: up and down again by half of its largest force.
TEST(ActingMuscles, EachPullsWithTheForceThatIsTold) {
  const Hand hand = scene_of("box_grasp").hand;
  for (Index m = 0; m < std::ssize(hand.muscles); ++m) {
    SCOPED_TRACE(hand.muscles[m].name);
    const VectorXd low = VectorXd::Unit(std::ssize(hand.muscles), m), high = 0.5 * hand.muscles[m].max_force_N * low;
    const Model model =
        build_model(free_hand("{activation: 12 ms, deactivation: 45 ms}",
                              {{0.0, low}, {0.003, low}, {0.0031, high}, {0.01, high}, {0.0101, low}, {1.0, low}},
                              kDrag, {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}));
    GraspRun run(model);
    double most_N = 0.0, off_asked_N = 0.0;
    for (int tick = 0; tick < 16; ++tick) {
      const double force_N = force_by_motion(run, m);
      EXPECT_NEAR(run.state.pull_N[m], force_N, 1e-6 * force_N) << tick;
      most_N = std::max(most_N, force_N);
      off_asked_N = std::max(off_asked_N, std::abs(force_N - run.controller.f_muscle[m]));
    }
    // Far from what is asked for, at some time: that would not do.
    EXPECT_GT(off_asked_N, 0.3 * most_N);
  }
}

// A muscle on two fingers has two bellies, which are stretched differently and pull differently. What is told is their
// sum; half of it is the mean of the forces that each finger by itself speaks of.
TEST(ActingMuscles, OfASharedOneTheSumOfItsBelliesIsTold) {
  const Hand hand = scene_of("box_grasp").hand;
  const Index m = index_of(hand, "EDC");
  const VectorXd f = 20.0 * VectorXd::Unit(std::ssize(hand.muscles), m);
  const Model model =
      build_model(free_hand("{stiffness: 23.4}", {{0.0, f}, {1.0, f}}, kDrag, {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}));
  GraspRun run(model);
  for (const int joint : {hand.fingertips[1].first_joint, hand.fingertips[2].first_joint}) {
    run.state.q[joint + 1] += joint == hand.fingertips[1].first_joint ? 0.1 : -0.05;
  }
  const JointVector before = run.state.q;
  run.tick();
  const VectorXd h = arms(hand, run.state.q).col(m);
  const VectorXd tau = kDrag * (run.state.q - before) / model.scene.step_s;
  std::vector<double> each_N;
  for (const int k : {1, 2}) {
    const Fingertip& tip = hand.fingertips[k];
    const VectorXd own = h.segment(tip.first_joint, tip.joints);
    each_N.push_back(own.dot(tau.segment(tip.first_joint, tip.joints)) / own.squaredNorm());
  }
  EXPECT_GT(std::abs(each_N[0] - each_N[1]), 0.1) << "far more than what is told may be off";
  EXPECT_NEAR(run.state.pull_N[m], 0.5 * (each_N[0] + each_N[1]), 1e-6 * 20.0);
}

// Within their range fibres add gamma / L dl (with their tendon) to f; beyond it their force stays at f (1 + gamma r)
// lengthened, at f (1 - gamma r) shortened, and nothing pushes. Arms change over so long a way: what is exact is the
// law in the stretch by the arms at the state, from which the tick is told to 1e-6.
TEST(ActingMuscles, YieldBeyondTheRangeOfTheirStiffness) {
  const Hand hand = scene_of("box_grasp").hand;
  for (const auto& [range, most, least] :
       {std::tuple{"2 %", 0.468, 0.468}, {"1 %", 0.234, 0.234}, {"6 %", 1.404, 1.0}}) {
    int lengthened = 0, shortened = 0, within = 0;
    for (Index m = 0; m < std::ssize(hand.muscles); ++m) {
      if (hand.muscles[m].name == "EDC") continue;
      const VectorXd f = 10.0 * VectorXd::Unit(std::ssize(hand.muscles), m);
      const Model model = build_model(free_hand(std::string("{stiffness: 23.4, range: ") + range + "}",
                                                {{0.0, f}, {1.0, f}}, kDrag, {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}));
      for (const double turn_rad : {-0.6, -0.15, 0.0, 0.15, 0.6}) {
        SCOPED_TRACE(hand.muscles[m].name + " " + range + " " + std::to_string(turn_rad));
        GraspRun run(model);
        const VectorXd h_rest = arms(hand, run.state.q).col(m);
        Index joint = 0;
        h_rest.cwiseAbs().maxCoeff(&joint);
        const Joint& turned = hand.joints[static_cast<std::size_t>(joint)];  // Short of its stops, which would push.
        run.state.q[joint] =
            std::clamp(run.state.q[joint] + turn_rad, turned.lower_rad + 1e-3, turned.upper_rad - 1e-3);
        const double dl = -arms(hand, run.state.q).col(m).dot(run.state.q - model.scene.posture);
        const double elastic_N = dl / (*hand.muscles[m].fibre_m / (23.4 * 10.0) + 1.0 / hand.muscles[m].tendon_N_per_m);
        const double expected_N = 10.0 + std::clamp(elastic_N, -10.0 * least, 10.0 * most);
        const double force_N = force_by_motion(run, m);
        EXPECT_NEAR(force_N, expected_N, 1e-5);
        EXPECT_NEAR(run.state.pull_N[m], expected_N, 1e-5);
        (elastic_N > 10.0 * most ? lengthened : elastic_N < -10.0 * least ? shortened : within) += 1;
      }
    }
    EXPECT_GT(lengthened, 5);
    EXPECT_GT(shortened, 5);
    EXPECT_GT(within, 20);
  }
}

// With the drag of a hand, the tick is implicit in the stiffness, which fibres that yield no longer have: a finger that
// turns by 5 mrad in a tick is moved by the force that is told, f (1 + gamma r), and not by what the stiffness would
// have taken off it, 6 % of it. Arms change by as much as the joints turn, 1 %.
TEST(ActingMuscles, HaveNoStiffnessWhereTheyYield) {
  const Hand hand = scene_of("box_grasp").hand;
  const Index m = index_of(hand, "FDPI");
  const VectorXd f = 10.0 * VectorXd::Unit(std::ssize(hand.muscles), m);
  const Model model =
      build_model(free_hand("{stiffness: 23.4}", {{0.0, f}, {1.0, f}}, 0.05, {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}));
  GraspRun run(model);
  const Fingertip& tip = hand.fingertips[1];
  for (int j = 1; j < tip.joints; ++j) {  // Extended, short of the stops: the flexor is lengthened.
    const auto joint = static_cast<std::size_t>(tip.first_joint + j);
    run.state.q[tip.first_joint + j] =
        std::max(run.state.q[tip.first_joint + j] - 0.3, hand.joints[joint].lower_rad + 0.02);
  }
  for (int tick = 0; tick < 10; ++tick) {
    const JointVector before = run.state.q;
    run.tick();
    EXPECT_DOUBLE_EQ(run.state.pull_N[m], 14.68);
    const VectorXd tau = 14.68 * arms(hand, run.state.q).col(m);
    const VectorXd drag = 0.05 * (run.state.q - before) / model.scene.step_s;
    EXPECT_LE((drag - tau).norm(), 0.01 * tau.norm());
  }
}

// First law: what the muscles do on the way, their pulls times what their tendons shorten by, is what the joints' drag
// takes. Nothing else is there. The tick is of first order, and a way of many ticks has an error of that order.
TEST(ActingMuscles, DoTheWorkThatTheDragTakes) {
  const Hand hand = scene_of("box_grasp").hand;
  std::mt19937_64 random(5);
  const VectorXd low = random_forces(hand, 4.0, random), high = random_forces(hand, 30.0, random);
  const Model model =
      build_model(free_hand("{stiffness: 23.4, activation: 12 ms, deactivation: 45 ms}",
                            {{0.0, low}, {0.02, low}, {0.021, high}, {0.08, high}, {0.081, low}, {1.0, low}}, 5.0,
                            {"gravity=[0 m/s^2, 0 m/s^2, 0 m/s^2]"}));
  GraspRun run(model);
  turn_fingers(run, 0.2, random);
  double work_J = 0.0, taken_J = 0.0, booked_J = 0.0, asked_J = 0.0;
  for (int tick = 0; tick < 200; ++tick) {
    const JointVector before = run.state.q;
    booked_J += run.tick().ledger.drive_J;
    const VectorXd shorter_m =
        muscle_lengths(hand, pose_at(hand, before)) - muscle_lengths(hand, pose_at(hand, run.state.q));
    work_J += run.state.pull_N.dot(shorter_m);
    asked_J += run.controller.f_muscle.dot(shorter_m);
    taken_J += 5.0 * (run.state.q - before).squaredNorm() / model.scene.step_s;
  }
  EXPECT_GT(taken_J, 1e-3);
  EXPECT_NEAR(work_J, taken_J, 1e-3 * taken_J);
  EXPECT_NEAR(booked_J, taken_J, 1e-9 * taken_J);
  EXPECT_GT(std::abs(asked_J - taken_J), 0.1 * taken_J);  // The forces asked for do another work.
}

// A range that nothing leaves changes no bit.
TEST(ActingMuscles, ThatStayWithinTheirRangeAreAsThoughItHadNoEnd) {
  std::vector<State> ends;
  for (const std::string range : {"2 %", "100 %"}) {
    Scene scene = scene_of("box_cocontract", {kCoarseBox, "control.muscles.frozen_from=50 ms",
                                              "control.muscles.range=" + range, "task.push.from=60 ms"});
    const Model model = build_model(scene);
    GraspRun run(model);
    for (int tick = 0; tick < 150; ++tick) ASSERT_EQ(run.tick().yielded.muscles, 0U) << tick;
    ends.push_back(run.state);
  }
  EXPECT_EQ(ends[0].q, ends[1].q);
  EXPECT_EQ(ends[0].X_WO.matrix(), ends[1].X_WO.matrix());
  EXPECT_EQ(ends[0].pull_N, ends[1].pull_N);
}

TEST(ActingMuscles, AreToldWithoutAllocation) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours to count";
  const VectorXd f = VectorXd::Constant(23, 10.0);
  const Model model = build_model(free_hand("{stiffness: 23.4, activation: 10 ms}", {{0.0, f}, {1.0, f}}, 0.05));
  GraspRun run(model);
  for (int tick = 0; tick < 3; ++tick) run.tick();
  const AllocationCounter counter;
  for (int tick = 0; tick < 20; ++tick) (void)contact_tick(model, run.frame, run.memory, run.work, run.state);
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace thenar::acting_muscles_test
