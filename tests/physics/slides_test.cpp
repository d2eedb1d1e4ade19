// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/slides.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "bench/cases/scene_run.h"
#include "engine/formats/files.h"
#include "engine/grasp/contact_tick.h"
#include "engine/loops/run.h"
#include "engine/loops/threads.h"
#include "engine/models/build_model.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scratch.h"

/// Fingertips on slides, by what can be worked out with a pencil.
namespace thenar::slides_test {
namespace {

using Eigen::Vector3d;

// A box of 40 mm on a plate, under a fingertip that faces down. Without friction nothing moves sideways but by the tip.
constexpr const char* kPress = R"(name: press
time: {duration: 1 s, step: 1 ms, control_period: 1 ms}
hand:
  slides:
    - {at: [0 mm, 0 mm, 28 mm], along: [0, 0, -2], radius: 8 mm, force: 2 N}
object:
  shape: {box: [40 mm, 40 mm, 40 mm]}
  points: 6000
  mass: 100 g
  position: [0 mm, 0 mm, 0 mm]
  rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  damping: {translation: 10 N*s/m, rotation: 0.005 N*m*s}
contact: {friction: 0.5, band: 0.3 mm, tolerance: 1e-10, max_sweeps: 1000}
environment: {friction: 0, bodies: [{shape: {plane: true}, position: [0 mm, 0 mm, -20 mm]}]}
)";

const std::string kPulps =
    "fingertips={points: 2400, leaves: 320, reduced_modulus: 0.24 MPa, poisson: 0.5, relaxation: 2 ms}";

Scene scene_with(const std::string& text, const std::vector<std::string>& changes = {}) {
  const std::filesystem::path file = scratch() / "slides.yaml";
  write_file(file, text);
  return load_scene(file, changes);
}

Scene press_with(const std::vector<std::string>& changes = {}) { return scene_with(kPress, changes); }

/// The slide of the press driven otherwise.
std::string driven_by(const std::string& drive) {
  return "hand.slides=[{at: [0 mm, 0 mm, 28 mm], along: [0, 0, -1], radius: 8 mm, " + drive + "}]";
}

/// Where fingertip k is.
Vector3d place_m(const Loop& loop, int k) {
  HandPose pose;
  forward_kinematics(loop.model.scene.hand, loop.state.q, pose);
  return pose.distal(loop.model.scene.hand, k) * loop.model.scene.hand.fingertips[k].centre_m;
}

// b qdot = F, and no rounding but that of adding up the steps: 200 of them, each to the last bit of 40 mm.
TEST(Slides, AFreeFingertipGoesAtForceOverDamping) {
  Loop loop(press_with({driven_by("force: -2 N, damping: 20 N*s/m")}));
  loop.run(0.2);
  EXPECT_NEAR(loop.state.q[0], -0.1 * 0.2, 200 * 4e-18);
  EXPECT_NEAR((place_m(loop, 0) - Vector3d(0.0, 0.0, 48e-3)).norm(), 0.0, 1e-15);
}

// A force that rises linearly in 0.1 s has at the start of tick i the share i / 100.
TEST(Slides, AForceRisesLinearly) {
  Loop loop(press_with({driven_by("force: -2 N, rise: 0.1 s")}));
  loop.run(0.05);
  double way_m = 0.0;
  for (int i = 0; i < 50; ++i) way_m += 1e-3 / 10.0 * 2.0 * i / 100.0;
  EXPECT_NEAR(loop.state.q[0], -way_m, 1e-15);
  loop.run(0.15);
  const double before_m = loop.state.q[0];
  loop.run(0.01);
  EXPECT_NEAR(loop.state.q[0] - before_m, -0.01 * 0.2, 1e-15);
}

// At rest the contact bears the whole force, and nothing else: F - f_n = b qdot, and the box stands still. Its own way
// into the plate, 1e-7 m/N, ends with b h / 1e-7 = 1e5 steps a newton's worth: within microseconds.
TEST(Slides, AFingertipPressesWithItsForce) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {kPulps, "contact.max_per_finger=100"}}) {
    SCOPED_TRACE(more.empty() ? "rigid" : "pulp");
    Loop loop(press_with(more));
    loop.run(0.5);
    EXPECT_NEAR(loop.state.load[0].normal_N, 2.0, 2e-8);
    EXPECT_NEAR((loop.state.load[0].force_N - Vector3d(0.0, 0.0, -2.0)).norm(), 0.0, 2e-8);
  }
}

