// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/live_input.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "engine/control/control.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::live_input_test {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kNow_ns = 5'000'000'000'000;
constexpr std::int64_t kMillisecond_ns = 1'000'000;

Scene still_box(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {kCoarseBox, "time.step=1 ms", "time.control_period=5 ms"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  Scene scene = scene_of("box_grasp", overrides);
  scene.task = {};
  return scene;
}

LiveInput pull_at(const Vector3d& point_O, const Vector3d& handle_W) {
  LiveInput input;
  input.number = 1;
  input.stamp_ns = input.pull_heard_ns = kNow_ns;
  input.pull = LiveInput::Pull{point_O, handle_W};
  return input;
}

/// Runs the loops for so long under an input that somebody repeats.
void run(GraspRun& loops, LiveHands& hands, LiveInput input, const Model& model, double duration_s) {
  const auto ticks = std::lround(duration_s / model.scene.step_s);
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    input.pull_heard_ns = kNow_ns;
    loops.tick(hands.next(input, loops.state, kNow_ns));
  }
}

TEST(LiveHands, DoNothingWithoutInput) {
  const Model model = build_model(still_box());
  LiveHands hands(model);
  const TickInput tick = hands.next({}, State(model), kNow_ns);
  EXPECT_EQ(tick.wrench, Vector6d(Vector6d::Zero()));
  EXPECT_FALSE(tick.X_WT);
  EXPECT_FALSE(hands.pull());
}

// The spring's law at any pose, and the moment of its force about the centre.
TEST(LiveHands, PullAsASpringOfLimitedForce) {
  const Model model = build_model(still_box());
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    LiveHands hands(model);
    State state(model);
    state.X_WO.linear() = random_rotation(random);
    state.X_WO.translation() += 0.02 * random_direction(random);
    const Vector3d point_O = 0.025 * random_direction(random);
    const Vector3d anchor = state.X_WO * point_O;
    const Vector3d way = uniform(random, 0.0, 0.05) * random_direction(random);
    const TickInput tick = hands.next(pull_at(point_O, anchor + way), state, kNow_ns);
    const Vector3d force = std::min(kPullStiffness_N_per_m, kPullLimit_N / way.norm()) * way;
    EXPECT_LT((tick.wrench.head<3>() - force).norm(), 1e-12);
    EXPECT_LT((tick.wrench.tail<3>() - (anchor - state.X_WO.translation()).cross(force)).norm(), 1e-12);
    ASSERT_TRUE(hands.pull());
    EXPECT_LT((hands.pull()->force_N - force).norm(), 1e-12);
    EXPECT_LT((hands.pull()->anchor_m - anchor).norm(), 1e-12);
  }
}

TEST(LiveHands, LetGoWhenNothingMoreIsHeard) {
  const Model model = build_model(still_box());
  LiveHands hands(model);
  const State state(model);
  const LiveInput input = pull_at(Vector3d::Zero(), state.X_WO.translation() + Vector3d(0.01, 0.0, 0.0));
  EXPECT_GT(hands.next(input, state, kNow_ns + 199 * kMillisecond_ns).wrench.norm(), 0.5);
  EXPECT_EQ(hands.next(input, state, kNow_ns + 201 * kMillisecond_ns).wrench.norm(), 0.0);
  EXPECT_FALSE(hands.pull());
}

// The impulse of half a sine of amplitude F over T is 2 F T / pi, at any rate at which it is sampled in its middles.
TEST(LiveHands, PokeOnceByHalfASine) {
  for (const char* step : {"time.step=0.25 ms", "time.step=1 ms", "time.step=5 ms"}) {
    const Model model = build_model(still_box({step}));
    LiveHands hands(model);
    const State state(model);
    LiveInput input;
    input.pokes = 1;
    input.poke_N = Vector3d(0.0, 3.0, 0.0);
    double impulse = 0.0, most_N = 0.0;
    for (int tick = 0; tick < 400; ++tick) {
      const TickInput next = hands.next(input, state, kNow_ns);
      EXPECT_EQ(next.wrench.tail<3>().norm(), 0.0);
      EXPECT_GE(next.wrench[1], 0.0);
      impulse += model.scene.step_s * next.wrench[1];
      most_N = std::max(most_N, next.wrench[1]);
    }
    // The midpoint rule on n intervals errs by (pi / n)^2 / 24 of it; 6 intervals: 1.1 %.
    EXPECT_NEAR(impulse, 2.0 * 3.0 * kPoke_s / std::numbers::pi, 0.015 * 2.0 * 3.0 * kPoke_s / std::numbers::pi)
        << step;
    EXPECT_LE(most_N, 3.0);
    input.pokes = 2;
    EXPECT_GT(hands.next(input, state, kNow_ns).wrench[1], 0.0) << "the second one";
  }
}

