// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/handover.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

#include "engine/grasp/compliance.h"
#include "engine/grasp/contact_tick.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/grasp/moving_grasp.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::handover_test {
namespace {

using namespace moving_grasp;

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a bad sensor makes of frames.
struct Noise {
  double gap_m = 0.0, normal_rad = 0.0;  ///< Standard deviations, of each contact by itself.
  double drop = 0.0;                     ///< The share of the loaded contacts that a frame misses.
};

bool is_loaded(const State& state, const FrameContact& contact) {
  return std::any_of(state.forces.begin(), state.forces.end(), [&](const ContactForce& force) {
    return force.finger == contact.finger && force.control_point == contact.control_point && force.f_C[0] > 0.0;
  });
}

void spoil(const Model& model, const State& state, const Noise& noise, std::mt19937_64& random, Frame& frame) {
  std::normal_distribution<double> normal;
  std::vector<FrameContact> kept;
  std::vector<Index> begin(kFingers + 1);
  for (int k = 0; k < kFingers; ++k) {
    const Matrix3d R_FO = frame.X_WF[k].linear().transpose() * frame.X_WO.linear();
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      FrameContact contact = frame.contacts[i];
      if (is_loaded(state, contact) && uniform(random, 0.0, 1.0) < noise.drop) continue;
      contact.s_O += noise.gap_m * normal(random) * contact.n_O;
      const Vector3d across = contact.n_O.cross(random_direction(random)).normalized();
      const Eigen::AngleAxisd tilt(noise.normal_rad * normal(random), across);
      contact.n_O = tilt * contact.n_O;
      contact.E_F = R_FO * tilt.toRotationMatrix() * R_FO.transpose() * contact.E_F;
      kept.push_back(contact);
    }
    begin[k + 1] = std::ssize(kept);
  }
  frame.contacts = std::move(kept);
  frame.begin = begin;
  fill_kernels(model, frame);
}

/// The largest steps of a finger's force between ticks, at hand-overs and elsewhere [N], and the energy by its sign
/// [J], from 0.2 s on.
struct Steps {
  double handover_N = 0.0, other_N = 0.0;
  double injected_J = 0.0, dissipated_J = 0.0;
  int handovers = 0;
};

/// The sticking scene with noisy frames every 5 ms. No controller: but for the noise, forces hardly change.
Steps steps_of(const Noise& noise, bool offset, std::uint64_t seed) {
  const Model model = build_model(scene_of("stick", {"time.control_period=5 ms"}));
  std::mt19937_64 random(seed);
  LockstepSettings settings;
  const State* state = nullptr;
  settings.channel = [&](double time_s, Frame& frame) {
    if (time_s > 0.1) spoil(model, *state, noise, random, frame);
    return true;
  };
  GraspRun loops(model, settings);
  state = &loops.state;
  if (!offset) loops.memory.policy.offset_decay_s = 0.0;
  Steps steps;
  while (loops.state.tick < 1000) {
    const auto before = loops.state.load;
    const TickReport report = loops.tick();
    if (loops.state.tick < 200) continue;
    double& largest_N = report.handed_over ? steps.handover_N : steps.other_N;
    for (int k = 0; k < kFingers; ++k) {
      largest_N = std::max(largest_N, (loops.state.load[k].force_N - before[k].force_N).norm());
    }
    steps.injected_J += report.ledger.injected_J;
    steps.dissipated_J += report.ledger.dissipated_J;
    steps.handovers += report.handed_over ? 1 : 0;
  }
  return steps;
}

constexpr Noise kNoisy{.gap_m = 20e-6, .normal_rad = 0.01745};  // 20 um and 1 degree

// 20 um of gap noise are a tenth of what the pulps are pressed in: taken over at once, it throws the forces about at
// every hand-over. With the offset the noise comes in little by little, and a hand-over is no rougher than what lies
// between: the bound is two ordinary ticks.
TEST(HandOver, NoiseOfFramesIsNoBump) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Steps with = steps_of(kNoisy, true, seed), without = steps_of(kNoisy, false, seed);
    ASSERT_GT(with.handovers, 150);
    EXPECT_LE(with.handover_N, 2.0 * with.other_N);
    EXPECT_LE(with.handover_N, 0.25 * without.handover_N);
    EXPECT_LE(with.other_N, 0.5 * without.other_N) << "the offset must not just spread the bump";
  }
}

// A frame that misses every tenth loaded contact moves a tenth of the grip to the others, which no offset can hide.
TEST(HandOver, DroppedContactsAreASmallBump) {
  Noise noise = kNoisy;
  noise.drop = 0.1;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Steps with = steps_of(noise, true, seed), without = steps_of(noise, false, seed);
    EXPECT_LE(with.handover_N, 5.0 * with.other_N);
    EXPECT_LE(with.handover_N, 0.7 * without.handover_N);
    EXPECT_LE(with.other_N, 0.5 * without.other_N);
  }
}

// Noise that closes a gap presses bodies apart: energy from nowhere. The offset lets in what decays of it while it
// works: less than a half of it, contact by contact.
TEST(HandOver, OffsetKeepsTheEnergyOfNoiseOut) {
  const Steps with = steps_of(kNoisy, true, 4), without = steps_of(kNoisy, false, 4);
  ASSERT_GT(without.handovers, 150);
  EXPECT_GT(without.injected_J, 1e-3);
  EXPECT_LE(with.injected_J, 0.5 * without.injected_J);
}

