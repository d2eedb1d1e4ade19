#pragma once

#include <cstdint>
#include <string_view>

namespace thenar {

/// The CRC-32 of bytes (that of zip, PNG and MCAP). `before`: of the bytes that they follow; 0: of none.
[[nodiscard]] std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace thenar
