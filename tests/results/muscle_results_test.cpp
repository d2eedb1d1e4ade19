// SPDX-License-Identifier: Apache-2.0
// What a run tells of its muscles: the forces that acted, and those that were asked for.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/hand/muscles.h"
#include "engine/models/build_model.h"
#include "engine/recordings/signals.h"
#include "engine/results/scene_run.h"
#include "engine/results/warnings.h"
#include "tests/results/watched_runs.h"
#include "tests/support/scenes.h"

namespace thenar::muscle_results_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDrag = 1e5;  // [N m s] Joints turn by less than 1e-7 rad in a tick.

/// A hand that touches nothing. Its muscles are asked for 5 N, and for 40 N from 5 to 12 ms.
Model free_hand(const std::string& muscles, const std::vector<std::string>& more = {}) {
  std::vector<std::string> changes = {kCoarseBox,
                                      "fingertips.leaves=80",
                                      "object.position=[500 mm, 400 mm, 0 mm]",
                                      "time.duration=20 ms",
                                      "control.gain=1 N*m/rad",
                                      "control.muscles=" + muscles};
  changes.insert(changes.end(), more.begin(), more.end());
  Scene scene = scene_of("box_grasp", changes);
  scene.joint_viscosity = kDrag;
  DriveTable drive;
  drive.muscles = true;
  drive.time_s.resize(6);
  drive.time_s << 0.0, 0.005, 0.0051, 0.012, 0.0121, 1.0;
  drive.values = MatrixXd::Constant(std::ssize(scene.hand.muscles), 6, 5.0);
  drive.values.middleCols(2, 2).setConstant(40.0);
  // EDC pulls two fingers, with forces of their own where it is stretched.
  const auto shared = std::ranges::find(scene.hand.muscles, "EDC", &Muscle::name) - scene.hand.muscles.begin();
  drive.values.row(shared).setZero();
  scene.control->drive = drive;
  return build_model(scene);
}

MatrixXd arms(const Hand& hand, const JointVector& q) {
  HandPose pose;
  forward_kinematics(hand, q, pose);
  MatrixXd H(q.size(), std::ssize(hand.muscles));
  moment_arms(hand, pose, H);
  return H;
}

/// The largest difference of b dq/dt from H f - g over a run, over the largest torque.
double worst_balance(const Model& model, const Recording& run) {
  const Hand& hand = model.scene.hand;
  double worst = 0.0;
  for (std::size_t i = 1; i < run.ticks.size(); ++i) {
    const JointVector& q = run.ticks[i].q_rad;
    HandPose pose;
    forward_kinematics(hand, q, pose);
    const VectorXd drag = kDrag * (q - run.ticks[i - 1].q_rad) / model.scene.step_s;
    const VectorXd tau = arms(hand, q) * run.muscle_forces_N.col(static_cast<Index>(i)) -
                         gravity_torques(hand, pose, model.scene.gravity);
    worst = std::max(worst, (drag - tau).cwiseAbs().maxCoeff() / tau.cwiseAbs().maxCoeff());
  }
  return worst;
}

// Whoever runs the ticks, the forces that are told are those that move the fingers: b dq/dt = H f - g. Frames of
// another loop are some ticks old, in which arms change by less than 1e-6 of themselves.
TEST(MuscleResults, AreTheForcesThatActInAllRunners) {
  for (const std::string muscles : {"true", "{stiffness: 23.4, activation: 12 ms, deactivation: 45 ms}"}) {
    const Model model = free_hand(muscles, {"time.control_period=2 ms", "time.control_delay=2 ms"});
    for (const std::string runner : {"one loop", "lockstep", "threads"}) {
      SCOPED_TRACE(muscles + " " + runner);
      State state(model);
      for (Index i = 0; i < state.q.size(); ++i) state.q[i] += i % 2 == 0 ? 0.1 : -0.1;
      Recording run;
      if (runner == "threads") {
        ThreadSettings settings;
        settings.duration_s = model.scene.duration_s;
        settings.realtime = false;
        settings.quiet = true;
        run = run_realtime(model, state, settings).recording;
      } else {
        RunSettings settings;
        if (runner == "lockstep") settings.lockstep = LockstepSettings{};
        run = run_scene(model, state, settings);
      }
      ASSERT_GT(run.ticks.size(), 10U);
      EXPECT_LE(worst_balance(model, run), 1e-6);
    }
  }
}

