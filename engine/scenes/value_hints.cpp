// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/value_hints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "engine/formats/text.h"

namespace thenar {

namespace {

constexpr std::string_view kDigits = "0123456789";
constexpr const char* kPoint = ": the mark in a number is '.', not ','";

bool is_digit(char c) { return kDigits.find(c) != kDigits.npos; }

}  // namespace

std::string digits_hint(std::string_view text) {
  std::string digits(text);
  std::erase_if(digits, [](char c) { return c == ',' || c == '_' || c == ' ' || c == '\''; });
  double number = 0.0;
  const char* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, number);
  const bool is_whole = error == std::errc() && end == last && std::abs(number) < 1e15 && number == std::floor(number);
  return is_whole ? fmt::format(": write {:.0f}", number) : "";
}

std::string flag_hint(std::string_view text) {
  constexpr std::array<std::string_view, 6> kTrue{"yes", "Yes", "on", "On", "True", "1"};
  constexpr std::array<std::string_view, 6> kFalse{"no", "No", "off", "Off", "False", "0"};
  if (std::ranges::find(kTrue, text) != kTrue.end()) return did_you_mean("true");
  return std::ranges::find(kFalse, text) != kFalse.end() ? did_you_mean("false") : "";
}

std::string list_hint(const YamlNode& list, int count) {
  if (std::ssize(list.items) == 1 && count > 1) {
    return std::ranges::count(list.items.front()->text, ' ') >= count - 1 ? ": write ',' between them" : "";
  }
  const auto whole = std::ranges::count_if(list.items, [](const auto& item) {
    return !item->text.empty() && item->text.find_first_not_of("+-0123456789") == std::string::npos;
  });
  return std::ssize(list.items) == 2 * count && whole >= count ? kPoint : "";
}

std::string quantity_hint(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma != text.npos && comma > 0 && is_digit(text[comma - 1]) && comma + 1 < text.size() &&
      is_digit(text[comma + 1])) {
    return kPoint;
  }
  if (text.find("\u2212") != text.npos || text.find("\u2013") != text.npos) return ": its minus is a dash, write '-'";
  if (text.find("\u00A0") != text.npos) return ": its blank is a no-break space, write a blank";
  return "";
}

}  // namespace thenar
