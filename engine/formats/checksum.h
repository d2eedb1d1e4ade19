// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace thenar {

/// Returns the CRC-32 of bytes (as in zip, PNG and MCAP). `before`: that of the preceding bytes; 0: there are none.
[[nodiscard]] std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace thenar
