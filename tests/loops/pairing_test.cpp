// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/pairing.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace thenar::pairing_test {
namespace {

ContactSample contact(std::int64_t tick, std::int64_t sequence) {
  ContactSample sample;
  sample.after.tick = tick;
  sample.step.tick.sequence = sequence;
  return sample;
}
ControlSample control(std::int64_t sequence, bool published = true) {
  ControlSample sample;
  sample.step.sequence = sequence;
  sample.step.published = published;
  return sample;
}

using Pairs = std::vector<std::pair<std::int64_t, std::int64_t>>;  // tick, sequence

// Whichever record comes first: a tick is given once its control tick is known, or when no more will come.
TEST(Pairing, GivesEachTickWithTheControlTickOfItsFrame) {
  Pairs ticks, controls;
  Pairing pairing(
      [&](const ContactSample& tick, const ControlSample& of) {
        ticks.emplace_back(tick.after.tick, of.step.sequence);
        return true;
      },
      [&](const ContactSample& tick, const ControlSample& of) {
        controls.emplace_back(tick.after.tick, of.step.sequence);
      });
  pairing.start(control(0));
  pairing.add(contact(1, 0));
  pairing.add(contact(2, 1));  // its control tick has yet to come
  EXPECT_EQ(ticks, (Pairs{{1, 0}}));
  pairing.add(control(1));
  EXPECT_EQ(ticks, (Pairs{{1, 0}, {2, 1}}));
  pairing.add(control(2, false));  // no frame of it
  pairing.add(control(3));
  pairing.add(control(4));
  pairing.add(contact(3, 4));  // 3 was overtaken
  EXPECT_EQ(ticks.back(), (std::pair<std::int64_t, std::int64_t>{3, 4}));
  pairing.add(contact(4, 5));
  EXPECT_EQ(ticks.size(), 3);
  pairing.finish();
  EXPECT_EQ(ticks.size(), 4);
  EXPECT_EQ(pairing.in_use().step.sequence, 4);
  EXPECT_EQ(controls, (Pairs{{2, 1}, {3, 3}, {3, 4}}));
}

TEST(Pairing, GivesNoMoreWhenItsReceiverHasEnough) {
  int given = 0;
  Pairing pairing([&](const ContactSample&, const ControlSample&) { return ++given < 2; });
  pairing.start(control(0));
  for (int tick = 1; tick < 5; ++tick) pairing.add(contact(tick, 0));
  EXPECT_EQ(given, 2);
}

// A recorder whose disk is full throws; what is said after it must not hand it the same tick again.
TEST(Pairing, GivesNoTickTwiceWhenItsReceiverThrows) {
  std::vector<std::int64_t> given;
  Pairing pairing([&](const ContactSample& tick, const ControlSample&) {
    given.push_back(tick.after.tick);
    if (tick.after.tick == 2) throw std::runtime_error("full");
    return true;
  });
  pairing.start(control(0));
  pairing.add(contact(1, 0));
  EXPECT_THROW(pairing.add(contact(2, 0)), std::runtime_error);
  pairing.add(contact(3, 0));
  pairing.finish();
  EXPECT_EQ(given, (std::vector<std::int64_t>{1, 2, 3}));
}

}  // namespace
}  // namespace thenar::pairing_test
