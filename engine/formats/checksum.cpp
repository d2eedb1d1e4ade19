// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/checksum.h"

#include <boost/crc.hpp>

namespace thenar {

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) {
  // A remainder that is reflected and negated: to go on, both are undone.
  using Steps = boost::crc_optimal<32, 0x04C11DB7, 0, 0xFFFFFFFF, true, true>;
  const auto reflected = [](std::uint32_t bits) {
    std::uint32_t turned = 0;
    for (int i = 0; i < 32; ++i) turned |= (bits >> i & 1U) << (31 - i);
    return turned;
  };
  Steps steps(reflected(~before));
  steps.process_bytes(bytes.data(), bytes.size());
  return steps.checksum();
}

}  // namespace thenar
