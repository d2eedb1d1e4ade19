// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/scenes/value_hints.h"

namespace thenar {

namespace {

/// The SI value is number * factor / divisor. Dividing by 1000 rounds once, so "50 mm" is exactly 0.05.
struct Unit {
  std::string_view symbol;
  double factor = 1.0;
  double divisor = 1.0;
};

struct Units {
  std::string_view name;
  std::vector<Unit> units;
  std::string_view least, most;
};

const Units& units_of(Dimension dimension) {
  // In the order of Dimension.
  static const std::array<Units, 22> kTable = {{
      {"a plain number", {}, "-1e9", "1e9"},
      {"a length", {{"m"}, {"cm", 1, 100}, {"mm", 1, 1e3}, {"um", 1, 1e6}}, "-1e3 m", "1e3 m"},
      {"a time", {{"s"}, {"ms", 1, 1e3}, {"us", 1, 1e6}}, "-1e9 s", "1e9 s"},
      {"a mass", {{"kg"}, {"g", 1, 1e3}}, "-1e4 kg", "1e4 kg"},
      {"a force", {{"N"}, {"mN", 1, 1e3}}, "-1e5 N", "1e5 N"},
      {"a torque", {{"N*m"}, {"N*mm", 1, 1e3}}, "-1e4 N*m", "1e4 N*m"},
      {"an angle", {{"rad"}, {"deg", std::numbers::pi, 180}}, "-1e4 rad", "1e4 rad"},
      {"an acceleration", {{"m/s^2"}}, "-1e4 m/s^2", "1e4 m/s^2"},
      {"a pressure", {{"Pa"}, {"kPa", 1e3}, {"MPa", 1e6}}, "-1e13 Pa", "1e13 Pa"},
      {"a stiffness", {{"N/m"}, {"N/mm", 1e3}}, "-1e9 N/m", "1e9 N/m"},
      {"a rotational stiffness", {{"N*m/rad"}}, "-1e7 N*m/rad", "1e7 N*m/rad"},
      {"a damping", {{"N*s/m"}}, "-1e7 N*s/m", "1e7 N*s/m"},
      {"a rotational damping", {{"N*m*s"}, {"N*m*s/rad"}}, "-1e7 N*m*s", "1e7 N*m*s"},
      {"an integral gain", {{"N/(m*s)"}}, "-1e9 N/(m*s)", "1e9 N/(m*s)"},
      {"a rotational integral gain", {{"N*m/(rad*s)"}}, "-1e7 N*m/(rad*s)", "1e7 N*m/(rad*s)"},
      {"a frequency", {{"Hz"}, {"kHz", 1e3}}, "-1e9 Hz", "1e9 Hz"},
      {"a value per force", {{"1/N"}}, "-1e6 1/N", "1e6 1/N"},
      {"a share", {{"%", 1, 100}}, "-1e6 %", "1e6 %"},
      {"a rate of force", {{"N/s"}}, "-1e10 N/s", "1e10 N/s"},
      {"a rate", {{"1/s"}}, "-1e6 1/s", "1e6 1/s"},
      {"a compliance", {{"m/N"}, {"um/N", 1, 1e6}, {"nm/N", 1, 1e9}}, "-1e3 m/N", "1e3 m/N"},
      {"a speed", {{"m/s"}, {"mm/s", 1, 1e3}}, "-1e4 m/s", "1e4 m/s"},
  }};
  return kTable[static_cast<std::size_t>(dimension)];
}

struct SplitNumber {
  double value;           // Not finite if the text says so, or if it is too large.
  std::string_view rest;  // What follows the number and its blanks.
};

std::optional<SplitNumber> split_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::string_view digits = text;
  if (digits.starts_with('-')) digits.remove_prefix(1);
  // YAML writes them with a point, other programs without.
  for (const std::string_view word : {".inf", ".Inf", ".INF", "inf", ".nan", ".NaN", ".NAN", "nan"}) {
    if (digits == word) return SplitNumber{std::numeric_limits<double>::quiet_NaN(), {}};
  }
  if (digits.empty() || (digits[0] != '.' && (digits[0] < '0' || digits[0] > '9'))) return std::nullopt;

  const char* const last = text.data() + text.size();
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range) value = std::numeric_limits<double>::quiet_NaN();
  std::string_view rest(end, static_cast<std::size_t>(last - end));
  while (rest.starts_with(' ')) rest.remove_prefix(1);
  return SplitNumber{value, rest};
}

}  // namespace

Quantity read_quantity(std::string_view text, Dimension dimension) {
  const Units& known = units_of(dimension);
  const std::string shown(text);
  const std::string hint = quantity_hint(text), use = ": use " + unit_names(dimension);
  const auto number = split_number(text);
  if (!number) {
    const std::string how = !hint.empty() ? hint : known.units.empty() ? "" : use;
    return {0.0, "'" + shown + "' is not " + std::string(known.name) + how};
  }
  if (known.units.empty()) {
    if (!number->rest.empty()) {
      const std::string rest = ", without '" + std::string(number->rest) + "'";
      return {0.0, shown + " must be a plain number" + (hint.empty() ? rest : hint)};
    }
    if (!std::isfinite(number->value)) return {0.0, shown + " is not a finite number"};
    return {number->value, ""};
  }
  if (!std::isfinite(number->value)) return {0.0, shown + " is not a finite number"};
  if (number->rest.empty()) return {0.0, shown + " has no unit" + use};
  for (const Unit& unit : known.units) {
    if (number->rest != unit.symbol) continue;
    const double value = number->value * unit.factor / unit.divisor;
    if (!std::isfinite(value)) return {0.0, shown + " is not a finite number"};
    return {value, ""};
  }
  return {0.0, shown + " is not " + std::string(known.name) + (hint.empty() ? use : hint)};
}

std::string_view least_of(Dimension dimension) { return units_of(dimension).least; }
std::string_view most_of(Dimension dimension) { return units_of(dimension).most; }

std::string_view name_of(Dimension dimension) { return units_of(dimension).name; }

std::vector<std::string_view> unit_symbols(Dimension dimension) {
  std::vector<std::string_view> symbols;
  for (const Unit& unit : units_of(dimension).units) symbols.push_back(unit.symbol);
  return symbols;
}

std::string unit_names(Dimension dimension) {
  const std::vector<std::string_view> symbols = unit_symbols(dimension);
  std::string names;
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    if (i > 0) names += i + 1 == symbols.size() ? " or " : ", ";
    names += symbols[i];
  }
  return names;
}

std::string to_text(double value, Dimension dimension) {
  const std::vector<Unit>& units = units_of(dimension).units;
  const double shown = units.empty() ? value : value * units.front().divisor / units.front().factor;
  std::array<char, 32> buffer{};
  const auto written = std::to_chars(buffer.data(), buffer.data() + buffer.size(), shown);
  std::string text(buffer.data(), written.ptr);
  if (!units.empty()) text.append(" ").append(units.front().symbol);
  return text;
}

std::string to_text(const Eigen::VectorXd& values, Dimension dimension) {
  std::string all;
  for (const double value : values) all += (all.empty() ? "" : ", ") + to_text(value, dimension);
  return "[" + all + "]";
}

}  // namespace thenar
