// SPDX-License-Identifier: Apache-2.0
#include "app/run/table.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "engine/formats/build_info.h"

namespace thenar::app {

namespace {

/// In the order of Heading.
constexpr std::array<std::string_view, 6> kHeadings = {"run",         "grasp",    "task",
                                                       "environment", "accuracy", "time, median / p99"};

std::string cell(double number) { return std::isfinite(number) ? fmt::format("{:.4g}", number) : "-"; }

/// A value as it is printed; nothing where a run has none.
struct Cell {
  std::string operator()(std::monostate /*nothing*/) const { return ""; }
  std::string operator()(bool is) const { return is ? "yes" : "no"; }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(double number) const { return cell(number); }
  std::string operator()(const std::string& text) const { return text; }
  std::string operator()(const std::vector<std::string>& texts) const {
    return fmt::format("{}", fmt::join(texts, fmt::format("\n{:39}", "")));  // One below the other.
  }
  std::string operator()(const std::vector<double>& numbers) const {
    std::string all;
    for (const double number : numbers) all += (all.empty() ? "" : ", ") + cell(number);
    return all;
  }
  std::string operator()(const Percentiles& us) const {
    return std::isfinite(us.p50) ? cell(us.p50) + " / " + cell(us.p99) : "";
  }
};

/// A line with its label, or the end of the line before.
std::string printed(const RunMeasure& measure, const MeasureValue& value) {
  std::string text = std::visit(Cell{}, value);
  if (text.empty()) return "";
  if (text != "-" && !measure.unit.name.empty()) text.append(" ").append(measure.unit.name);
  const std::string line = measure.label.empty() ? "" : fmt::format("\n  {:<36} {:>15}", measure.label, text);
  if (measure.remark.empty() || (line.empty() && text == "-")) return line;
  return fmt::format("{}  {}{}", line, measure.remark, line.empty() ? " " + text : "");
}

/// The lines of a heading; nothing if there are none.
std::string lines_under(std::size_t heading, const std::vector<MeasuredSection>& measures) {
  std::string lines;
  for (const auto& [section, items] : measures) {
    if (static_cast<std::size_t>(section->heading) != heading) continue;
    for (const std::vector<Measured>& item : items) {
      for (const auto& [measure, value] : item) lines += printed(*measure, value);
    }
  }
  return lines.empty() ? "" : fmt::format("\n{}{}\n", kHeadings.at(heading), lines);
}

/// What built the program, and what the contact thread was granted: "…, SCHED_FIFO 80, core 1, memory locked".
std::string build_line(const Scheduling* granted) {
  Scheduling threads = granted != nullptr ? *granted : Scheduling{};
  threads.remark.clear();  // It has a line of its own.
  return fmt::format("thenar {}, {} ({}), {}, {}\n", build_info::kVersion, build_info::kType, build_info::kFlags,
                     build_info::kCompiler,
                     granted != nullptr ? in_words(threads) : "one thread, no real-time scheduling");
}

}  // namespace

std::string results_table(const std::vector<MeasuredSection>& measures, const Scheduling* granted) {
  std::string table = build_line(granted);
  for (std::size_t heading = 0; heading < kHeadings.size(); ++heading) table += lines_under(heading, measures);
  if (granted != nullptr)
    table += "  contact computation: on both threads together: must fit into no period; see below\n";
  return table;
}

}  // namespace thenar::app
