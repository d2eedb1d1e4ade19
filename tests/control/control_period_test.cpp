// SPDX-License-Identifier: Apache-2.0
#include "engine/control/control_period.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>

#include "engine/control/control_tick.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::control_period_test {
namespace {

constexpr int kTicks = 200;

Model box(const std::vector<std::string>& changes = {}) {
  std::vector<std::string> all = {kCoarseBox};
  all.insert(all.end(), changes.begin(), changes.end());
  return build_model(scene_of("box_grasp", all));
}

void run(GraspRun& grasp, int ticks = kTicks) {
  for (int i = 0; i < ticks; ++i) grasp.tick();
}

void expect_same_bits(const GraspRun& one, const GraspRun& other) {
  EXPECT_EQ(one.state.q, other.state.q);
  EXPECT_EQ(one.state.X_WO.matrix(), other.state.X_WO.matrix());
  EXPECT_EQ(one.controller.f_muscle, other.controller.f_muscle);
}

/// All four parts handed in, each as published.
OwnControl published() {
  return {.wrench = published_wrench,
          .forces = published_forces,
          .torques = published_torques,
          .muscles = [](ControlPeriod& period) { return published_muscle_forces(period); }};
}

// The published controller is four such functions: handed in, they give the bits that none gives.
TEST(ControlPeriod, PublishedLawsAreFunctionsLikeAnyOthers) {
  const Model model = box();
  GraspRun plain(model), handed(model);
  handed.controller.own = published();
  run(plain);
  run(handed);
  expect_same_bits(plain, handed);
  EXPECT_TRUE(handed.report.has_forces);
}

// W^d replaced alone: the grasp forces give just that, and the rest follows.
TEST(ControlPeriod, OwnWrenchIsWhatTheForcesGive) {
  const Model model = box();
  GraspRun grasp(model);
  const Vector6d extra = (Vector6d() << 0.3, 0.0, -0.2, 2e-3, 0.0, 0.0).finished();
  grasp.controller.own.wrench = [&](ControlPeriod& period) { return Vector6d(published_wrench(period) + extra); };
  run(grasp, 60);
  Eigen::MatrixXd G(6, 3 * model.fingers());
  grasp.control();
  const std::span<const GraspContact> contacts(grasp.report.contacts.data(), grasp.report.contacts.size());
  grasp_map(contacts, grasp.state.X_WO.translation(), G);
  EXPECT_LE((G * grasp.report.f_desired.reshaped() - grasp.report.wrench_desired).norm(), 1e-9);
  // Integrals of some periods beside, the push in x is what was added: without it nothing asks for it.
  GraspRun plain(model);
  run(plain, 60);
  plain.control();
  EXPECT_GT((grasp.report.wrench_desired - plain.report.wrench_desired).norm(), 0.1);
}

// f^d replaced alone: torques and muscles follow it, J' f^d + g + K J^+ y.
TEST(ControlPeriod, OwnForcesAreWhatTheTorquesFollow) {
  const Model model = box();
  GraspRun plain(model), doubled(model);
  doubled.controller.own.forces = [](ControlPeriod& period) -> std::optional<FingerForces> {
    const auto f = published_forces(period);
    if (!f) return f;
    return FingerForces(2.0 * *f);
  };
  run(plain);
  run(doubled);
  for (int k = 0; k < model.fingers(); ++k) {
    // Weight, of which a finger carries some tenths of a newton, aside; the force control leaves some per cent.
    EXPECT_NEAR(doubled.state.load[k].normal_N / plain.state.load[k].normal_N, 2.0, 0.2);
  }
}

/// The least |H f - tau|^2 with 0 <= f <= limit, by projected gradients with momentum [Nesterov 1983].
double least_miss_Nm(const Eigen::MatrixXd& H, const Eigen::VectorXd& tau, const Eigen::VectorXd& limit) {
  const double per_L = 1.0 / (H * H.transpose()).eval().norm();
  Eigen::VectorXd f = Eigen::VectorXd::Zero(H.cols()), ahead = f;
  double t = 1.0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::VectorXd next = (ahead - per_L * (H.transpose() * (H * ahead - tau))).cwiseMax(0.0).cwiseMin(limit);
    const double t_next = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * t * t));
    ahead = next + (t - 1.0) / t_next * (next - f);
    f = next;
    t = t_next;
  }
  return (H * f - tau).norm();
}

// Torques that are too much for the muscles: they come as near as muscles within their limits can. Least forces that
// are cut at the limits one by one miss the torques of other joints, too, and press a finger aside.
TEST(ControlPeriod, MusclesThatAreTooWeakComeNearest) {
  const Model model = box();
  int weak = 0;
  for (double times = 2.0; times < 1000.0; times *= 2.0) {
    SCOPED_TRACE(times);
    GraspRun grasp(model);
    run(grasp, 50);
    grasp.controller.own.torques = [&](ControlPeriod& period) {
      return JointVector(times * published_torques(period));
    };
    grasp.control();
    if (grasp.report.muscle == MuscleStatus::kOptimal) continue;
    ++weak;
    const Eigen::MatrixXd& H = grasp.controller.H;
    const Eigen::VectorXd &f = grasp.controller.f_muscle, &limit = grasp.controller.most_N;
    EXPECT_GE(f.minCoeff(), 0.0);
    EXPECT_LE((f - limit).maxCoeff(), 1e-9);
    const Eigen::VectorXd tau = grasp.report.torques_desired_Nm;
    // Forces count, too, by up to 0.1 mN m a joint: an arm of 0.1 mm against theirs of 5 mm, at 50 N.
    EXPECT_LT((H * f - tau).norm(), 1.01 * least_miss_Nm(H, tau, limit) + 0.4e-3);
  }
  EXPECT_GE(weak, 3) << "or this tells nothing";
}

