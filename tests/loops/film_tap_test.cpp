// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/film_tap.h"

#include <gtest/gtest.h>

#include "engine/loops/live_contact.h"
#include "engine/loops/threads.h"
#include "engine/models/build_model.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::film_tap_test {
namespace {

// What is told of a contact is what moves the object: forces in the contact's axes, turned into the world, add up to
// the finger's load.
TEST(FilmTap, HasTheContactsOfATick) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(0.2);
  TickContacts tick(loop.model);
  take_contacts(loop.state, loop.memory, loop.work, tick);
  EXPECT_EQ(tick.tick, loop.state.tick);
  ASSERT_EQ(tick.count, loop.state.forces.size());
  ASSERT_GT(tick.count, 10U);
  for (int k = 0; k < loop.model.fingers(); ++k) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < tick.count; ++i) {
      const TickContact& contact = tick.contacts[i];
      if (contact.finger != k) continue;
      const Eigen::Vector3d n = Eigen::Map<const Eigen::Vector3f>(contact.normal).cast<double>(),
                            t1 = Eigen::Map<const Eigen::Vector3f>(contact.tangent).cast<double>();
      EXPECT_NEAR(n.dot(t1), 0.0, 1e-6);
      sum += contact.force_N[0] * n + contact.force_N[1] * t1 + contact.force_N[2] * n.cross(t1);
    }
    // Twenty floats of 24 bits each.
    EXPECT_LE((sum - loop.state.load[k].force_N).norm(), 20 * 6e-8 * loop.state.load[k].force_N.norm());
  }
}

// The contact thread's part takes no memory, also where there is no room, and what is lost is counted.
TEST(FilmTap, KeepsWithoutMemoryAndCountsWhatItLoses) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(0.2);
  FilmTap tap(loop.model, 10, true);
  constexpr int kTicks = 5000;
  const AllocationCounter counter;
  for (int i = 0; i < kTicks; ++i) {
    ++loop.state.tick;
    tap.keep(loop.state, loop.memory, loop.work, std::nullopt);
  }
  const std::int64_t taken = counter.count();
  EXPECT_EQ(taken, 0);
  std::int64_t pictures = 0, contacts = 0;
  for (; tap.pictures.front() != nullptr; tap.pictures.pop()) ++pictures;
  for (std::int64_t last = 0; const TickContacts* tick = tap.contacts.front(); tap.contacts.pop(), ++contacts) {
    EXPECT_TRUE(last == 0 || tick->tick == last + 1);
    last = tick->tick;
  }
  // A second of pictures and two of contacts have room, at 1 kHz.
  EXPECT_GE(pictures, 100);
  EXPECT_GE(contacts, 2000);
  EXPECT_LT(contacts, kTicks);
  EXPECT_EQ(pictures + tap.lost_pictures(), kTicks / 10);
  EXPECT_EQ(contacts + tap.lost_contacts(), kTicks);
}

// With the loop around it, as threads run it: every tick is kept, in order.
TEST(FilmTap, TakesNoMemoryOfAContactLoop) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox}));
  SplitGrasp grasp(model);
  LatestValue<LiveInput> nobody;
  LiveHands hands(model);
  LiveContact live(model, nobody, hands);
  FilmTap tap(model, 7, true);
  const auto run = [&](int ticks) {
    const std::stop_token never;
    return run_contact_loop(
               grasp, Schedule(steady_now_ns(), model.scene.step_s, ticks, ticks), 0,
               [](const ContactSample&) { return true; }, never, &live)
        .ticks;
  };
  ASSERT_EQ(run(20), 20);  // The first ticks of a state may take memory.
  live.tap = &tap;
  const AllocationCounter counter;
  const std::int64_t ticks = run(200), taken = counter.count();
  EXPECT_EQ(taken, 0);
  ASSERT_EQ(ticks, 200);
  for (std::int64_t tick = 21; tick <= 220; ++tick, tap.contacts.pop()) {
    ASSERT_NE(tap.contacts.front(), nullptr);
    EXPECT_EQ(tap.contacts.front()->tick, tick);
  }
  for (std::int64_t tick = 21; tick <= 217; tick += 7, tap.pictures.pop()) {
    ASSERT_NE(tap.pictures.front(), nullptr);
    EXPECT_EQ(tap.pictures.front()->snapshot.tick, tick);
  }
  EXPECT_EQ(tap.lost_pictures() + tap.lost_contacts(), 0);
}

TEST(FilmTap, FindsThePictureOfATick) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(0.1);
  FilmTap tap(loop.model, 1, false);
  EXPECT_EQ(tap.picture_of(1), nullptr);
  for (const std::int64_t tick : {3, 4, 6}) {
    loop.state.tick = tick;
    tap.keep(loop.state, loop.memory, loop.work, std::nullopt);
  }
  EXPECT_EQ(tap.picture_of(2), nullptr);
  ASSERT_NE(tap.picture_of(4), nullptr);
  EXPECT_EQ(tap.picture_of(4)->snapshot.tick, 4);
  tap.pictures.pop();
  EXPECT_EQ(tap.picture_of(5), nullptr);
  EXPECT_NE(tap.picture_of(6), nullptr);
  EXPECT_EQ(tap.contacts.front(), nullptr) << "nobody asked for them";
}

}  // namespace
}  // namespace thenar::film_tap_test
