// SPDX-License-Identifier: Apache-2.0
#include "app/studies/solve_result.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/problems/problem_check.h"

namespace thenar::app {

using nlohmann::ordered_json;

std::string listed(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  }
  return text;
}

void refuse(SolveResult& result, const std::string& why) {
  if (result.fault.empty()) result.fault = why;
}

void settle_verdict(SolveResult& result, const char* status, const std::string& verdict, double gap) {
  result.residual = result.residual_worst = gap;
  if (!(gap <= kProvedGap)) return refuse(result, fmt::format("the proof of '{}' fails: gap {:.1e}", status, gap));
  result.status = status;
  result.verdict = verdict;
}

void judge(SolveResult& result, const std::string& expected, double tolerance) {
  const bool is_solution = result.status == "optimal" || result.status == "solved";
  if (result.status == "budget") refuse(result, "no answer");
  if (!expected.empty() && result.status != expected) {
    refuse(result, fmt::format("'{}', and the file says '{}'", result.status, expected));
  }
  if (is_solution && !(result.residual <= tolerance)) {
    refuse(result, fmt::format("residual {:.1e} is above {:g}", result.residual, tolerance));
  }
}

ordered_json to_json(const SolveResult& result, bool forces) {
  const Percentiles us = percentiles(result.times_us);
  ordered_json row{{"name", result.name},
                   {"problem", result.problem},
                   {"method", result.method},
                   {"status", result.status},
                   {"residual", result.residual},
                   {"residual_worst", result.residual_worst},
                   {"iterations", result.iterations},
                   {"runs", result.times_us.size()},
                   {"median_us", us.p50},
                   {"p99_us", us.p99},
                   {"objective", nullptr}};
  if (result.objective) row["objective"] = *result.objective;
  if (forces) {
    row["f"] = result.f.size() > 0 ? ordered_json(std::vector<double>(result.f.begin(), result.f.end())) : nullptr;
  }
  return row;
}

std::string solve_table(const std::vector<SolveResult>& results, bool forces) {
  std::size_t width = 4;
  for (const SolveResult& result : results) width = std::max(width, result.name.size());
  const auto number = [](double value) { return std::isnan(value) ? std::string("-") : fmt::format("{:.1e}", value); };
  std::string table =
      fmt::format("{:<{}}  {:<7}  {:<12}  {:<11}  {:>8}  {:>8}  {:>6}  {:>6}  {:>10}  {:>10}\n", "name", width,
                  "problem", "method", "status", "residual", "worst", "steps", "runs", "median us", "p99 us");
  for (const SolveResult& r : results) {
    const Percentiles us = percentiles(r.times_us);
    table += fmt::format("{:<{}}  {:<7}  {:<12}  {:<11}  {:>8}  {:>8}  {:>6}  {:>6}  {:>10.4g}  {:>10.4g}\n", r.name,
                         width, r.problem, r.method, r.status, number(r.residual), number(r.residual_worst),
                         r.iterations, r.times_us.size(), us.p50, us.p99);
    if (!r.verdict.empty()) table += "  " + r.status + ": " + r.verdict + "\n";
    if (!forces || r.f.size() == 0) continue;
    table += r.problem == "LCP" ? "  z =" : "  f =";
    for (const double value : r.f) table += fmt::format(" {:.6g}", value);
    table += "\n";
  }
  return table;
}

}  // namespace thenar::app
