// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

/// The records of MCAP files (mcap.dev, version 0), for their writer and their reader.
namespace thenar::mcap {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian");

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t kRecordHead = 9;  ///< Kind and length.
enum Kind : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd = 15
};

/// A builder of a record's bytes, part by part.
class Bytes {
 public:
  template <class Number>
  Bytes& number(Number value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  /// Appends a text, map or array after its length.
  Bytes& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    return raw(text);
  }
  Bytes& raw(std::string_view raw) {
    bytes_ += raw;
    return *this;
  }
  [[nodiscard]] const std::string& done() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Appends a record.
inline void append_record(std::string& to, Kind kind, std::string_view bytes) {
  to += Bytes().number(static_cast<std::uint8_t>(kind)).number(std::uint64_t{bytes.size()}).done();
  to += bytes;
}

/// A sequential reader of a record's bytes; a read past their end is noted and returns zero.
class Parts {
 public:
  explicit Parts(std::string_view bytes) : rest_(bytes) {}

  template <class Number>
  Number number() {
    Number value{};
    const std::string_view bytes = take(sizeof value);
    if (bytes.size() == sizeof value) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  std::string_view take(std::uint64_t size) {
    if (size > rest_.size()) {
      ended_early_ = true;
      size = 0;
    }
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] bool ended_early() const { return ended_early_; }

 private:
  std::string_view rest_;
  bool ended_early_ = false;
};

}  // namespace thenar::mcap
