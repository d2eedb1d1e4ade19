// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/contact_block.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

namespace thenar {

namespace {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

// The head of all messages: docs/reference/window.md.
constexpr std::string_view kBlockHead("THNR\x01\x00\x03\x00", 8);
constexpr std::size_t kFixedFloats = 9, kMovingFloats = 5;  // Floats of a contact: once per block, and in each tick.

template <class Number>
void append_number(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

template <class Number>
Number number_at(std::string_view bytes, std::size_t at) {
  Number number{};
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

/// Writes floats as four planes: all first bytes, then all second ones and so on. Similar bytes compress.
void append_planes(const std::vector<float>& floats, std::string& bytes) {
  const std::size_t begin = bytes.size(), n = floats.size();
  bytes.resize(begin + sizeof(float) * n);
  const char* const from = reinterpret_cast<const char*>(floats.data());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t plane = 0; plane < sizeof(float); ++plane) bytes[begin + plane * n + i] = from[4 * i + plane];
  }
}

std::vector<float> floats_of_planes(std::string_view bytes) {
  std::vector<float> floats(bytes.size() / sizeof(float));
  char* const to = reinterpret_cast<char*>(floats.data());
  for (std::size_t i = 0; i < floats.size(); ++i) {
    for (std::size_t plane = 0; plane < sizeof(float); ++plane) to[4 * i + plane] = bytes[plane * floats.size() + i];
  }
  return floats;
}

}  // namespace

void ContactBlock::add(std::span<const TickContact> tick) {
  rows.insert(rows.end(), tick.begin(), tick.end());
  ++ticks;
}

std::string contact_block_message(const ContactBlock& block) {
  std::string bytes(kBlockHead);
  append_number(bytes, block.time_s);
  append_number(bytes, block.step_s);
  append_number(bytes, block.contacts);
  append_number(bytes, block.ticks);
  const std::size_t n = block.contacts;
  for (std::size_t i = 0; i < n; ++i) append_number(bytes, block.rows[i].finger);
  for (std::size_t i = 0; i < n; ++i) append_number(bytes, block.rows[i].control_point);
  std::vector<float> floats;
  floats.reserve(n * (kFixedFloats + kMovingFloats * block.ticks));
  for (std::size_t i = 0; i < n; ++i) {
    for (const auto& v : {block.rows[i].point_m, block.rows[i].normal, block.rows[i].tangent}) {
      floats.insert(floats.end(), v, v + 3);
    }
  }
  // Each number of each contact through all ticks: it changes little from one to the next.
  for (std::size_t number = 0; number < kMovingFloats; ++number) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t tick = 0; tick < block.ticks; ++tick) {
        const TickContact& row = block.rows[tick * n + i];
        floats.push_back(number < 3 ? row.force_N[number] : row.slip_m[number - 3]);
      }
    }
  }
  append_planes(floats, bytes);
  return bytes;
}

ContactBlock read_contact_block(std::string_view bytes) {
  constexpr std::size_t kFixedBytes = kBlockHead.size() + 2 * sizeof(double) + 2 * sizeof(std::uint32_t);
  ContactBlock block;
  if (!bytes.starts_with(kBlockHead) || bytes.size() < kFixedBytes) return block;
  block.time_s = number_at<double>(bytes, 8);
  block.step_s = number_at<double>(bytes, 16);
  const auto n = number_at<std::uint32_t>(bytes, 24), ticks = number_at<std::uint32_t>(bytes, 28);
  // Ticks without contacts are valid, too, but bounded in number.
  const std::uint64_t most = n == 0 ? 1 << 16 : bytes.size() / n;
  if (n > bytes.size() || ticks > most) return block;
  const std::size_t size = kFixedBytes + n * (4 + sizeof(float) * (kFixedFloats + kMovingFloats * std::size_t{ticks}));
  if (bytes.size() != size) return block;
  const std::vector<float> floats = floats_of_planes(bytes.substr(kFixedBytes + std::size_t{4} * n));
  block.contacts = n;
  block.ticks = ticks;
  block.rows.resize(std::size_t{n} * ticks);
  for (std::size_t at = 0; at < block.rows.size(); ++at) {
    const std::size_t i = at % n, tick = at / n;
    TickContact& row = block.rows[at];
    row.finger = number_at<std::uint16_t>(bytes, kFixedBytes + 2 * i);
    row.control_point = number_at<std::uint16_t>(bytes, kFixedBytes + 2 * (n + i));
    const float* const fixed = floats.data() + kFixedFloats * i;
    std::copy_n(fixed, 3, row.point_m);
    std::copy_n(fixed + 3, 3, row.normal);
    std::copy_n(fixed + 6, 3, row.tangent);
    const auto moving = [&](std::size_t number) { return floats[kFixedFloats * n + (number * n + i) * ticks + tick]; };
    for (std::size_t axis = 0; axis < 3; ++axis) row.force_N[axis] = moving(axis);
    for (std::size_t axis = 0; axis < 2; ++axis) row.slip_m[axis] = moving(3 + axis);
  }
  return block;
}

}  // namespace thenar