// A spring pulls with k (rest - q), wherever that ends: 500 N/m towards 3 mm beyond the face.
TEST(Slides, ASpringPressesWithWhatIsLeftToItsRest) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {kPulps, "contact.max_per_finger=100"}}) {
    SCOPED_TRACE(more.empty() ? "rigid" : "pulp");
    std::vector<std::string> changes = {driven_by("spring: {stiffness: 500 N/m, rest: 3 mm}")};
    changes.insert(changes.end(), more.begin(), more.end());
    Loop loop(press_with(changes));
    loop.run(1.0);
    EXPECT_NEAR(loop.state.load[0].normal_N, 500.0 * (3e-3 - loop.state.q[0]), 2e-8);
    EXPECT_GT(loop.state.load[0].normal_N, 0.3);
  }
  // Free, it settles where it has no force: q' = k / b (rest - q), taken at the end of each step.
  Loop free(press_with({driven_by("spring: {stiffness: 500 N/m, rest: -5 mm}")}));
  free.run(0.01);
  EXPECT_NEAR(free.state.q[0], -5e-3 * (1.0 - std::pow(1.0 / (1.0 + 1e-3 * 500.0 / 10.0), 10)), 1e-15);
}

// A slide is rigid across: the box sticks to the fingertip while it is pulled sideways with half of what friction can
// hold, and the press does not change. With a finger it would by the pull times the way over its length.
TEST(Slides, ALoadAcrossDoesNotChangeThePress) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {kPulps, "contact.max_per_finger=100"}}) {
    SCOPED_TRACE(more.empty() ? "rigid" : "pulp");
    std::vector<std::string> changes = {
        "task.push={force: [0.3 N, 0.4 N, 0 N], at: [0 mm, 0 mm, 20 mm], from: 0.3 s, over: 10 s}"};
    changes.insert(changes.end(), more.begin(), more.end());
    Loop loop(press_with(changes));
    loop.run(1.0);
    // A pulp still creeps, by some 0.1 um/s, which the box's damping of 10 N s/m takes some uN for.
    EXPECT_NEAR((loop.state.load[0].force_N - Vector3d(-0.3, -0.4, -2.0)).norm(), 0.0, 1e-5);
    EXPECT_NEAR(loop.state.load[0].force_N.z(), -2.0, 2e-8);
    EXPECT_NEAR((place_m(loop, 0) - Vector3d(0.0, 0.0, place_m(loop, 0).z())).norm(), 0.0, 1e-15);
  }
}

// Where it touches the box and drags it along, too: whatever the contact does, the tip is where its path has it.
TEST(Slides, APathIsFollowedToRounding) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {kPulps, "contact.max_per_finger=100"}}) {
    SCOPED_TRACE(more.empty() ? "rigid" : "pulp");
    std::vector<std::string> changes = {
        driven_by("path: [{by: [0 mm, 0 mm, -0.5 mm], over: 0.1 s}, {by: [2 mm, 1 mm, 0 mm], over: 0.2 s, "
                  "profile: minimum_jerk}]"),
        "environment.compliance=1e-4 m/N"};
    changes.insert(changes.end(), more.begin(), more.end());
    Loop loop(press_with(changes));
    double most_N = 0.0;
    for (int tick = 1; tick <= 400; ++tick) {
      loop.tick();
      const double s = std::clamp((tick - 100) / 200.0, 0.0, 1.0);
      const double down_m = -0.5e-3 * std::min(1.0, tick / 100.0), share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
      EXPECT_NEAR((place_m(loop, 0) - Vector3d(2e-3 * share, 1e-3 * share, 28e-3 + down_m)).norm(), 0.0, 1e-15) << tick;
      most_N = std::max(most_N, loop.state.load[0].force_N.norm());
    }
    EXPECT_GT(most_N, 0.1);
    EXPECT_GT(loop.state.X_WO.translation().x(), 1.5e-3) << "the box went along";
  }
}

