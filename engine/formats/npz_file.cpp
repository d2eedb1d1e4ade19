// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/npz_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "engine/formats/checksum.h"

namespace thenar {

namespace {

static_assert(std::endian::native == std::endian::little, "ZIP is little-endian, and so are our arrays");

void append_u16(std::string& to, std::size_t number) {
  to += {static_cast<char>(number & 0xFF), static_cast<char>(number >> 8 & 0xFF)};
}

void append_u32(std::string& to, std::size_t number) {
  append_u16(to, number & 0xFFFF);
  append_u16(to, number >> 16 & 0xFFFF);
}

/// Returns the header before an array's numbers, padded to a multiple of 64 bytes.
std::string npy_head(const std::vector<std::size_t>& shape, const std::string& type) {
  std::string sides;
  for (const std::size_t side : shape) sides += fmt::format("{}, ", side);
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, sides);
  constexpr std::size_t kBefore = 10, kMultiple = 64;
  text.append((kMultiple - (kBefore + text.size() + 1) % kMultiple) % kMultiple, ' ').push_back('\n');
  std::string head("\x93NUMPY\x01\x00", 8);
  append_u16(head, text.size());
  return head + text;
}

/// Decodes the code points of UTF-8; invalid bytes become question marks.
std::u32string code_points(std::string_view text) {
  std::u32string points;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t more = first < 0x80 ? 0 : first < 0xC0 ? 8 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    if (i + more >= text.size()) return points + U"?";
    char32_t point = more == 0 ? first : first & (0x3FU >> more);
    for (std::size_t k = 1; k <= more; ++k) point = point << 6 | (static_cast<unsigned char>(text[i + k]) & 0x3FU);
    points += point;
    i += more + 1;
  }
  return points;
}

}  // namespace

void NpzArchive::add_names(const std::string& name, const std::vector<std::string>& names) {
  std::vector<std::u32string> texts;
  std::size_t longest = 1;
  for (const std::string& text : names) {
    texts.push_back(code_points(text));
    longest = std::max(longest, texts.back().size());
  }
  std::string bytes;
  for (std::u32string& text : texts) {
    text.resize(longest, U'\0');
    bytes.append(reinterpret_cast<const char*>(text.data()), sizeof(char32_t) * longest);
  }
  add_bytes(name, {names.size()}, fmt::format("<U{}", longest), bytes);
}

void NpzArchive::add_bytes(const std::string& name, const std::vector<std::size_t>& shape, const std::string& type,
                           std::string_view bytes) {
  const std::string file = name + ".npy", head = npy_head(shape, type);
  const std::size_t size = head.size() + bytes.size(), begin = bytes_.size();
  // Version, no flags, stored, of no date (the first day of 1980), checksum, sizes, the name's length, nothing more.
  std::string common;
  append_u16(common, 20);
  append_u32(common, 0);
  append_u16(common, 0);
  append_u16(common, 1 << 5 | 1);
  append_u32(common, crc32(bytes, crc32(head)));
  append_u32(common, size);
  append_u32(common, size);
  append_u16(common, file.size());
  append_u16(common, 0);
  bytes_.append("PK\x03\x04").append(common).append(file).append(head).append(bytes);
  directory_ += "PK\x01\x02";
  append_u16(directory_, 20);
  directory_ += common;
  append_u16(directory_, 0);
  append_u32(directory_, 0);
  append_u32(directory_, 0);
  append_u32(directory_, begin);
  directory_ += file;
  ++entries_;
}

std::optional<std::string> NpzArchive::finish() {
  const std::size_t begin = bytes_.size();
  if (begin + directory_.size() >= std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  bytes_ += directory_;
  bytes_ += "PK\x05\x06";
  append_u32(bytes_, 0);
  append_u16(bytes_, entries_);
  append_u16(bytes_, entries_);
  append_u32(bytes_, directory_.size());
  append_u32(bytes_, begin);
  append_u16(bytes_, 0);
  return std::exchange(bytes_, {});
}

}  // namespace thenar