TEST(LiveHands, MoveTheTargetSlowlyAndGiveItBack) {
  Scene scene = still_box();
  scene.task.translate = Move{Vector3d::UnitY(), 0.02, 0.0, 0.5};
  const Model model = build_model(scene);
  LiveHands hands(model);
  State state(model);
  const Eigen::Matrix3d R = model.scene.object.X_WO.linear();
  LiveInput input;
  input.target_shift_m = Vector3d(0.02, 0.0, -0.01);
  input.target_turn_rad = Vector3d(0.0, 0.3, 0.0);
  Eigen::Isometry3d last = model.target(0.0);
  for (; state.tick < 1000; ++state.tick) {
    const TickInput tick = hands.next(input, state, kNow_ns);
    ASSERT_TRUE(tick.X_WT);
    // Beside the task's own motion no faster than it may.
    const Eigen::Isometry3d task = model.target(static_cast<double>(state.tick + 1) * model.scene.step_s);
    const Eigen::Isometry3d task_before = model.target(static_cast<double>(state.tick) * model.scene.step_s);
    const Vector3d shift = tick.X_WT->translation() - task.translation();
    const Vector3d shift_before = last.translation() - task_before.translation();
    EXPECT_LE((shift - shift_before).norm(), kShiftSpeed_m_per_s * model.scene.step_s + 1e-12);
    EXPECT_LE(Eigen::AngleAxisd(tick.X_WT->linear() * last.linear().transpose()).angle(),
              kTurnSpeed_rad_per_s * model.scene.step_s + 1e-9);
    last = *tick.X_WT;
  }
  const Eigen::Isometry3d there = model.target(1.0);
  EXPECT_LT((last.translation() - there.translation() - R * input.target_shift_m).norm(), 1e-12);
  EXPECT_LT((last.linear() - R * Eigen::AngleAxisd(0.3, Vector3d::UnitY()).toRotationMatrix()).norm(), 1e-9);
  input.target_shift_m.setZero();
  input.target_turn_rad.setZero();
  for (; state.tick < 2000; ++state.tick) std::ignore = hands.next(input, state, kNow_ns);
  EXPECT_FALSE(hands.next(input, state, kNow_ns).X_WT);
}

TEST(LiveHands, ForgetAllButThePokesOnAReset) {
  const Model model = build_model(still_box());
  LiveHands hands(model);
  const State state(model);
  LiveInput input;
  input.pokes = 1;
  input.poke_N = Vector3d::UnitX();
  input.target_shift_m = Vector3d(0.01, 0.0, 0.0);
  for (int tick = 0; tick < 10; ++tick) std::ignore = hands.next(input, state, kNow_ns);
  input.pokes = 2;  // The second one came while nothing ran.
  hands.reset(input);
  input.target_shift_m.setZero();
  const TickInput tick = hands.next(input, state, kNow_ns);
  EXPECT_EQ(tick.wrench.norm(), 0.0);
  EXPECT_FALSE(tick.X_WT);
}

/// Any number that a double can be, most of them absurd.
double any_double(std::mt19937_64& random) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr std::array kSpecial{0.0,    -0.0,      1e308,      -1e308,
                                5e-324, kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()};
  const std::uint64_t kind = random() % 3;
  if (kind == 0) return kSpecial[random() % kSpecial.size()];
  if (kind == 1) return uniform(random, -1.0, 1.0);
  const std::uint64_t bits = random();
  double value = 0.0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}
Vector3d any_vector(std::mt19937_64& random) {
  const double x = any_double(random), y = any_double(random), z = any_double(random);
  return {x, y, z};
}

