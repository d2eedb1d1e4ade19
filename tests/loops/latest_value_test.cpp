// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/latest_value.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <random>
#include <thread>
#include <type_traits>
#include <vector>

#include "tests/support/allocation_counter.h"

namespace thenar::latest_value_test {
namespace {

TEST(LatestValue, MakesItsSlotsFromArguments) {
  struct Sized {
    explicit Sized(int n) : numbers(n) {}
    std::vector<double> numbers;
  };
  static_assert(!std::is_default_constructible_v<Sized>);
  LatestValue<Sized> buffer(7);
  EXPECT_EQ(buffer.current().numbers.size(), 7U);
  for (int i = 0; i < 5; ++i) {  // more than there are slots
    EXPECT_EQ(buffer.draft().numbers.size(), 7U);
    buffer.publish();
    buffer.take();
  }
}

// Against the law "the newest value published before the take", for random orders of calls on one thread.
TEST(LatestValue, GivesTheNewestValueAndAccountsForAll) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 200; ++run) {
    SCOPED_TRACE(testing::Message() << "seed 1, run " << run);
    LatestValue<int> buffer(0);
    int newest = 0, taken = 0;
    std::int64_t takes = 0;
    for (int call = 0; call < 100; ++call) {
      if (random() % 2 == 0) {
        buffer.draft() = ++newest;
        buffer.publish();
      } else {
        EXPECT_EQ(buffer.take(), taken != newest);
        if (taken != newest) ++takes;
        taken = newest;
      }
      EXPECT_EQ(buffer.current(), taken);
      const ExchangeCounts counts = buffer.counts();
      EXPECT_EQ(counts.published, newest);
      EXPECT_EQ(counts.consumed, takes);
      EXPECT_EQ(counts.in_flight, taken == newest ? 0 : 1);
      EXPECT_EQ(counts.unaccounted(), 0);
      EXPECT_EQ(counts.torn, 0);
    }
  }
}

TEST(LatestValue, KeepsWhatItsThreeUsersWriteOnLinesOfTheirOwn) {
  LatestValue<std::int64_t> buffer(0);
  std::vector<std::uintptr_t> slots;
  for (int i = 0; i < 3; ++i) {  // current() moves through all three slots
    buffer.publish();
    buffer.take();
    slots.push_back(reinterpret_cast<std::uintptr_t>(&buffer.current()));
  }
  std::sort(slots.begin(), slots.end());
  EXPECT_GE(slots[1] - slots[0], kSeparate);
  EXPECT_GE(slots[2] - slots[1], kSeparate);
  EXPECT_EQ(alignof(LatestValue<std::int64_t>), kSeparate);
}

// What the counter of torn values rests on: a slot whose writer came while its reader had it no longer holds the
// reader's number. Two slots must fail this way, which is why there are three.
TEST(LatestValue, StampsShowAWriterInTheReadersSlot) {
  std::array<Stamped<int>, 2> slots{Stamped<int>(0), Stamped<int>(0)};
  const auto write = [&slots](std::int64_t number) {
    Stamped<int>& slot = slots[number % 2];
    slot.begin(number);
    slot.value = static_cast<int>(number);
    slot.end(number);
  };
  write(1);
  const Stamped<int>& reading = slots[1];
  const std::int64_t number = reading.number_written();
  EXPECT_TRUE(reading.holds(number));
  write(2);
  EXPECT_TRUE(reading.holds(number));  // the other slot
  slots[1].begin(3);
  EXPECT_FALSE(reading.holds(number));                    // given back: it was written meanwhile
  EXPECT_FALSE(reading.holds(reading.number_written()));  // taken now: half written
  slots[1].end(3);
  EXPECT_FALSE(reading.holds(number));
  EXPECT_TRUE(reading.holds(reading.number_written()));
}

/// 400 bytes that agree with each other.
struct Block {
  std::array<std::int64_t, 50> numbers{};
  void fill(std::int64_t n) {
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = n * static_cast<std::int64_t>(i + 1);
  }
  [[nodiscard]] bool is_whole() const {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] != numbers[0] * static_cast<std::int64_t>(i + 1)) return false;
    }
    return true;
  }
};

TEST(LatestValue, LosesAndTearsNothingBetweenTwoThreads) {
  constexpr std::int64_t kPublishes = 1'000'000;
  constexpr std::int64_t kTakes = 1'000;  // or the test has seen nothing
  const auto buffer = std::make_unique<LatestValue<Block>>();
  std::atomic<std::int64_t> taken{0}, last{0};

  std::thread writer([&] {
    std::int64_t n = 0;
    while (n < kPublishes || taken.load(std::memory_order_relaxed) < kTakes) {
      buffer->draft().fill(++n);
      buffer->publish();
    }
    last.store(n, std::memory_order_relaxed);
  });
  std::int64_t broken = 0, disordered = 0, changed = 0, seen = 0;
  while (seen == 0 || seen != last.load(std::memory_order_relaxed)) {
    if (!buffer->take()) continue;
    taken.fetch_add(1, std::memory_order_relaxed);
    const std::int64_t number = buffer->current().numbers[0];
    if (number <= seen) ++disordered;
    if (!buffer->current().is_whole()) ++broken;
    // The compiler must not take what has been read for what is there now: this reads the value once more.
    std::atomic_signal_fence(std::memory_order_seq_cst);
    if (buffer->current().numbers[0] != number || !buffer->current().is_whole()) ++changed;
    seen = number;
  }
  writer.join();

  EXPECT_EQ(broken, 0);
  EXPECT_EQ(disordered, 0);
  EXPECT_EQ(changed, 0);
  const ExchangeCounts counts = buffer->counts();
  EXPECT_EQ(seen, counts.published);  // the last value arrives
  EXPECT_GE(counts.published, kPublishes);
  EXPECT_EQ(counts.consumed, taken.load());
  EXPECT_EQ(counts.in_flight, 0);
  EXPECT_EQ(counts.unaccounted(), 0);
  EXPECT_EQ(counts.torn, 0);
}

TEST(LatestValue, DraftsKeepTheirMemory) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  LatestValue<std::vector<double>> buffer(std::vector<double>(100));
  const AllocationCounter counter;
  for (int i = 0; i < 100; ++i) {
    buffer.draft().assign(static_cast<std::size_t>(i), 1.0);
    buffer.publish();
    if (i % 3 == 0) buffer.take();
  }
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace thenar::latest_value_test