// What keeps a path going is booked as drive. Rigid, the energies are those of the box and its plate alone; the
// solver's tolerance is what is left.
TEST(Slides, TheLedgerClosesWithAPathAForceAndASpring) {
  const std::string path =
      "path: [{by: [0 mm, 0 mm, -0.8 mm], over: 0.1 s}, {by: [4 mm, 0 mm, 0 mm], over: 0.2 s, profile: minimum_jerk}]";
  for (const std::string& drive :
       {path, std::string("force: 2 N"), std::string("spring: {stiffness: 500 N/m, rest: 2 mm}")}) {
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {kPulps, "contact.max_per_finger=100"}}) {
      SCOPED_TRACE(drive + (more.empty() ? " rigid" : " pulp"));
      std::vector<std::string> changes = {driven_by(drive), "task.spring={translation: 500 N/m, rotation: 5 N*m/rad}",
                                          "environment.compliance=1e-6 m/N"};
      changes.insert(changes.end(), more.begin(), more.end());
      Loop loop(press_with(changes));
      Ledger sums;
      for (int tick = 0; tick < 400; ++tick) sums.add(loop.tick().ledger);
      EXPECT_GT(sums.drive_J, 1e-7);
      EXPECT_NEAR(sums.unbalanced_J(), 0.0, 1e-6 * sums.drive_J);
    }
  }
}

// Three fingertips at 120 degrees round a ball carry by friction m g <= 3 mu P, and no more.
TEST(Slides, ThreeFingertipsHoldABallToCoulombsLimit) {
  const double P_N = 2.0, mu = 0.5, limit_kg = 3.0 * mu * P_N / 9.81;
  for (const double share : {0.99, 1.01}) {
    SCOPED_TRACE(share);
    std::string text = "name: ball\ntime: {duration: 1 s, step: 1 ms, control_period: 1 ms}\nhand:\n  slides:\n";
    for (int k = 0; k < 3; ++k) {
      const double angle = 2.0 * std::numbers::pi / 3.0 * k, x = std::cos(angle), y = std::sin(angle);
      text += "    - {at: [" + std::to_string(33.0 * x) + " mm, " + std::to_string(33.0 * y) + " mm, 0 mm], along: [" +
              std::to_string(-x) + ", " + std::to_string(-y) + ", 0], radius: 8 mm, force: 2 N}\n";
    }
    text +=
        "gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]\nobject:\n  shape: {sphere: 25 mm}\n  points: 12000\n"
        "  mass: " +
        std::to_string(share * limit_kg) +
        " kg\n"
        "  position: [0 mm, 0 mm, 0 mm]\n  rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
        "  damping: {translation: 10 N*s/m, rotation: 0.005 N*m*s}\n"
        "contact: {friction: 0.5, band: 0.3 mm, tolerance: 1e-8, max_sweeps: 500}\n";
    Loop loop(scene_with(text));
    loop.run(0.1);
    const double before_m = loop.state.X_WO.translation().z();
    loop.run(0.5);
    const double speed_m_per_s = (loop.state.X_WO.translation().z() - before_m) / 0.5;
    // Beyond the limit the rest of the weight, 1 % of 3 N, moves the ball against its damping and that of the tips,
    // which do not move at first: 3 mm/s, and faster as it goes.
    if (share > 1.0) {
      EXPECT_LT(speed_m_per_s, -1e-3);
    } else {
      EXPECT_LT(std::abs(speed_m_per_s), 1e-6);
    }
  }
}

