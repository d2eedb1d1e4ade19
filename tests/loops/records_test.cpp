// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/records.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace thenar::records_test {
namespace {

/// Counts the records that are alive, and is destroyed once: a second time would free its memory again.
struct Owner {
  explicit Owner(std::int64_t n = 0) : numbers(4, n) { ++alive; }
  Owner(const Owner& other) : numbers(other.numbers) { ++alive; }
  Owner& operator=(const Owner&) = default;
  ~Owner() { --alive; }

  std::vector<std::int64_t> numbers;
  static inline std::atomic<int> alive{0};
};

// Wherever a receiver throws, each record comes to it once or stays, and each is destroyed once.
TEST(Records, LoseNothingWhenTheReceiverThrows) {
  constexpr int kRoom = 7;
  for (int throws_at = 0; throws_at < kRoom; ++throws_at) {
    SCOPED_TRACE(testing::Message() << "throws at record " << throws_at);
    {
      Records<Owner> records(kRoom, Owner());
      const int blanks = Owner::alive;
      // So that the ring's end comes at another record each time.
      for (int i = 0; i < throws_at; ++i) records.keep(Owner(-1));
      records.drain([](const Owner&) {});
      for (int i = 0; i < kRoom; ++i) EXPECT_TRUE(records.keep(Owner(i)));
      EXPECT_FALSE(records.keep(Owner(kRoom)));
      std::int64_t next = 0;
      const auto receive = [&](const Owner& owner) {
        if (next == throws_at) throw std::runtime_error("enough");
        EXPECT_EQ(owner.numbers, std::vector<std::int64_t>(4, next));
        ++next;
      };
      EXPECT_THROW(records.drain(receive), std::runtime_error);
      EXPECT_EQ(next, throws_at);
      EXPECT_EQ(Owner::alive - blanks, kRoom - throws_at);
      // Those that stayed come to another one, and the first of them to nobody else.
      records.drain([&](const Owner& owner) { EXPECT_EQ(owner.numbers.front(), next++); });
      EXPECT_EQ(next, kRoom);
      EXPECT_EQ(Owner::alive - blanks, 0);
      EXPECT_TRUE(records.keep(Owner(0)));  // is destroyed with the ring
    }
    EXPECT_EQ(Owner::alive, 0);
  }
}

TEST(Records, PassWholeAndInOrderFromOneThreadToAnother) {
  constexpr std::int64_t kRecords = 50'000;
  {
    Records<Owner> records(64, Owner());
    std::int64_t next = 0, broken = 0;
    std::thread writer([&] {
      for (std::int64_t n = 0; n < kRecords; ++n) {
        while (!records.keep(Owner(n))) std::this_thread::yield();
      }
    });
    while (next < kRecords) {
      records.drain([&](const Owner& owner) {
        if (owner.numbers != std::vector<std::int64_t>(4, next)) ++broken;
        ++next;
      });
    }
    writer.join();
    EXPECT_EQ(broken, 0);
  }
  EXPECT_EQ(Owner::alive, 0);
}

}  // namespace
}  // namespace thenar::records_test
