// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/loops/percentiles.h"

namespace thenar::app {

/// Result of one method on one problem: a row of the results of `thenar solve`.
struct SolveResult {
  std::string name, problem, method;
  std::string status = "budget";  ///< Otherwise optimal, infeasible, solved, no_solution.
  double residual = NAN;          ///< Residual of the solution, or gap of the proof that it is infeasible.
  double residual_worst = NAN;
  int iterations = 0;
  std::vector<double> times_us;  ///< Time of each timed solve.
  std::optional<double> objective;
  Eigen::VectorXd f;    ///< Solution f or z; empty without a solution.
  std::string verdict;  ///< Meaning of a verdict that there is no solution.
  std::string fault;    ///< Reason that the answer is wrong; empty: it is right.
};

/// Least share of a deficit's largest part at which a part is mentioned.
inline constexpr double kWorthAWord = 0.01;

/// Returns "A, B and C".
[[nodiscard]] std::string listed(const std::vector<std::string>& parts);

/// Sets the reason that a result is not right, unless one is set.
void refuse(SolveResult& result, const std::string& why);

/// Checks the verdict that there is no solution by the gap of its proof; without a proof there is no verdict.
void settle_verdict(SolveResult& result, const char* status, const std::string& verdict, double gap);

/// Checks a result against the file's own answer, and a solution against the tolerance.
void judge(SolveResult& result, const std::string& expected, double tolerance);

[[nodiscard]] nlohmann::ordered_json to_json(const SolveResult& result, bool forces);

/// Returns a text table, with the meaning of a verdict below its row.
[[nodiscard]] std::string solve_table(const std::vector<SolveResult>& results, bool forces);

}  // namespace thenar::app