// No forces: the status says so, and the last ones go on.
TEST(ControlPeriod, WithoutOwnForcesTheLastGoOn) {
  const Model model = box();
  GraspRun grasp(model);
  run(grasp, 50);
  grasp.control();
  const FingerForces before = grasp.report.f_desired;
  grasp.controller.own.forces = [](ControlPeriod&) { return std::optional<FingerForces>(); };
  grasp.control();
  EXPECT_EQ(grasp.report.grasp, GraspStatus::kInfeasible);
  EXPECT_EQ(grasp.report.f_desired, before);
}

// Torques replaced: what they do not ask for is not found, and costs nothing. Constant ones are those of a scene
// without control, to the last bit.
TEST(ControlPeriod, OwnTorquesAskForWhatTheyNeedAlone) {
  Scene scene = scene_of("box_grasp", {kCoarseBox, "control.muscles=false"});
  const Model controlled = build_model(scene);
  scene.control.reset();
  const JointVector tau = 0.01 * JointVector::Ones(static_cast<Eigen::Index>(scene.hand.joints.size()));
  scene.torques = tau;
  const Model constant = build_model(scene);

  GraspRun own(controlled), given(constant), both(constant);
  const auto law = [&](ControlPeriod&) { return tau; };
  own.controller.own.torques = both.controller.own.torques = law;
  run(given);
  run(own);
  run(both);
  EXPECT_EQ(own.state.q, given.state.q);
  EXPECT_EQ(both.state.q, given.state.q);
  EXPECT_EQ(own.state.X_WO.matrix(), given.state.X_WO.matrix());
  EXPECT_FALSE(own.report.has_forces);
  EXPECT_EQ(own.report.f_desired.norm(), 0.0);
  EXPECT_EQ(own.report.wrench_desired.norm(), 0.0);
}

// f_m replaced alone: the joints get H f_m of them.
TEST(ControlPeriod, OwnMuscleForcesMoveTheJoints) {
  const Model model = box();
  GraspRun grasp(model);
  grasp.controller.own.muscles = [](ControlPeriod& period) {
    return Eigen::VectorXd(1.5 * published_muscle_forces(period));
  };
  grasp.control();
  const JointVector tau = grasp.controller.H * grasp.controller.f_muscle;
  EXPECT_LE((tau - 1.5 * grasp.report.torques_desired_Nm).norm(), 1e-9);
  EXPECT_NEAR(grasp.report.muscle_residual_Nm, 0.5 * grasp.report.torques_desired_Nm.cwiseAbs().maxCoeff(), 1e-9);
}

// Each is asked for at most once a period, whoever asks.
TEST(ControlPeriod, EachLawIsCalledOnceAPeriod) {
  const Model model = box();
  GraspRun grasp(model);
  int calls = 0;
  grasp.controller.own.wrench = [&](ControlPeriod& period) {
    ++calls;
    return published_wrench(period);
  };
  grasp.controller.own.torques = [](ControlPeriod& period) {
    period.wrench();
    period.forces();
    return published_torques(period);
  };
  run(grasp, 10);
  EXPECT_EQ(calls, grasp.controller.sequence);
}

// A law that asks for what waits for it, or for the published answer twice, is told so: the PID goes on with each.
TEST(ControlPeriod, RefusesCirclesAndSecondAnswers) {
  const Model model = box();
  GraspRun circle(model), twice(model);
  circle.controller.own.wrench = [](ControlPeriod& period) {
    period.torques();
    return published_wrench(period);
  };
  EXPECT_THROW(circle.control(), std::logic_error);
  twice.controller.own.wrench = [](ControlPeriod& period) {
    return Vector6d(published_wrench(period) + published_wrench(period));
  };
  EXPECT_THROW(twice.control(), std::logic_error);
}

// What no hand can do is refused by name, before it is in a frame.
TEST(ControlPeriod, RefusesWhatCannotBe) {
  const Model model = box();
  const auto refused = [&](const OwnControl& own) -> std::string {
    GraspRun grasp(model);
    grasp.controller.own = own;
    try {
      grasp.control();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const auto muscles = static_cast<Eigen::Index>(model.scene.hand.muscles.size());
  EXPECT_EQ(refused({.torques = [](ControlPeriod&) { return JointVector(JointVector::Zero(3)); }}),
            "joint torques of the caller's law: 3 numbers, not 12");
  EXPECT_EQ(refused({.wrench =
                         [](ControlPeriod&) {
                           return Vector6d(Vector6d::Constant(std::numeric_limits<double>::quiet_NaN()));
                         }}),
            "wrench of the caller's law: a number is not finite");
  const auto push = [&](ControlPeriod&) -> Eigen::VectorXd { return Eigen::VectorXd::Constant(muscles, -1.0); };
  EXPECT_EQ(refused({.muscles = push}),
            "muscle forces of the caller's law: " + model.scene.hand.muscles[0].name + " is to push, and muscles pull");
  // And what has no published law says so.
  Scene scene = model.scene;
  scene.control.reset();
  const Model without = build_model(scene);
  GraspRun grasp(without);
  grasp.controller.own.torques = published_torques;
  EXPECT_THROW(grasp.control(), std::logic_error);
}

}  // namespace
}  // namespace thenar::control_period_test
