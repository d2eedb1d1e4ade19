// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "bench/peers/peers.h"
#include "bench/report/measure.h"
#include "engine/loops/percentiles.h"

namespace thenar {

/// Seeds of problems that no solver's constants were chosen on.
inline constexpr std::uint64_t kFresh = 1'000'000;

/// What a solver says of a problem.
enum class Claim { kSolved, kNoSolution, kNone };

/// What a solver said of many problems, and how much of it was wrong by a check of our own.
struct Verdicts {
  int solved = 0, no_solution = 0, unanswered = 0, wrong = 0;
  double worst_error = 0.0;  ///< Of answers that are right.
  std::vector<double> us;

  void add(Claim said, bool right, double error, double time_us) {
    us.push_back(time_us);
    ++(said == Claim::kSolved ? solved : said == Claim::kNoSolution ? no_solution : unanswered);
    if (said == Claim::kNone) return;
    if (right) {
      worst_error = std::max(worst_error, error);
    } else {
      ++wrong;
    }
  }

  void add(const Verdicts& more) {
    solved += more.solved;
    no_solution += more.no_solution;
    unanswered += more.unanswered;
    wrong += more.wrong;
    worst_error = std::max(worst_error, more.worst_error);
    us.insert(us.end(), more.us.begin(), more.us.end());
  }

  /// Appends what kVerdictColumns names.
  void append_to(nlohmann::ordered_json& row) const {
    for (const int count : {solved, no_solution, unanswered, wrong}) row.push_back(count);
    const bool any_right = solved + no_solution > wrong;
    row.push_back(any_right ? nlohmann::ordered_json(worst_error) : nlohmann::ordered_json("-"));
    const Percentiles times = percentiles(us);
    row.push_back(times.p50);
    row.push_back(times.p99);
  }
};

inline constexpr std::array kVerdictColumns{"said solved", "said none",   "no answer", "wrong",
                                            "worst error", "median [µs]", "p99 [µs]"};

/// Judges another project's solver by an LCP of which we know whether there is a solution: right is the same word, and
/// a solution to 1e-6 of q.
inline void judge_lcp(const LcpMethod& peer, const LcpProblem& problem, bool solvable, Verdicts& verdicts) {
  constexpr double kRight = 1e-6;
  const LcpSolver solve = peer.prepare(problem);
  Eigen::VectorXd z(problem.q.size());
  bool claimed = false;
  const double us = warm_time_us([&] {
    z.setZero();
    claimed = solve(z);
  });
  double error = 0.0;
  if (claimed) {
    const double scale = std::max(1e-300, problem.q.cwiseAbs().maxCoeff());
    error = z.allFinite() ? (problem.M * z + problem.q).cwiseMin(z).cwiseAbs().maxCoeff() / scale : 1.0;
  }
  verdicts.add(claimed ? Claim::kSolved : Claim::kNoSolution, claimed == solvable && error <= kRight, error, us);
}

/// A solver's verdicts family by family, as one row: all together, and the families where some were wrong or missing.
class VerdictRow {
 public:
  explicit VerdictRow(std::string solver) : solver_(std::move(solver)) {}

  void add(std::string_view family, const Verdicts& verdicts) {
    total_.add(verdicts);
    if (verdicts.wrong + verdicts.unanswered == 0) return;
    where_ += fmt::format("{}{} {} + {}", where_.empty() ? "" : ", ", family, verdicts.wrong, verdicts.unanswered);
  }

  [[nodiscard]] nlohmann::ordered_json row() const {
    nlohmann::ordered_json row{solver_};
    total_.append_to(row);
    row.push_back(where_.empty() ? "-" : where_);
    return row;
  }

  [[nodiscard]] static std::vector<std::string> columns() {
    std::vector<std::string> columns{"solver"};
    columns.insert(columns.end(), kVerdictColumns.begin(), kVerdictColumns.end());
    columns.emplace_back("where: wrong + no answer");
    return columns;
  }

 private:
  std::string solver_, where_;
  Verdicts total_;
};

}  // namespace thenar
