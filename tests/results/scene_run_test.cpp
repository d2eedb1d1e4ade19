// SPDX-License-Identifier: Apache-2.0
#include "engine/results/scene_run.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::scene_run_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The scene seen from axes turned by R: joints, segments (the palm too), object and gravity. Points of bodies, in
/// their own axes, stay.
Scene turned(Scene scene, const Matrix3d& R) {
  for (Joint& joint : scene.hand.joints) {
    joint.origin_m = R * joint.origin_m;
    joint.axis = R * joint.axis;
  }
  for (Segment& segment : scene.hand.segments) segment.X_WS_0 = R * segment.X_WS_0;
  scene.object.X_WO = R * scene.object.X_WO;
  scene.gravity = R * scene.gravity;
  return scene;
}

// Space has no preferred direction: the turned scene moves as the first one does, turned. 80 ms in which the grip
// builds up and the box is carried 20 mm. Both runs round differently, at 1e-16; contact amplifies that to far less
// than 1e-9. Forces are solved for to less than that: where a solve stops depends on rounding.
TEST(Monolithic, PhysicsDoesNotDependOnTheAxes) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 2; ++trial) {
    SCOPED_TRACE(trial);
    const Matrix3d R = random_rotation(random);
    const Scene scene = scene_of(
        "box_grasp", {kCoarseBox, "task.translate.from=0 s", "task.translate.over=100 ms", "contact.tolerance=1e-11"});
    Loop straight(scene), turning(turned(scene, R));
    for (int tick = 0; tick < 80; ++tick) {
      straight.tick();
      turning.tick();
      const State &a = straight.state, &b = turning.state;
      ASSERT_LE((R * a.X_WO.translation() - b.X_WO.translation()).norm(), 1e-9);
      ASSERT_LE((R * a.X_WO.linear() - b.X_WO.linear()).norm(), 1e-9);
      ASSERT_LE((a.q - b.q).norm(), 1e-9);
      for (int k = 0; k < std::ssize(a.load); ++k) ASSERT_LE((R * a.load[k].force_N - b.load[k].force_N).norm(), 1e-9);
    }
    EXPECT_GT((straight.state.X_WO.translation() - scene.object.X_WO.translation()).norm(), 5e-3);
    EXPECT_GT(straight.state.load[0].force_N.norm(), 0.5);
  }
}

/// The same grasp from now on with another step.
Loop continued(const Loop& loop, double step_s) {
  Loop next = loop;
  next.state.tick = std::lround(static_cast<double>(loop.state.tick) * loop.model.scene.step_s / step_s);
  next.model.scene.step_s = step_s;
  return next;
}

/// Positions of the box's corners every control period.
std::vector<Eigen::Matrix<double, 3, 8>> path(Loop loop, int periods) {
  Eigen::Matrix<double, 3, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners.col(i) << (i & 1 ? 25e-3 : -25e-3), (i & 2 ? 25e-3 : -25e-3), (i & 4 ? 25e-3 : -25e-3);
  std::vector<Eigen::Matrix<double, 3, 8>> path;
  for (int i = 0; i < periods; ++i) {
    loop.run(loop.model.scene.control_period_s);
    path.push_back(loop.state.X_WO * corners);
  }
  return path;
}

/// The power p of y = c x^p, by least squares of the logarithms.
double power_law(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  const Eigen::ArrayXd log_x = x.log() - x.log().mean(), log_y = y.log() - y.log().mean();
  return (log_x * log_y).sum() / log_x.square().sum();
}