// What a finger presses with does not change because a frame misses some of its contacts: their forces go to the
// loaded ones that are left, by the pulp's kernel.
TEST(CarryForces, GivesTheForceOfLostContactsToTheirFinger) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(50e-3);
  std::mt19937_64 random(5);
  Frame fewer = loop.frame;
  spoil(loop.model, loop.state, {.drop = 0.3}, random, fewer);
  ASSERT_LT(fewer.size(), loop.frame.size() - 5);
  Eigen::VectorXd f(3 * loop.model.max_contacts);
  carry_forces(loop.model, fewer, loop.state.forces, f);
  for (int k = 0; k < kFingers; ++k) {
    Vector3d before = Vector3d::Zero(), after = Vector3d::Zero();
    for (const ContactForce& force : loop.state.forces) {
      if (force.finger == k) before += force.f_C;
    }
    for (Index i = fewer.begin[k]; i < fewer.begin[k + 1]; ++i) after += f.segment<3>(3 * i);
    EXPECT_LE((after - before).norm(), 1e-14);
  }
}

// Elastic energy that no force gives back: f.u / 2 of each contact that a frame misses.
TEST(HandOver, BooksWhatDroppedContactsHeld) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(50e-3);
  std::mt19937_64 random(7);
  Frame fewer = loop.frame;
  spoil(loop.model, loop.state, {.drop = 0.3}, random, fewer);
  double expected_J = 0.0, all_J = 0.0;
  for (Index i = 0; i < loop.frame.size(); ++i) {
    const FrameContact& contact = loop.frame.contacts[i];
    const Vector3d f_F = loop.work.kinematics.E_F[i] * loop.memory.f.segment<3>(3 * i);
    const double held_J = 0.5 * f_F.dot(displacement(loop.state, contact));
    all_J += held_J;
    const bool is_kept = std::ranges::any_of(fewer.contacts, [&](const auto& c) { return id_of(c) == id_of(contact); });
    if (!is_kept) expected_J += held_J;
  }
  ASSERT_GT(expected_J, 0.05 * all_J);
  Frame same = loop.frame;
  ++same.sequence;
  fewer.sequence = same.sequence + 1;
  State state = loop.state;
  EXPECT_EQ(contact_tick(loop.model, same, loop.memory, loop.work, state).ledger.dropped_J, 0.0);
  EXPECT_NEAR(contact_tick(loop.model, fewer, loop.memory, loop.work, loop.state).ledger.dropped_J, expected_J,
              1e-12 * all_J);
}

TEST(HandOver, DoesNotAllocateWithNoisyFramesOrInAHold) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours to count";
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, "time.control_period=5 ms"}));
  State state(model);
  Frame frame(model);
  Controller controller(model);
  ContactMemory memory(model, split_policy(model.scene));
  ContactScratch work(model);
  std::mt19937_64 random(6);
  control_tick(model, state, controller, frame);
  contact_tick(model, frame, memory, work, state);
  std::int64_t allocations = 0, held = 0;
  while (state.tick < 300) {
    if (state.tick % 50 == 0) {  // late for a hold in between
      control_tick(model, state, controller, frame);
      spoil(model, state, {.gap_m = 20e-6, .normal_rad = 0.01745, .drop = 0.1}, random, frame);
    }
    const AllocationCounter counter;
    held += contact_tick(model, frame, memory, work, state).held ? 1 : 0;
    allocations += counter.count();
  }
  EXPECT_GT(held, 100);
  EXPECT_EQ(allocations, 0);
}

// A new frame finds the forces of the last tick by finger and control point. A tolerance that any guess meets keeps the
// solver from changing them; contacts without a force of their own start at zero.
TEST_F(MovingGrasp, ForcesAreCarriedToANewFrameById) {
  loop.run(50e-3);
  std::erase_if(loop.state.forces, [](const ContactForce& force) { return force.control_point % 3 == 0; });
  std::erase_if(loop.state.forces, [](const ContactForce& force) { return force.finger == 2; });
  const auto before = loop.state.forces;
  loop.model.scene.contact.tolerance = 1e9;
  loop.memory.change_N.setZero();  // Forces are to stay, not to go on as they changed.
  loop.control();
  contact_tick(model, loop.frame, loop.memory, loop.work, loop.state);

  ASSERT_EQ(std::ssize(loop.state.forces), loop.frame.size());
  int carried = 0;
  for (Index i = 0; i < loop.frame.size(); ++i) {
    const ContactForce& force = loop.state.forces[i];
    EXPECT_EQ(force.finger, loop.frame.contacts[i].finger);
    EXPECT_EQ(force.control_point, loop.frame.contacts[i].control_point);
    const auto same = std::find_if(before.begin(), before.end(), [&](const ContactForce& old) {
      return old.finger == force.finger && old.control_point == force.control_point;
    });
    const Vector3d expected = same == before.end() ? Vector3d(Vector3d::Zero()) : same->f_C;
    EXPECT_LE((force.f_C - expected).norm(), 1e-15);
    carried += expected[0] > 0.0 ? 1 : 0;
  }
  EXPECT_GT(carried, 5);
}

}  // namespace
}  // namespace thenar::handover_test
