// SPDX-License-Identifier: Apache-2.0
#include "app/studies/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/exit_code.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/studies/solve_muscles.h"
#include "app/studies/solve_result.h"
#include "engine/finder/grasp_deficit.h"
#include "engine/formats/fclib_file.h"
#include "engine/formats/problem_file.h"
#include "engine/formats/text.h"
#include "engine/problems/problem_check.h"
#include "engine/problems/timed_solves.h"
#include "solvers/contact_newton.h"
#include "solvers/gauss_seidel.h"

namespace thenar::app {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::ordered_json;

namespace {

using app::solve;  // Of muscle problems.

// Solvers that keep gaps by increments are asked for half of the tolerance: recomputed, the residual differs a little.
constexpr double kMargin = 0.5;
// Of plain Gauss-Seidel: where it converges to 1e-8 at all, this is enough, and where it stalls the user waits.
constexpr int kMaxSweeps = 5000;
// Of Lemke: no tick waits for it here, and Murty's family takes 2^n pivots.
constexpr int kMaxPivots = 100'000;
// Forces below this part of those at hand are none.
constexpr double kNothing = 1e-9;

/// What files call a kind of problem, and the solvers for it by their names on the command line.
struct Kind {
  const char* problem;
  std::vector<std::string> methods;  ///< The first is the default.
};

Kind kind(const ContactFile&) { return {"contact", {"newton", "gauss_seidel"}}; }
Kind kind(const GraspFile&) { return {"P1", {"active_set", "lemke", "exact_cone"}}; }
Kind kind(const MuscleFile&) { return {"P2", {"active_set", "lemke"}}; }
Kind kind(const StiffMuscleFile&) { return {"P3", {"newton"}}; }
Kind kind(const LcpFile&) { return {"LCP", {"lemke"}}; }

double default_tolerance(const ProblemFile& file) {
  if (std::holds_alternative<ContactFile>(file)) return 1e-8;
  return std::holds_alternative<StiffMuscleFile>(file) ? 1e-9 : 1e-10;
}

// ---- contact ----

std::string explain(const ContactFile& file, const VectorXd& y, double closed_m) {
  std::vector<std::string> pressed;
  for (Index i = 0; i < y.size(); ++i) {
    if (y[i] > kWorthAWord * y.maxCoeff()) pressed.push_back(fmt::format("{} ({:.2g})", i, y[i]));
  }
  const bool is_velocity = file.units.find("velocity") != std::string::npos;
  const char* const unit = file.units == kUnitsOfFclib ? "" : is_velocity ? " m/s" : " m";
  return fmt::format(
      "bodies that do not give way press contacts {} together: their gaps, added up by these weights, stay closed by "
      "{:.3g}{} whatever the forces",
      listed(pressed), closed_m, unit);
}

/// A contact solver by its name, with the memory that it needs.
class ContactSolver {
 public:
  ContactSolver(const ContactFile& file, const std::string& method, double tolerance)
      : file_(file),
        accurate_(method == "newton"),
        tolerance_(kMargin * tolerance),
        work_(file.contacts()),
        sweeps_(file.contacts()),
        delta_(3 * file.contacts()) {}

  /// One step from the first guess in f.
  void solve(std::size_t step, VectorXd& f) {
    const ContactProblem problem = file_.problem(step);
    if (accurate_) {
      const AccurateReport report = solve_contacts_accurately(problem, {.tolerance = tolerance_}, work_, {f, delta_});
      status = report.solve.status;
      iterations = report.solve.sweeps + report.steps;
    } else {
      const SolveReport report = solve_contacts(problem, {tolerance_, kMaxSweeps}, sweeps_, {f, delta_});
      status = report.status;
      iterations = report.sweeps;
    }
  }

  SolveStatus status = SolveStatus::kBudgetSpent;  ///< This and the next: of the last solve.
  int iterations = 0;                              ///< Sweeps and Newton steps.
  /// What proves that there is no solution; see contact_newton.h.
  [[nodiscard]] const VectorXd& certificate() const { return work_.certificate; }