// With the control held at 4 ms and its gain fixed, the box's path converges at first order in the contact step: the
// steps are implicit Euler for the rigid bodies. All runs go on from one state, 0.1 s after the start: the order in
// which points first touched, which friction remembers, would differ by a whole step. The error against a run of step
// h_0 is C (h - h_0), so its power is taken over h - h_0. Points that touch or slip a step earlier or later leave 0.2
// in it.
TEST(Monolithic, ConvergesAtFirstOrderInTheStep) {
  constexpr double kFinest_s = 31.25e-6;
  constexpr int kPeriods = 100;
  Scene scene =
      scene_of("box_grasp", {kCoarseBox, "time.step=31.25 us", "time.control_period=4 ms", "control.gain=7.5 N*m/rad",
                             "task.translate.from=0.1 s", "task.translate.over=0.3 s"});
  scene.contact.tolerance = 1e-9;
  scene.contact.max_sweeps = 100'000;
  Loop start(std::move(scene));
  start.run(0.1);
  const auto finest = path(start, kPeriods);

  const Eigen::Array4d h(1e-3, 0.5e-3, 0.25e-3, 0.125e-3);
  Eigen::Array4d rms_m;
  for (int run = 0; run < 4; ++run) {
    const auto coarse = path(continued(start, h[run]), kPeriods);
    double sum = 0.0;
    for (int i = 0; i < kPeriods; ++i) sum += (coarse[i] - finest[i]).squaredNorm() / 8.0;
    rms_m[run] = std::sqrt(sum / kPeriods);
  }
  SCOPED_TRACE(testing::Message() << "rms error of the corners [m]: " << rms_m.transpose());
  const double power = power_law(h - kFinest_s, rms_m);
  EXPECT_GT(power, 0.8);
  EXPECT_LT(power, 1.2);
  // 20 mm in 0.3 s: 1 ms of the path is 67 um, and the controller corrects most of it.
  EXPECT_LT(rms_m[0], 10e-6);
}

template <typename Matrix>
void append(const Eigen::DenseBase<Matrix>& values, std::vector<double>& to) {
  for (const double value : values.reshaped()) to.push_back(value);
}

/// Every number of a run but its times.
std::vector<double> numbers(const Recording& recording, const State& state) {
  std::vector<double> all;
  for (const TickRecord& tick : recording.ticks) {
    append(tick.position_m, all);
    append(tick.target_m, all);
    for (std::size_t k = 0; k < tick.force.size(); ++k) {
      for (const NormalTangential& force : {tick.force[k], tick.force_desired[k]}) {
        all.insert(all.end(), {force.normal_N, force.tangential_N});
      }
      all.insert(all.end(), {tick.force_error_N[k], tick.margin[k], tick.slip_m[k], tick.spin_rad[k]});
    }
    const Ledger& ledger = tick.ledger;
    all.insert(all.end(), {ledger.drive_J, ledger.viscous_J, ledger.deformation_J, ledger.stored_J, ledger.injected_J,
                           ledger.dissipated_J});
    all.insert(all.end(), {tick.time_s, tick.rotation_error_rad, tick.muscle_residual_Nm, tick.contact.penetration_m,
                           tick.contact.solve.residual, static_cast<double>(tick.contact.solve.sweeps),
                           static_cast<double>(tick.contact.contacts), static_cast<double>(tick.contact.active)});
  }
  append(recording.muscle_forces_N, all);
  append(state.q, all);
  append(state.X_WO.matrix(), all);
  for (const auto& u : state.u_m) append(u, all);
  for (const ContactForce& force : state.forces) append(force.f_C, all);
  return all;
}

// The same scene gives the same bits, from its file on: no clock, address or uninitialised memory gets into the
// numbers. NaN cone margins are compared, too.
TEST(Monolithic, TwoRunsAreBitIdentical) {
  std::array<std::vector<double>, 2> runs;
  for (auto& run : runs) {
    const Model model =
        build_model(scene_of("box_grasp", {kCoarseBox, "time.duration=0.2 s", "task.translate.from=0.05 s"}));
    State state(model);
    const Recording recording = run_scene(model, state);
    ASSERT_EQ(recording.ticks.size(), 200);
    run = numbers(recording, state);
  }
  ASSERT_EQ(runs[0].size(), runs[1].size());
  EXPECT_EQ(std::memcmp(runs[0].data(), runs[1].data(), runs[0].size() * sizeof(double)), 0);
}

// run_scene is the two ticks in a loop, and the same state comes out of them called by hand; displaying and
// recording do not touch it.
TEST(Monolithic, IsTheTwoTicksInALoop) {
  const Scene scene = scene_of("box_grasp", {kCoarseBox, "time.duration=60 ms", "time.control_period=3 ms"});
  const Model model = build_model(scene);
  State state(model);
  const Recording recording = run_scene(model, state);
  Loop loop(scene);
  loop.run(60e-3);
  EXPECT_EQ(state.q, loop.state.q);
  EXPECT_EQ(state.X_WO.matrix(), loop.state.X_WO.matrix());
  EXPECT_EQ(recording.ticks.size(), 60);
  for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(recording.ticks[i].controlled, i % 3 == 0);
}

}  // namespace
}  // namespace thenar::scene_run_test
