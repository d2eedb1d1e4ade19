// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/slot_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <thread>
#include <vector>

namespace thenar::slot_ring_test {
namespace {

using Numbers = std::vector<std::int64_t>;

SlotRing<Numbers> ring(std::size_t room) {
  return SlotRing<Numbers>(room, [] { return Numbers(16, -1); });
}

TEST(SlotRing, HasRoomForWhatItSaysAndKeepsOrder) {
  SlotRing<Numbers> slots = ring(3);
  EXPECT_EQ(slots.front(), nullptr);
  for (std::int64_t round = 0; round < 10; ++round) {
    for (std::int64_t i = 0; i < 3; ++i) {
      Numbers* const to = slots.draft();
      ASSERT_NE(to, nullptr);
      EXPECT_EQ(slots.draft(), to) << "one at a time";
      to->front() = 3 * round + i;
      slots.publish();
    }
    EXPECT_EQ(slots.draft(), nullptr);
    for (std::int64_t i = 0; i < 3; ++i) {
      ASSERT_NE(slots.front(), nullptr);
      EXPECT_EQ(slots.front()->front(), 3 * round + i);
      slots.pop();
    }
    EXPECT_EQ(slots.front(), nullptr);
  }
}

// Whole and in order; what finds no room is known to the writer.
TEST(SlotRing, PassesWholeValuesFromOneThreadToAnother) {
  constexpr std::int64_t kValues = 50'000;
  SlotRing<Numbers> slots = ring(8);
  std::int64_t lost = 0;
  std::jthread writer([&] {
    for (std::int64_t i = 0; i <= kValues; ++i) {
      Numbers* to = slots.draft();
      // The last one is waited for: by it the reader knows the end.
      for (; to == nullptr && i == kValues; to = slots.draft()) std::this_thread::yield();
      if (to == nullptr) {
        ++lost;
        continue;
      }
      std::fill(to->begin(), to->end(), i);
      slots.publish();
    }
  });
  std::int64_t received = 0, last = -1;
  while (last < kValues) {
    const Numbers* const from = slots.front();
    if (from == nullptr) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_GT(from->front(), last);
    last = from->front();
    EXPECT_EQ(std::count(from->begin(), from->end(), last), 16);
    ++received;
    slots.pop();
  }
  writer.join();
  EXPECT_EQ(received + lost, kValues + 1);
}

}  // namespace
}  // namespace thenar::slot_ring_test
