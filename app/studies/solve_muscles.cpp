// SPDX-License-Identifier: Apache-2.0
#include "app/studies/solve_muscles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/problems/problem_check.h"
#include "solvers/muscles/stiff_muscles.h"
#include "solvers/muscles/stiff_proof.h"

namespace thenar::app {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Proofs by limits hold as soon as what is possible is less than what is needed; up to rounding.
double beyond_proof(double gap) { return std::max(0.0, gap - (1.0 - 1e-9)); }

std::string explain(const MuscleDeficit& deficit) {
  std::vector<std::string> parts;
  const double largest_Nm = deficit.missing_Nm.cwiseAbs().maxCoeff();
  for (Index i = 0; i < deficit.missing_Nm.size(); ++i) {
    const double missing_Nm = deficit.missing_Nm[i];
    if (std::abs(missing_Nm) < kWorthAWord * largest_Nm) continue;
    parts.push_back(fmt::format("{:.3g} N m of row {}", missing_Nm, i));
  }
  return fmt::format("pulling muscles leave {} of the torques: at best |H f - tau| is {:.3g} N m", listed(parts),
                     deficit.missing_Nm.norm());
}

/// What the limits leave undone.
std::string explain(const MuscleProblem& problem, const VectorXd& l) {
  const MuscleLack lack = muscle_lack(problem, l);
  if (lack.muscle < 0) return "no muscle pulls along the joint velocities at which the torques do work";
  return fmt::format("with all others at their limits muscle {} would have to pull at least {:.4g} N, and can {:.4g} N",
                     lack.muscle, lack.needed_N, problem.limit_of(lack.muscle));
}

std::string explain(const StiffMuscleFile& file, const StiffMuscleReport& report) {
  if (report.cause == StiffCause::kTorques) {
    return explain({file.H, file.tau, file.limit}, report.multiplier);
  }
  const StiffLack lack = find_stiff_lack(file);
  std::vector<std::string> limited;
  for (Index j = 0; j < file.H.cols(); ++j) {
    if ((lack.at_limit >> j & 1) != 0) limited.push_back(std::to_string(j));
  }
  const std::string with = limited.empty()       ? ""
                           : limited.size() == 1 ? fmt::format(" with muscle {} at its limit", limited[0])
                                                 : fmt::format(" with muscles {} at their limits", listed(limited));
  if (report.cause == StiffCause::kPosture) {
    return fmt::format("finger {} gives way along its joints ({:.2g}){}: at least {:.4g} N m/rad are lacking",
                       lack.finger, fmt::join(lack.bend.head(file.joints[static_cast<std::size_t>(lack.finger)]), ", "),
                       with, lack.lacking_Nm_per_rad);
  }
  return fmt::format("along ({:.2g}), turns on {:g} m, the object lacks at least {:.4g} N/m{}",
                     fmt::join(lack.direction, ", "), file.length_m, lack.lacking_N_per_m, with);
}

/// Of the optimum: what the object has over what it was to have, in the directions of the wish.
std::string stiffness_in_words(const StiffMuscleFile& file, const VectorXd& f, double squeeze) {
  Matrix6d K_o;
  if (!object_stiffness(file, f, squeeze, K_o)) return "";
  std::vector<std::string> each;
  for (int i = 0; i < 6; ++i) each.push_back(fmt::format("{:.4g} of {:.4g}", K_o(i, i), file.K_des(i, i)));
  return fmt::format("stiffness {}{}", listed(each),
                     file.squeeze ? fmt::format("; squeeze {:.4g}", squeeze) : std::string());
}

}  // namespace

std::vector<SolveResult> solve(const MuscleFile& file, const std::string& method, double tolerance,
                               const Repetition& repetition) {
  SolveResult result;
  result.name = file.name;
  VectorXd f(file.H.cols());
  MuscleWorkspace work(file.H.rows(), file.H.cols());
  MuscleReport report;
  result.times_us = time_solves(
      repetition, [&] { f.setZero(); },
      [&] { report = method == "lemke" ? solve_muscle_forces_by_lemke(file, work, f) : solve_muscle_forces(file, f); });
  result.iterations = report.iterations;
  if (report.status == MuscleStatus::kInfeasible) {
    const MuscleDeficit deficit = explain_infeasible_muscles(file);
    // Where the torques are in reach without limits, what proves it is that limits' parts are too little.
    const double gap = muscle_infeasibility_gap(file, report.multiplier);
    const bool is_by_limits = !(deficit.gap <= kProvedGap) && gap < 1.0;
    settle_verdict(result, "infeasible", is_by_limits ? explain(file, report.multiplier) : explain(deficit),
                   is_by_limits ? beyond_proof(gap) : deficit.gap);
  } else if (report.status == MuscleStatus::kOptimal) {
    result.status = "optimal";
    result.residual = result.residual_worst = muscle_residual(file, f);
    result.objective = 0.5 * f.squaredNorm();
    result.f = f;
  }
  judge(result, file.status, tolerance);
  return {result};
}

std::vector<SolveResult> solve(const StiffMuscleFile& file, const std::string& /*method*/, double tolerance,
                               const Repetition& repetition) {
  SolveResult result;
  result.name = file.name;
  VectorXd f(file.H.cols());
  StiffMuscleReport report;
  result.times_us = time_solves(
      repetition, [&] { f.setZero(); }, [&] { report = solve_stiff_muscles(file, f); });
  result.iterations = report.iterations;
  if (report.status == MuscleStatus::kInfeasible) {
    settle_verdict(result, "infeasible", explain(file, report), beyond_proof(stiff_infeasibility_gap(file, report)));
  } else if (report.status == MuscleStatus::kOptimal) {
    result.status = "optimal";
    result.residual = result.residual_worst = stiff_kkt_error(file, f, report);
    result.objective = 0.5 * f.squaredNorm();
    if (file.squeeze) *result.objective += 0.5 * file.squeeze->weight * report.squeeze * report.squeeze;
    result.verdict = stiffness_in_words(file, f, report.squeeze);
    result.f = f;
  }
  judge(result, file.status, tolerance);
  return {result};
}

}  // namespace thenar::app