 private:
  const ContactFile& file_;
  bool accurate_;
  double tolerance_;
  AccurateWorkspace work_;
  SweepWorkspace sweeps_;
  VectorXd delta_;
};

/// What the last solve, of this step, is worth. A residual within the tolerance is a solution, whatever the solver
/// thinks of it.
void settle(const ContactFile& file, std::size_t step, const ContactSolver& solver, const VectorXd& f, double tolerance,
            SolveResult& result) {
  if (solver.status == SolveStatus::kNoSolution) {
    const ContactVerdict verdict = contact_verdict(file.problem(step), solver.certificate());
    settle_verdict(result, "no_solution", explain(file, solver.certificate(), verdict.closed_m), verdict.gap);
    return;
  }
  const Residual residual = contact_residual(file.problem(step), f);
  result.residual = residual.norm;
  result.residual_worst = residual.worst;
  result.status = residual.norm <= tolerance ? "solved" : "budget";
  if (result.status == "budget") refuse(result, fmt::format("stopped at residual {:.1e}", residual.norm));
  result.f = f;
}

SolveResult solve_cold(const ContactFile& file, const std::string& method, double tolerance,
                       const Repetition& repetition) {
  SolveResult result;
  ContactSolver solver(file, method, tolerance);
  VectorXd f(3 * file.contacts());
  result.times_us = time_solves(
      repetition, [&] { f.setZero(); }, [&] { solver.solve(0, f); });
  result.iterations = solver.iterations;
  settle(file, 0, solver, f, tolerance, result);
  judge(result, file.status, tolerance);
  return result;
}

/// Whether a is the one to tell of: it is wrong and b is not, or else its residual is larger.
bool is_worse(const SolveResult& a, const SolveResult& b) {
  return a.fault.empty() == b.fault.empty() ? !(a.residual <= b.residual) : b.fault.empty();
}

/// Every step from the forces of the one before it: the first from the file's first guess, or untimed from nothing. The
/// result is that of the worst step.
SolveResult solve_warm(const ContactFile& file, const std::string& method, double tolerance,
                       const Repetition& repetition) {
  ContactSolver solver(file, method, tolerance);
  const std::size_t steps = file.delta_free.size();
  const bool has_guess = file.f_last.size() > 0;
  const std::size_t first_timed = has_guess ? 0 : 1;
  const VectorXd guess = has_guess ? file.f_last : VectorXd(VectorXd::Zero(3 * file.contacts()));

  // One pass is judged, and warms the machine up; the same problems give the same bits in those that are timed.
  SolveTimes times(repetition);
  SolveResult worst;
  double iterations = 0.0;
  VectorXd f = guess;
  for (std::size_t step = 0; step < steps; ++step) {
    const auto solve_step = [&] { solver.solve(step, f); };
    step >= first_timed ? times.warm_up(solve_step) : solve_step();
    SolveResult one;
    settle(file, step, solver, f, tolerance, one);
    judge(one, step == 0 ? file.status : "", tolerance);
    if (!one.fault.empty() && steps > 1) one.fault = fmt::format("step {}: {}", step, one.fault);
    if (step == 0 || is_worse(one, worst)) worst = std::move(one);
    if (step >= first_timed) iterations += solver.iterations;
  }
  worst.iterations = static_cast<int>(std::lround(iterations / static_cast<double>(steps - first_timed)));

  while (times.goes_on()) {
    f = guess;
    if (first_timed > 0) solver.solve(0, f);
    for (std::size_t step = first_timed; step < steps && times.goes_on(); ++step) {
      times.add([&] { solver.solve(step, f); });
    }
  }
  worst.times_us = times.us();
  return worst;
}

std::vector<SolveResult> solve(const ContactFile& file, const std::string& method, double tolerance,
                               Repetition repetition) {
  const std::size_t steps = file.delta_free.size();
  const bool has_warm_row = steps > 1 || file.f_last.size() > 0;
  if (has_warm_row) repetition.time_s /= 2.0;
  std::vector<SolveResult> results{solve_cold(file, method, tolerance, repetition)};
  results.back().name = file.name;
  if (has_warm_row) {
    results.push_back(solve_warm(file, method, tolerance, repetition));
    results.back().name = file.name + (steps > 1 ? fmt::format(" (warm, {} steps)", steps) : " (warm)");
  }
  return results;
}

/// Writes a problem with what was found of it, if that is right.
void write_found(ContactFile file, const SolveResult& found, const std::filesystem::path& to) {
  if (found.fault.empty()) file.status = found.status;
  if (found.fault.empty() && found.f.size() > 0) {
    file.f_reference = found.f;
    file.delta_reference = file.W * found.f + file.delta_free.front();
    file.reference_residual = found.residual;
  }
  if (!is_fclib_file(to)) {
    write_problem(to, file);
    return;
  }
  write_fclib_problem(to, file);
  const std::size_t steps = file.delta_free.size();
  if (steps > 1)
    std::cerr << fmt::format("{}: holds one problem, which is step 0 of {}\n", printable(to.string()), steps);
}

// ---- grasp forces ----

/// "friction 0.3", or where contacts differ "frictions 0.3, 0.5 and 0.2".
std::string friction_in_words(const GraspProblem& problem) {
  if (problem.grips.empty()) return fmt::format("friction {:g}", problem.friction);
  std::vector<std::string> each;
  for (const ContactGrip& grip : problem.grips) each.push_back(fmt::format("{:g}", grip.friction));
  return "frictions " + listed(each);
}

std::string explain(const GraspProblem& problem) {
  const GraspDeficit deficit = explain_infeasible_grasp(problem);
  std::vector<std::string> lacking;
  const auto n = std::ssize(problem.contacts);
  const double largest_N = deficit.missing_N.leftCols(n).cwiseAbs().maxCoeff();
  double squeeze_N = 0.0;
  for (Index i = 0; i < n; ++i) {
    squeeze_N = std::max(squeeze_N, problem.internal_force_of(i));
    const auto e = deficit.missing_N.col(i);
    std::vector<std::string> parts;
    const double tangential_N = e.tail<2>().norm();
    if (tangential_N > kWorthAWord * largest_N) parts.push_back(fmt::format("{:.3g} N of tangential", tangential_N));
    if (std::abs(e[0]) > kWorthAWord * largest_N) {
      parts.push_back(fmt::format("{:.3g} N of {} force", std::abs(e[0]), e[0] > 0.0 ? "pushing" : "pulling"));
    } else if (!parts.empty()) {
      parts.back() += " force";
    }
    if (!parts.empty()) lacking.push_back(fmt::format("contact {} lacks {}", i, listed(parts)));
  }
  // What is left where only a torque is missing that no contact force gives is rounding.
  const double forces_N = problem.wrench.head<3>().norm() + squeeze_N;
  if (largest_N <= kNothing * forces_N) lacking.clear();
  std::string text = lacking.empty() ? "the contacts cannot give a part of the torque, whatever their forces"
                                     : fmt::format("at {} {}", friction_in_words(problem), listed(lacking));
  if (std::isfinite(deficit.least_friction)) {
    return text + fmt::format("; a friction of at least {:.3g}{} would do", deficit.least_friction,
                              problem.grips.empty() ? "" : " at every contact");
  }
  return text + "; no friction would do";
}

std::string expected_status(const GraspFile& file, bool exact_cone) {
  if (!exact_cone) return file.status;
  if (file.f_optimal_exact_cone.size() > 0) return "optimal";
  if (!file.status_exact_cone.empty()) return file.status_exact_cone;
  // The exact cone lies within the pyramid.
  return file.status == "infeasible" ? "infeasible" : "";
}

std::vector<SolveResult> solve(const GraspFile& file, const std::string& method, double tolerance,
                               const Repetition& repetition) {
  const bool exact_cone = method == "exact_cone", lemke = method == "lemke";
  const GraspProblem problem = file.problem(exact_cone ? FrictionCone::kExact : FrictionCone::kPyramid);
  SolveResult result;
  result.name = file.name;
  VectorXd f(3 * std::ssize(file.contacts));
  GraspWorkspace work;
  GraspReport report;
  result.times_us = time_solves(
      repetition, [&] { f.setZero(); },
      [&] { report = lemke ? solve_grasp_forces_by_lemke(problem, work, f) : solve_grasp_forces(problem, f); });
  result.iterations = report.iterations;
  if (report.status == GraspStatus::kInfeasible) {
    settle_verdict(result, "infeasible", explain(problem), infeasibility_gap(problem, report.multiplier));
  } else if (report.status == GraspStatus::kOptimal) {
    result.status = "optimal";
    result.residual = result.residual_worst = grasp_kkt_error(problem, report.multiplier, f);
    result.objective = 0.5 * f.squaredNorm();
    for (std::size_t i = 0; i < file.contacts.size(); ++i) {
      *result.objective -= problem.internal_force_of(static_cast<Index>(i)) *
                           file.contacts[i].axes.col(0).dot(f.segment<3>(3 * static_cast<Index>(i)));
    }
    result.f = f;
  }
  judge(result, expected_status(file, exact_cone), std::max(tolerance, grasp_rounding(problem)));
  return {result};
}

// ---- linear complementarity ----

std::string explain(const LcpFile& file, const VectorXd& y) {
  std::vector<std::string> terms;
  for (Index i = 0; i < y.size(); ++i) {
    if (y[i] > kWorthAWord * y.maxCoeff()) terms.push_back(fmt::format("{:.3g} w_{}", y[i], i));
  }
  return fmt::format("{} is at most {:.3g} for every z >= 0, and would have to be 0 or more", fmt::join(terms, " + "),
                     y.dot(file.q));
}

std::vector<SolveResult> solve(const LcpFile& file, const std::string& /*method*/, double tolerance,
                               const Repetition& repetition) {
  SolveResult result;
  result.name = file.name;
  VectorXd z(file.q.size());
  LcpWorkspace work(file.q.size());
  LcpReport report;
  result.times_us = time_solves(
      repetition, [&] { z.setZero(); }, [&] { report = solve_lcp(file, kMaxPivots, work, z); });
  result.iterations = report.pivots;
  if (report.status == LcpStatus::kInfeasible) {
    settle_verdict(result, "no_solution", explain(file, z), lcp_infeasibility_gap(file, z));
  } else if (report.status == LcpStatus::kSolved) {
    result.status = "solved";
    result.residual = result.residual_worst = lcp_residual(file, z);
    result.f = z;
  }
  judge(result, file.status, tolerance);
  return {result};
}

/// The methods to use on a file; none if the one asked for does not go with it.
std::vector<std::string> methods_for(const std::string& asked, const Kind& kind) {
  if (asked == "all") return kind.methods;
  if (asked.empty()) return {kind.methods.front()};
  const bool applies = std::find(kind.methods.begin(), kind.methods.end(), asked) != kind.methods.end();
  return applies ? std::vector{asked} : std::vector<std::string>();
}

Kind kind_of(const ProblemFile& file) {
  return std::visit([](const auto& f) { return kind(f); }, file);
}

/// All files by all methods that were asked for.
std::vector<SolveResult> solve_all(const std::vector<ProblemFile>& files, const Options& options) {
  std::vector<SolveResult> results;
  ProgressLine line(false);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Kind k = kind_of(files[i]);
    const std::vector<std::string> methods = methods_for(options.method, k);
    // A file's time is that of all its methods.
    const Repetition repetition{options.repeat, options.solve_time_s / static_cast<double>(methods.size())};
    const double tolerance = options.tolerance.value_or(default_tolerance(files[i]));
    for (const std::string& method : methods) {
      line.show(
          fmt::format("{} of {}: {} by {}", i + 1, files.size(), printable(options.problems[i].string()), method));
      auto rows = std::visit([&](const auto& f) { return solve(f, method, tolerance, repetition); }, files[i]);
      for (SolveResult& row : rows) {
        row.name = printable(row.name);  // A file's may hold any bytes.
        row.problem = k.problem;
        row.method = method;
        results.push_back(std::move(row));
      }
    }
  }
  line.clear();
  return results;
}

/// What is wrong with the files that the command names, whatever is in them; empty: nothing.
std::string wrong_files(const Options& options) {
  const auto& written = options.written;
  if (!written.empty() && written.extension() != ".fcp" && !is_fclib_file(written)) {
    return fmt::format("--write: {} must end in .hdf5 or .h5 (FCLIB) or in .fcp", written.string());
  }
  if (!written.empty() && options.problems.size() > 1) return "--write: takes one problem";
  std::vector<std::filesystem::path> all = options.problems;
  all.push_back(written);
  for (const auto& file : all) {
    if (is_fclib_file(file) && !fclib_obstacle().empty()) return file.string() + ": " + fclib_obstacle();
  }
  return "";
}

}  // namespace