// The slides' own forces do not wait for frames: with frames that come at once, two loops do what one does, but for
// what a hand-over rounds.
TEST(Slides, LockstepWithoutDelayIsOneLoop) {
  for (const char* drive :
       {"force: 2 N, rise: 50 ms", "spring: {stiffness: 500 N/m, rest: 2 mm}",
        "path: [{by: [0 mm, 0 mm, -0.5 mm], over: 0.1 s}, {by: [2 mm, 1 mm, 0 mm], over: 0.2 s}]"}) {
    SCOPED_TRACE(drive);
    const Model model = build_model(
        press_with({driven_by(drive), kPulps, "contact.max_per_finger=100",
                    "task.spring={translation: 500 N/m, rotation: 5 N*m/rad}", "environment.compliance=1e-6 m/N"}));
    GraspRun one(model), lockstep(model, LockstepSettings{});
    for (int tick = 0; tick < 400; ++tick) {
      one.tick();
      lockstep.tick();
      ASSERT_NEAR((one.state.q - lockstep.state.q).norm(), 0.0, 1e-9) << tick;
      ASSERT_NEAR(one.state.load[0].normal_N, lockstep.state.load[0].normal_N, 1e-4) << tick;
    }
  }
}

// Whatever the clock does, what comes to rest rests where the one loop does.
TEST(Slides, ThreadsComeToTheSameRest) {
  const Model model = build_model(press_with({"time.control_period=5 ms", kPulps, "contact.max_per_finger=100"}));
  GraspRun one(model);
  for (int tick = 0; tick < 500; ++tick) one.tick();
  State state(model);
  ThreadSettings settings;
  settings.duration_s = 0.5;
  settings.realtime = false;
  settings.quiet = true;
  (void)run_threads(model, state, settings);
  EXPECT_NEAR(state.q[0], one.state.q[0], 1e-6);
  EXPECT_NEAR(state.load[0].normal_N, 2.0, 1e-4);
}

// A slide stops at the end of its range, where the stop bears the force.
TEST(Slides, ARangeEndsAtStops) {
  Loop loop(press_with({driven_by("force: -2 N, range: [-3 mm, 5 mm]")}));
  loop.run(0.1);
  EXPECT_NEAR(loop.state.q[0], -3e-3, 1e-17);
  EXPECT_NEAR(loop.tick().stop_Nm[0], 2.0, 1e-12);
}

// In a period of frames a fingertip may come from far away: it must not pass through the face.
TEST(Slides, NothingIsPassedBetweenFrames) {
  for (const char* drive : {"force: 20 N", "path: [{by: [0 mm, 0 mm, -8 mm], over: 20 ms}]"}) {
    SCOPED_TRACE(drive);
    const Scene scene = press_with(
        {"hand.slides=[{at: [0 mm, 0 mm, 34 mm], along: [0, 0, -1], radius: 8 mm, " + std::string(drive) + "}]",
         "time.control_period=20 ms", "environment.compliance=1e-4 m/N"});
    const Model model = build_model(scene);
    GraspRun loops(model, LockstepSettings{});
    double deepest_m = 0.0;
    for (int tick = 0; tick < 60; ++tick) {
      const TickReport report = loops.tick();
      // In the end nothing moves, with a force of tens of newtons between the path and the plate.
      EXPECT_EQ(report.solve.status, SolveStatus::kConverged) << tick;
      deepest_m = std::max(deepest_m, report.penetration_m);
    }
    EXPECT_GT(loops.state.load[0].normal_N, 1.0);
    EXPECT_LE(deepest_m, 1e-6);
  }
}

}  // namespace
}  // namespace thenar::slides_test
