// SPDX-License-Identifier: Apache-2.0
// Contact solvers on random families, from grasps to what breaks solvers: how many problems are solved in which time,
// and what becomes of the rest.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "bench/cases/contact_families.h"
#include "bench/methods/contact_methods.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "bench/report/verdicts.h"

namespace thenar {
namespace {

using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kPatience_us = 20e3;

/// How long a method needs to kSolvedResidual from zero. Ours stop by the residual that is judged here; peers by
/// measures of their own, and are given the loosest tolerance of theirs that is enough, as long as they do not take for
/// ever.
std::optional<double> time_to_solve_us(const ContactMethod& method, const ContactData& p) {
  const ContactSolver solve = method.prepare(p);
  const int budget = ample_budget(method.name);
  for (const double tolerance : tolerances_to_solve(method)) {
    VectorXd f(3 * p.contacts());
    const double us = warm_time_us([&] {
      f.setZero();
      solve(tolerance, budget, f);
    });
    if (residual_of(p, f) <= 1.001 * kSolvedResidual) return us;
    if (us > kPatience_us) return std::nullopt;
  }
  return std::nullopt;
}

/// Nothing is printed while it lives: another project's solver tells of every matrix that it finds singular.
class Silence {
 public:
  Silence() : null_(open("/dev/null", O_WRONLY)), out_(dup(STDOUT_FILENO)), error_(dup(STDERR_FILENO)) {
    dup2(null_, STDOUT_FILENO);
    dup2(null_, STDERR_FILENO);
  }
  ~Silence() {
    std::fflush(stdout);
    dup2(out_, STDOUT_FILENO);
    dup2(error_, STDERR_FILENO);
    for (const int file : {null_, out_, error_}) close(file);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int null_, out_, error_;
};

void add_shares(ordered_json& part, bool quick) {
  const std::uint64_t problems = quick ? 10 : 100;
  const Silence silence;
  std::vector<ContactMethod> methods = our_contact_methods();
  const std::size_t ours = methods.size();
  for (ContactMethod& peer : contact_peers()) methods.push_back(std::move(peer));
  std::erase_if(methods, [](const ContactMethod& method) { return method.stops_by == ContactMethod::kOtherLaw; });
  auto& figure = add_figure(
      part, "curves", "contact_share", "Contact forces: share of problems solved in so much time",
      fmt::format(
          "What share of {} random problems of each family a method has solved to a residual of 1e-6, from nothing, "
          "in so much time or less; up and to the left is better, and where a line ends it has failed on the rest. "
          "All are given W as a matrix. Gauss-Seidel is the default's method, here with up to 3000 sweeps (the "
          "default stops after {}); Newton's goes on where it stalls; plain sweeps are the published ones. Siconos's "
          "solvers stop by measures of their own: each is given the loosest of 1e-4, 1e-6, 1e-8 that is enough, and "
          "is given up after 20 ms without success.",
          problems, GaussSeidelSettings{}.max_sweeps),
      "Each problem solved by each method twice in a row, the second time counted (the first where it is over 5 ms); "
      "the order of methods goes round.");
  figure["x"] = {{"label", "time of a solve [µs]"}, {"log", true}};
  figure["y"] = {{"label", "share solved"}, {"log", false}};
  for (const ContactFamily& family : kContactFamilies) {
    std::vector<std::vector<double>> us(methods.size());
    for (std::uint64_t seed = 0; seed < problems; ++seed) {
      const ContactData p = family.make(seed);
      for (std::size_t k = 0; k < methods.size(); ++k) {
        const std::size_t m = (seed + k) % methods.size();
        if (const auto time = time_to_solve_us(methods[m], p)) us[m].push_back(*time);
      }
    }
    auto& panel = figure["panels"].emplace_back(ordered_json{{"name", std::string(family.name)}});
    for (std::size_t m = 0; m < methods.size(); ++m) {
      std::sort(us[m].begin(), us[m].end());
      std::vector<double> share;
      for (std::size_t i = 0; i < us[m].size(); ++i) {
        share.push_back(static_cast<double>(i + 1) / static_cast<double>(problems));
      }
      panel["curves"].push_back(
          {{"name", methods[m].name}, {"x", us[m]}, {"y", share}, {"exponent", nullptr}, {"peer", m >= ours}});
    }
  }
}

/// Judges one of ours, solve(solution), by the residual of its forces. That there is no solution it has proved.
template <typename Solve>
void judge(const ContactData& p, double tolerance, const Solve& solve, Verdicts& verdicts) {
  VectorXd f(3 * p.contacts()), delta(f.size());
  SolveReport report;
  const double us = warm_time_us([&] {
    f.setZero();
    report = solve({f, delta});
  });
  if (report.status == SolveStatus::kConverged) {
    const double residual = residual_of(p, f);
    verdicts.add(Claim::kSolved, residual <= 1.001 * tolerance, residual, us);
  } else {
    const bool none = report.status == SolveStatus::kNoSolution;
    verdicts.add(none ? Claim::kNoSolution : Claim::kNone, true, 0.0, us);
  }
}

void add_verdicts(ordered_json& part, bool quick) {
  const std::uint64_t problems = quick ? 50 : 1000;
  auto& table = add_figure(
      part, "table", "contact_verdicts", "Contact forces: what was said, and how much of it was wrong",
      fmt::format(
          "{} fresh problems of each family, from nothing. Solved: to a residual of 1e-6 by Gauss-Seidel as the "
          "contact loop has it (200 sweeps at most), and of 1e-8 by the accurate solver (300 sweeps, then Newton's "
          "method); wrong is forces that miss it, as computed here. None: proved by normal forces that move nothing. "
          "No answer: the budget is spent; the forces are inside their cones, the report says how good they are, and "
          "the loop goes on with them.",
          problems),
      "Each problem solved by each method twice in a row; median and 99 % of the second times (the first where it is "
      "over 5 ms), clock included.");
  table["columns"] = {"family", "solver"};
  for (const char* column : kVerdictColumns) table["columns"].push_back(column);
  constexpr Eigen::Index kMostContacts = 64;  // A box on 8 x 8 points.
  SweepWorkspace sweeps(kMostContacts);
  AccurateWorkspace accurate(kMostContacts);
  for (const ContactFamily& family : kContactFamilies) {
    Verdicts gauss_seidel, newton;
    for (std::uint64_t i = 0; i < problems; ++i) {
      const ContactData p = family.make(kFresh + i);
      judge(
          p, GaussSeidelSettings{}.tolerance,
          [&](ContactSolution solution) { return solve_contacts(p, {}, sweeps, solution); }, gauss_seidel);
      judge(
          p, AccurateSettings{}.tolerance,
          [&](ContactSolution solution) { return solve_contacts_accurately(p, {}, accurate, solution).solve; }, newton);
    }
    const std::vector<ContactMethod> names = our_contact_methods();
    for (const auto& [name, verdicts] : {std::pair{names[0].name, &gauss_seidel}, {names[2].name, &newton}}) {
      ordered_json row{std::string(family.name), name};
      verdicts->append_to(row);
      table["rows"].push_back(row);
    }
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(argc, argv, "contact_families", "Contact forces where solvers fail",
                          "The contact solvers on random problems. The first two families are grasps, curved pulps "
                          "and flattened ones; then come hardly any compliance (stiff), viscosities that differ by up "
                          "to 10^4 (ratio), friction from 0 to 2, contacts that are there twice or four times, a body "
                          "wedged between walls, a peg in a hole (a third of the interference fits have no solution: "
                          "nobody reaches 1 there), and a rigid box on a plane.",
                          {thenar::add_shares, thenar::add_verdicts});
}