// signals.csv has a column of both for muscles that act, and one for others, whose commands act.
TEST(MuscleResults, HaveColumnsOfForcesAndOfWhatWasAskedFor) {
  for (const std::string muscles : {"true", "{activation: 12 ms, deactivation: 45 ms}"}) {
    SCOPED_TRACE(muscles);
    const Model model = free_hand(muscles);
    State state(model);
    const SignalTable table = signal_table(model, run_scene(model, state));
    const auto column = [&](const std::string& name) -> VectorXd {
      const auto at = std::ranges::find(table.names, name);
      return at == table.names.end() ? VectorXd() : VectorXd(table.numbers.col(at - table.names.begin()));
    };
    const VectorXd f = column("FPL_N"), asked = column("FPL_asked_N");
    ASSERT_EQ(f.size(), 20);
    if (muscles == "true") {
      EXPECT_EQ(asked.size(), 0);
      EXPECT_EQ(f[8], 40.0);
      continue;
    }
    ASSERT_EQ(asked.size(), 20);
    EXPECT_EQ(asked[8], 40.0);  // 3 ms after the step of a time constant of 12 ms, times 0.5 and a little more.
    EXPECT_GT(f[8], 5.0 + 0.3 * 35.0);
    EXPECT_LT(f[8], 5.0 + 0.6 * 35.0);
    EXPECT_EQ(asked[15], 5.0);  // 3 ms after the fall, of 45 ms.
    EXPECT_GT(f[15], 15.0);
  }
}

// A muscle that is stretched pulls harder than it is asked to, and harder than it is known to be able to: that is told.
TEST(MuscleResults, APushThatStretchesAMuscleBeyondItsLimitIsTold) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, "control.muscles={stiffness: 23.4}"}));
  const Muscle& muscle = model.scene.hand.muscles[4];  // FPL, 201 N.
  GraspMonitor monitor(model);
  const VectorXd asked = VectorXd::Constant(23, 1.0);
  MuscleVector pull_N = asked;
  TickRecord tick = watched_runs::steady_run().ticks.front();
  const auto add = [&](double time_s, double share) {
    tick.time_s = time_s;
    pull_N[4] = share * muscle.max_force_N;
    monitor.add(time_s, watched_runs::solved(), asked);
    monitor.add(tick, pull_N);
  };
  add(0.1, 1.04);  // No more than isometric forces are known to.
  EXPECT_TRUE(monitor.verdict().beyond.empty());
  add(0.2, 1.1);
  add(0.3, 1.2);
  add(0.4, 0.9);
  const Verdict verdict = monitor.verdict();
  EXPECT_EQ(verdict.outcome, Outcome::kOverLimits);
  ASSERT_EQ(verdict.beyond.size(), 1U);
  EXPECT_EQ(verdict.reason,
            "the muscle FPL pulled with 241 N at 0.300 s, 1.2 times its 201 N (first passed at 0.200 s)");
}

TEST(MuscleResults, FibresThatYieldAreToldOnce) {
  const Model model = free_hand("{stiffness: 23.4}");
  State state(model);
  EXPECT_TRUE(warnings(model, run_scene(model, state)).empty());

  State turned(model);
  turned.q[3] -= 0.3;  // The thumb's last joint: its flexor is lengthened, its extensors are shortened.
  const Recording run = run_scene(model, turned);
  const std::vector<std::string> told = warnings(model, run);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("the fibres of "), std::string::npos) << told[0];
  EXPECT_NE(told[0].find("beyond the 2 % within which their short-range stiffness holds; from 0.001 s on "),
            std::string::npos)
      << told[0];
  EXPECT_NE(told[0].find("FPL"), std::string::npos) << told[0];
  // FPL's stretch, by its arm at the last joint and the whole of its fibres: a rigid tendon would have passed it all
  // on.
  const double dl = -arms(model.scene.hand, turned.q)(3, 4) * -0.3, L = *model.scene.hand.muscles[4].fibre_m;
  EXPECT_LE(std::abs(run.ticks.back().contact.yielded.strain), 1.5 * dl / L);
}

}  // namespace
}  // namespace thenar::muscle_results_test