// Whatever the bits: forces and moments are finite and within what pull and poke may have; the target is a pose, within
// its limits and speeds of the task's.
TEST(LiveHands, AreBoundedForAnyBits) {
  const Model model = build_model(still_box());
  const double arm_m = model.object.bounds().min().cwiseAbs().cwiseMax(model.object.bounds().max().cwiseAbs()).norm();
  const double step_s = model.scene.step_s;
  std::mt19937_64 random(2);
  LiveHands hands(model);
  State state(model);
  Vector3d shift_before = Vector3d::Zero();
  int pulled = 0, poked = 0;
  for (int i = 0; i < 200'000; ++i) {
    LiveInput input;
    input.number = static_cast<std::int64_t>(random());
    input.stamp_ns = static_cast<std::int64_t>(random());
    input.pull_heard_ns = random() % 2 == 0 ? kNow_ns : static_cast<std::int64_t>(random());
    input.pokes = random() % 50 == 0 ? i : static_cast<std::int64_t>(random() % 100);
    if (random() % 2 == 0) input.pull = LiveInput::Pull{any_vector(random), any_vector(random)};
    input.poke_N = any_vector(random);
    input.target_shift_m = any_vector(random);
    input.target_turn_rad = any_vector(random);
    const std::int64_t now_ns = random() % 2 == 0 ? kNow_ns : static_cast<std::int64_t>(random());
    if (i % 1000 == 0) {
      state.X_WO.linear() = random_rotation(random);
      state.X_WO.translation() = uniform(random, 0.0, 1e3) * random_direction(random);  // lost, and far away
    }
    const TickInput tick = hands.next(input, state, now_ns);
    ASSERT_TRUE(tick.wrench.allFinite());
    ASSERT_LE(tick.wrench.head<3>().norm(), (kPullLimit_N + kPokeLimit_N) * (1.0 + 1e-12));
    ASSERT_LE(tick.wrench.tail<3>().norm(), kPullLimit_N * arm_m * (1.0 + 1e-9));
    pulled += hands.pull().has_value();
    poked += tick.wrench.norm() > 0.0 && !hands.pull();
    ASSERT_TRUE(!hands.pull() || hands.pull()->force_N.allFinite());
    const Vector3d task = model.target(step_s).translation();
    const Vector3d shift = tick.X_WT ? Vector3d(tick.X_WT->translation() - task) : Vector3d::Zero();
    ASSERT_TRUE(!tick.X_WT || tick.X_WT->matrix().allFinite());
    ASSERT_LE(shift.norm(), std::sqrt(3.0) * kShiftLimit_m + 1e-9);
    ASSERT_LE((shift - shift_before).norm(), kShiftSpeed_m_per_s * step_s + 1e-9);
    if (tick.X_WT) {
      const Eigen::Matrix3d R = tick.X_WT->linear();
      ASSERT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-5);  // the file's is rounded
      ASSERT_LE(Eigen::AngleAxisd(R * model.scene.object.X_WO.linear().transpose()).angle(),
                std::sqrt(3.0) * kTurnLimit_rad + 1e-5);
    }
    shift_before = shift;
  }
  EXPECT_GT(pulled, 1000);
  EXPECT_GT(poked, 1000);
}

TEST(LiveHands, TakeNoMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  const Model model = build_model(still_box());
  LiveHands hands(model);
  State state(model);
  LiveInput input = pull_at(Vector3d::Zero(), Vector3d::Zero());
  input.pokes = 1;
  input.target_turn_rad = input.target_shift_m = input.poke_N = Vector3d::Constant(0.1);
  const AllocationCounter counter;
  for (; state.tick < 100; ++state.tick) std::ignore = hands.next(input, state, kNow_ns);
  EXPECT_EQ(counter.count(), 0);
}

class PulledBox : public testing::TestWithParam<const char*> {};

