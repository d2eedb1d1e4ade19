#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace thenar {

/// What became of the values that went through a LatestValue. published = consumed + superseded + in flight.
struct ExchangeCounts {
  std::int64_t published = 0;
  std::int64_t consumed = 0;    ///< Taken by the reader.
  std::int64_t superseded = 0;  ///< Overwritten before the reader looked.
  std::int64_t in_flight = 0;   ///< Published and not yet taken: 0 or 1.
  std::int64_t torn = 0;        ///< Taken while half written: none, unless the protocol is broken.
  [[nodiscard]] std::int64_t unaccounted() const { return published - consumed - superseded - in_flight; }
};

}  // namespace thenar
