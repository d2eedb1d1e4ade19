// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/plain_text.h"

#include <cstdint>

#include "engine/formats/files.h"

namespace thenar {

namespace {

enum class Order { kNone, kLittle, kBig };

/// Returns the order of the two bytes of UTF-16's units; none for other texts.
Order utf16_order(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE")) return Order::kLittle;
  if (bytes.starts_with("\xFE\xFF")) return Order::kBig;
  if (bytes.size() < 4) return Order::kNone;
  const auto is_zero = [&](std::size_t i) { return bytes[i] == '\0'; };
  if (!is_zero(0) && is_zero(1) && !is_zero(2) && is_zero(3)) return Order::kLittle;
  if (is_zero(0) && !is_zero(1) && is_zero(2) && !is_zero(3)) return Order::kBig;
  return Order::kNone;
}

void append_utf8(std::string& text, std::uint32_t code) {
  const auto tail = [&](unsigned shift) { text += static_cast<char>(0x80U | (code >> shift & 0x3FU)); };
  if (code < 0x80) {
    text += static_cast<char>(code);
  } else if (code < 0x800) {
    text += static_cast<char>(0xC0U | code >> 6U);
    tail(0);
  } else if (code < 0x10000) {
    text += static_cast<char>(0xE0U | code >> 12U);
    tail(6);
    tail(0);
  } else {
    text += static_cast<char>(0xF0U | code >> 18U);
    tail(12);
    tail(6);
    tail(0);
  }
}

}  // namespace

std::string_view plain_text(std::string_view bytes, const std::filesystem::path& file, std::string& store) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xEF\xBB\xBF")) return bytes.substr(3);
  if (bytes.starts_with("\xFF\xFE\0\0"sv) || bytes.starts_with("\0\0\xFE\xFF"sv)) {
    throw FileError(file, "is a text in UTF-32: save it in UTF-8");
  }
  const Order order = utf16_order(bytes);
  if (order == Order::kNone) return bytes;
  const std::size_t low = order == Order::kLittle ? 0 : 1;
  const auto unit = [&](std::size_t i) -> std::uint32_t {
    return static_cast<unsigned char>(bytes[i + low]) | static_cast<unsigned char>(bytes[i + 1 - low]) << 8U;
  };
  store.clear();
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit(i);
    // A pair of surrogates is one character [RFC 2781]; half of one stands for none.
    if (code >= 0xD800 && code < 0xDC00 && i + 3 < bytes.size() && (unit(i + 2) & 0xFC00U) == 0xDC00) {
      code = 0x10000 + ((code & 0x3FFU) << 10U) + (unit(i + 2) & 0x3FFU);
      i += 2;
    }
    const bool is_mark = code == 0xFEFF && i == 0;
    if (!is_mark) append_utf8(store, code >= 0xD800 && code < 0xE000 ? 0xFFFD : code);
  }
  return store;
}

}  // namespace thenar