int solve(const Options& options) {
  if (const std::string wrong = wrong_files(options); !wrong.empty()) {
    std::cerr << wrong << '\n';
    return kBadUsage;
  }
  if (!options.written.empty()) check_results({{"--write", options.written}}, options.problems);
  std::vector<ProblemFile> files;
  for (const auto& file : options.problems) files.push_back(read_problem(file));
  const auto* const contact = std::get_if<ContactFile>(&files.front());
  if (!options.written.empty() && contact == nullptr) {
    std::cerr << fmt::format("--write: takes a contact problem, and {} is none\n",
                             printable(options.problems.front().string()));
    return kBadUsage;
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Kind k = kind_of(files[i]);
    if (!methods_for(options.method, k).empty()) continue;
    std::cerr << fmt::format("--method: {} does not solve {} ({}), for which there are {} and all\n", options.method,
                             printable(options.problems[i].string()), k.problem, fmt::join(k.methods, ", "));
    return kBadUsage;
  }

  const std::vector<SolveResult> results = solve_all(files, options);
  if (options.format == "json") {
    ordered_json all{{"results", ordered_json::array()}};
    for (const SolveResult& result : results) all["results"].push_back(to_json(result, options.forces));
    std::cout << all.dump(2) << '\n';
  } else {
    std::cout << solve_table(results, options.forces);
  }
  bool right = true;
  for (const SolveResult& result : results) {
    if (result.fault.empty()) continue;
    right = false;
    std::cerr << fmt::format("failed: {} by {}: {}\n", result.name, result.method, result.fault);
  }
  if (!options.written.empty()) write_found(*contact, results.front(), options.written);
  return right ? kDone : kFailed;
}

}  // namespace thenar::app
