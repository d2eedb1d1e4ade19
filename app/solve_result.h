#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/loops/percentiles.h"

namespace thenar::app {

/// What one method makes of one problem: a row of the results of `thenar solve`.
struct SolveResult {
  std::string name, problem, method;
  std::string status = "budget";  ///< Or optimal, infeasible, solved, no_solution.
  double residual = NAN;          ///< Of the solution; of an infeasible verdict, the gap of its proof.
  double residual_worst = NAN;
  int iterations = 0;
  std::vector<double> times_us;  ///< Of each timed solve.
  std::optional<double> objective;
  Eigen::VectorXd f;    ///< Or z; empty without a solution.
  std::string verdict;  ///< What a verdict that there is no solution means.
  std::string fault;    ///< Why this is not the right answer; empty: it is.
};

/// A part of a deficit is worth a word from this share of its largest part on.
inline constexpr double kWorthAWord = 0.01;

/// "A, B and C"
[[nodiscard]] std::string listed(const std::vector<std::string>& parts);

/// Says why a result is not right, unless that is said already.
void refuse(SolveResult& result, const std::string& why);

/// Holds the verdict that there is no solution against the gap of its proof: without one it is none.
void settle_verdict(SolveResult& result, const char* status, const std::string& verdict, double gap);

/// Holds a result against what the file knows, and a solution against the tolerance.
void judge(SolveResult& result, const std::string& expected, double tolerance);

[[nodiscard]] nlohmann::ordered_json to_json(const SolveResult& result, bool forces);

/// A text table; what a verdict means goes below its row.
[[nodiscard]] std::string solve_table(const std::vector<SolveResult>& results, bool forces);

}  // namespace thenar::app