// What the controller's springs hold against: without integrals the box, pulled at its centre, gives way by F / p, and
// F is the pull's own law there. Let go, it comes back. 5 % is what page and loop are to agree within; the residual
// creep of the force loop is less.
TEST_P(PulledBox, GivesWayByForceOverStiffness) {
  const Model model =
      build_model(still_box({GetParam(), "control.position.i=0 N/(m*s)", "control.rotation.i=0 N*m/(rad*s)"}));
  const double p = model.scene.control->position.p;
  for (int axis = 0; axis < 3; ++axis) {
    GraspRun loops(model, LockstepSettings{});
    LiveHands hands(model);
    run(loops, hands, {}, model, 1.0);
    const Vector3d rest = loops.state.X_WO.translation();
    const Vector3d way = 8e-3 * model.scene.object.X_WO.linear().col(axis);
    run(loops, hands, pull_at(Vector3d::Zero(), rest + way), model, 2.0);
    const Vector3d moved = loops.state.X_WO.translation() - rest;
    const Vector3d force = hands.pull()->force_N;
    EXPECT_LT((moved - force / p).norm(), 0.05 * (force / p).norm()) << axis;
    EXPECT_NEAR(force.norm(), way.norm() / (1.0 / kPullStiffness_N_per_m + 1.0 / p), 0.05 * force.norm()) << axis;
    run(loops, hands, {}, model, 1.0);
    EXPECT_LT((loops.state.X_WO.translation() - rest).norm(), 0.05 * (force / p).norm()) << axis;
  }
}

// With them it goes back to its target while it is pulled.
TEST_P(PulledBox, ReturnsWithTheIntegral) {
  const Model model = build_model(still_box({GetParam()}));
  GraspRun loops(model, LockstepSettings{});
  LiveHands hands(model);
  run(loops, hands, {}, model, 1.0);
  const Vector3d target = model.target(0.0).translation();
  const LiveInput input = pull_at(Vector3d::Zero(), target + Vector3d(5e-3, 5e-3, 0.0));
  run(loops, hands, input, model, 0.1);
  EXPECT_GT((loops.state.X_WO.translation() - target).norm(), 0.2e-3);
  run(loops, hands, input, model, 4.0);
  EXPECT_LT((loops.state.X_WO.translation() - target).norm(), 0.05e-3);
  EXPECT_NEAR(hands.pull()->force_N.norm(), 0.5 * std::sqrt(2.0), 0.02);
}

// The limit's force at an edge of the box, and a poke: the box is held, and comes to rest.
TEST_P(PulledBox, IsHeldAndComesToRest) {
  const Model model = build_model(still_box({GetParam()}));
  GraspRun loops(model, LockstepSettings{});
  LiveHands hands(model);
  run(loops, hands, {}, model, 0.5);
  LiveInput input = pull_at({0.0, 0.025, 0.0}, loops.state.X_WO * Vector3d(0.0, 0.125, 0.0));
  input.pokes = 1;
  input.poke_N = Vector3d(0.0, 0.0, 3.0);
  run(loops, hands, input, model, 2.0);
  const State before = loops.state;
  run(loops, hands, input, model, 0.1);
  EXPECT_LT((loops.state.X_WO.translation() - before.X_WO.translation()).norm(), 0.1e-3);
  EXPECT_LT((loops.state.X_WO.translation() - model.target(0.0).translation()).norm(), 5e-3);
  for (const FingerLoad& load : loops.state.load) EXPECT_GT(load.normal_N, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Rates, PulledBox, testing::Values("time.step=1 ms", "time.step=0.25 ms"),
                         [](const auto& rate) { return rate.index == 0 ? "OneKilohertz" : "FourKilohertz"; });

TEST(LiveHands, GiveTheSameBitsForTheSameInput) {
  const Model model = build_model(still_box());
  const auto end = [&] {
    GraspRun loops(model, LockstepSettings{});
    LiveHands hands(model);
    LiveInput input = pull_at({0.01, 0.0, 0.02}, model.scene.object.X_WO.translation() + Vector3d(0.0, 0.0, 0.01));
    input.target_shift_m = Vector3d(0.0, 0.01, 0.0);
    input.pokes = 1;
    input.poke_N = Vector3d(1.0, 0.0, 0.0);
    run(loops, hands, input, model, 0.5);
    return loops.state;
  };
  const State a = end(), b = end();
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.X_WO.matrix(), b.X_WO.matrix());
}

}  // namespace
}  // namespace thenar::live_input_test
