// Contact solvers on random families, from grasps to what breaks solvers: how many problems are solved in which time, and
// what becomes of the rest.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

#include "bench/contact_families.h"
#include "bench/contact_methods.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kSolved = 1e-6;  // Natural-map residual of a solved problem.

double residual_of(const RandomContacts& p, const VectorXd& f) {
  if (!f.allFinite()) return std::numeric_limits<double>::infinity();
  return natural_map_residual(p.W, p.delta_free, p.mu, f, p.W * f + p.delta_free);
}

constexpr int kMostSweeps = 3000, kMostSteps = 200;  // Newton's steps of another project: some ten times a sweep.
constexpr double kPatience_us = 20e3;

/// How long a method needs to kSolved from zero. Ours stop by the residual that is judged here; peers by measures of
/// their own, and are given the loosest tolerance of theirs that is enough, as long as they do not take for ever.
std::optional<double> time_to_solve_us(const ContactMethod& method, const RandomContacts& p) {
  const ContactSolver solve = method.prepare(p.W, p.delta_free, p.mu);
  const int budget = std::string_view(method.name) == "siconos_nsn" ? kMostSteps : kMostSweeps;
  const auto tolerances =
      method.stops_by == ContactMethod::kNaturalMap ? std::vector{kSolved} : std::vector{1e-4, 1e-6, 1e-8};
  for (const double tolerance : tolerances) {
    VectorXd f = VectorXd::Zero(3 * p.contacts());
    const double us = time_us([&] { solve(tolerance, budget, f); });
    if (residual_of(p, f) <= 1.001 * kSolved) return us;
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
  for (ContactMethod& peer : contact_peers()) methods.push_back(std::move(peer));
  std::erase_if(methods, [](const ContactMethod& method) { return method.stops_by == ContactMethod::kOtherLaw; });
  auto& figure = add_figure(part, "curves", "contact_share", "Contact forces: share of problems solved in so much time",
                            fmt::format("{} random problems of each family, from nothing, W given: what share a method "
                                        "has solved to a residual of 1e-6 "
                                        "in so much time or less; up and to the left is better, and where a line ends "
                                        "it has failed on the rest. The first "
                                        "two families are grasps, curved pulps and flattened ones; then come hardly "
                                        "any compliance (`stiff`), viscosities "
                                        "that differ by up to 10^4 (`ratio`), friction from 0 to 2, contacts that are "
                                        "there twice or four times, a body "
                                        "wedged between walls, a peg in a hole (a third of the interference fits have "
                                        "no solution: nobody reaches 1 there), "
                                        "and a rigid box on a plane. gauss_seidel is the default (here with up to 3000 "
                                        "sweeps); newton goes on where it "
                                        "stalls; sweeps are the published plain ones in double precision. Siconos's "
                                        "solvers stop by measures of their own, "
                                        "and each is given the loosest of 1e-4, 1e-6, 1e-8 that is enough; it is given "
                                        "up after 20 ms without success.",
                                        problems),
                            "Each problem solved once by each method, methods in turns.");
  figure["x"] = {{"label", "time of a solve [us]"}, {"log", true}};
  figure["y"] = {{"label", "share solved"}, {"log", false}};
  for (const ContactFamily& family : kContactFamilies) {
    std::vector<std::vector<double>> us(methods.size());
    for (std::uint64_t seed = 0; seed < problems; ++seed) {
      const RandomContacts p = family.make(seed);
      for (std::size_t m = 0; m < methods.size(); ++m) {
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
      panel["curves"].push_back({{"name", methods[m].name},
                                 {"x", us[m]},
                                 {"y", share},
                                 {"exponent", nullptr},
                                 {"peer", m >= our_contact_methods().size()}});
    }
  }
}

/// One of ours on a problem, judged here and not by itself: forces by their residual.
template <typename Solve>
FamilyAnswer judged(const RandomContacts& p, double tolerance, const Solve& solve) {
  VectorXd f = VectorXd::Zero(3 * p.contacts()), delta(f.size());
  FamilyAnswer answer;
  answer.time_us = time_us([&] { answer.report = solve(f, delta); });
  if (answer.report.status == SolveStatus::kConverged) {
    answer.report.residual = residual_of(p, f);
    if (!(answer.report.residual <= 1.001 * tolerance)) answer.report.status = SolveStatus::kNotFinite;
  }
  return answer;
}

void add_verdicts(ordered_json& part, bool quick) {
  const int problems = quick ? 50 : 1000;
  constexpr std::uint64_t kFresh = 1'000'000;  // Seeds that no solver's constants were chosen on.
  auto& table = add_figure(part, "table", "contact_verdicts", "Contact forces: verdicts on fresh problems",
                           fmt::format("{} fresh problems of each family, from nothing. Solved: to a residual of 1e-6 "
                                       "by Gauss-Seidel as the contact loop "
                                       "has it (200 sweeps at most), and of 1e-8 by the accurate solver (Gauss-Seidel, "
                                       "then Newton's method), as computed "
                                       "here from the forces returned. No solution: proved by normal forces that move "
                                       "nothing. Unanswered: the budget is "
                                       "spent; the forces are inside their cones, the report says how good they are, "
                                       "and the loop goes on with them. Forces that miss their tolerance here would "
                                       "count as unanswered.",
                                       problems),
                           "Each problem solved once; median and 99 % of the times, clock included.");
  table["columns"] = {"family",      "solver",  "solved", "no solution", "unanswered", "worst residual of the solved",
                      "median [us]", "p99 [us]"};
  constexpr Eigen::Index kMostContacts = 64;  // A box on 8 x 8 points.
  SweepWorkspace sweeps(kMostContacts);
  AccurateWorkspace accurate(kMostContacts);
  for (const ContactFamily& family : kContactFamilies) {
    const auto tell = [&](const char* name, const auto& answer_to) {
      const FamilyRecord record = run_family(family, kFresh, problems, answer_to);
      const Percentiles us = percentiles(record.times_us);
      table["rows"].push_back({std::string(family.name), name, record.solved, record.no_solution, record.unanswered,
                               record.worst_residual, us.p50, us.p99});
    };
    tell("gauss_seidel", [&](const RandomContacts& p) {
      return judged(p, GaussSeidelSettings{}.tolerance, [&](VectorXd& f, VectorXd& delta) {
        return solve_contacts(p.W, p.delta_free, p.mu, {}, sweeps, f, delta);
      });
    });
    tell("newton", [&](const RandomContacts& p) {
      return judged(p, AccurateSettings{}.tolerance, [&](VectorXd& f, VectorXd& delta) {
        return solve_contacts_accurately(p.W, p.delta_free, p.mu, {}, accurate, f, delta).solve;
      });
    });
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  const PartArguments arguments = part_arguments(argc, argv);
  auto part = make_part(
      "contact_families", "Contact forces where solvers fail",
      "The contact solvers on random problems of families that go from grasps to what breaks solvers.", arguments);
  add_shares(part, arguments.quick);
  add_verdicts(part, arguments.quick);
  write_part(part, arguments);
}
