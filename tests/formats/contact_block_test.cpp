// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/contact_block.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace thenar::contact_block_test {
namespace {

ContactBlock some_block(std::uint32_t contacts, std::uint32_t ticks) {
  std::mt19937 random(1);
  std::normal_distribution<float> number;
  ContactBlock block;
  block.time_s = 0.25;
  block.step_s = 1e-3;
  block.contacts = contacts;
  std::vector<TickContact> tick(contacts);
  for (std::uint32_t t = 0; t < ticks; ++t) {
    for (std::uint32_t i = 0; i < contacts; ++i) {
      TickContact& row = tick[i];
      row.finger = static_cast<std::uint16_t>(i % 5);
      row.control_point = static_cast<std::uint16_t>(1000 + i);
      for (float& x : row.force_N) x = number(random);
      for (float& x : row.slip_m) x = 1e-6F * number(random);
      if (t > 0) continue;
      for (auto* v : {row.point_m, row.normal, row.tangent}) {
        for (int axis = 0; axis < 3; ++axis) v[axis] = number(random);
      }
    }
    block.add(tick);
  }
  return block;
}

TEST(ContactBlock, ReadsBackToTheBit) {
  for (const auto [contacts, ticks] : {std::array<std::uint32_t, 2>{60, 20}, {1, 1}, {0, 3}}) {
    const ContactBlock block = some_block(contacts, ticks);
    const ContactBlock back = read_contact_block(contact_block_message(block));
    EXPECT_EQ(back.time_s, block.time_s);
    EXPECT_EQ(back.step_s, block.step_s);
    ASSERT_EQ(back.contacts, contacts);
    ASSERT_EQ(back.ticks, ticks);
    ASSERT_EQ(back.rows.size(), block.rows.size());
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      const TickContact &a = back.rows[i], &b = block.rows[i];
      EXPECT_EQ(a.finger, b.finger);
      EXPECT_EQ(a.control_point, b.control_point);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(a.force_N[axis], b.force_N[axis]);
        EXPECT_EQ(a.point_m[axis], b.point_m[axis]);
        EXPECT_EQ(a.normal[axis], b.normal[axis]);
        EXPECT_EQ(a.tangent[axis], b.tangent[axis]);
      }
      for (int axis = 0; axis < 2; ++axis) EXPECT_EQ(a.slip_m[axis], b.slip_m[axis]);
    }
  }
}

TEST(ContactBlock, IsNoneOfOtherBytes) {
  const std::string bytes = contact_block_message(some_block(3, 4));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(read_contact_block(bytes.substr(0, size)).ticks, 0U) << size;
  }
  for (const std::size_t at : {4, 6, 24, 27, 28, 31}) {  // Version, kind, the two counts.
    std::string wrong = bytes;
    wrong[at] ^= '\x40';
    EXPECT_EQ(read_contact_block(wrong).ticks, 0U) << at;
  }
}

}  // namespace
}  // namespace thenar::contact_block_test
