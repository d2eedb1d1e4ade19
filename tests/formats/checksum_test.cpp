// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/checksum.h"

#include <gtest/gtest.h>

#include <string>

namespace thenar::checksum_test {
namespace {

// The check value of the CRC-32 of zip (ITU-T V.42): that of the nine digits.
TEST(Checksum, IsThatOfZip) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926U);
  EXPECT_EQ(crc32(""), 0U);
}

TEST(Checksum, GoesOnWhereverItWasLeft) {
  const std::string whole = "The quick brown fox jumps over the lazy dog";
  for (std::size_t i = 0; i <= whole.size(); ++i) {
    EXPECT_EQ(crc32(whole.substr(i), crc32(whole.substr(0, i))), crc32(whole)) << i;
  }
}

}  // namespace
}  // namespace thenar::checksum_test
