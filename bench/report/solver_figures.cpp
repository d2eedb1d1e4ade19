// What the charts of the solvers are drawn from, as one JSON file: solver_charts FILE. Times are medians; every time stands
// beside the accuracy it was had at, which is computed here and not taken from the solver.

#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/report/measure.h"
#include "bench/report/polygon_cone.h"
#include "bench/contact_families.h"
#include "bench/contact_methods.h"
#include "bench/grasp_families.h"
#include "bench/recorded.h"
#include "engine/summary.h"
#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kSolved = 1e-6;  // Natural-map residual of a solved contact problem.

/// Three flattened pulps of so many contacts each, all of them pressed.
RandomContacts pressed_contacts(Index per_finger, std::uint64_t seed) {
  Random random(seed);
  families::GraspScene scene;
  scene.per_finger = per_finger;
  scene.pulp_radius_m = 0.05;
  scene.depth_m = 2e-3;
  RandomContacts problem = families::grasp(scene, random);
  problem.mu.setConstant(0.7);
  return problem;
}

std::vector<ContactMethod> contact_methods() {
  std::vector<ContactMethod> methods = our_contact_methods();
  for (ContactMethod& peer : contact_peers()) methods.push_back(std::move(peer));
  return methods;
}

/// Those that can reach any residual.
std::vector<ContactMethod> coulomb_methods() {
  std::vector<ContactMethod> methods = contact_methods();
  std::erase_if(methods, [](const ContactMethod& method) { return method.stops_by == ContactMethod::kOtherLaw; });
  return methods;
}

double residual_of(const MatrixXd& W, const VectorXd& delta_free, const VectorXd& mu, const VectorXd& f) {
  if (!f.allFinite()) return std::numeric_limits<double>::infinity();
  return natural_map_residual(W, delta_free, mu, f, W * f + delta_free);
}

struct Solved {
  double us, residual;
};

/// How long a method needs to kSolved, cold. Ours stop by the residual that is judged here; peers by measures of their own,
/// and are given the loosest tolerance of theirs that is enough.
std::optional<Solved> time_to_solve(const ContactMethod& method, const RandomContacts& p, int repeats) {
  constexpr int kMaxSweeps = 3000;
  const ContactSolver solve = method.prepare(p.W, p.delta_free, p.mu);
  const auto tolerances =
      method.stops_by == ContactMethod::kNaturalMap ? std::vector{kSolved} : std::vector{1e-4, 1e-6, 1e-8, 1e-10};
  for (const double tolerance : tolerances) {
    VectorXd f = VectorXd::Zero(3 * p.contacts());
    double us = time_us([&] { solve(tolerance, kMaxSweeps, f); });
    const double residual = residual_of(p.W, p.delta_free, p.mu, f);
    if (residual > 1.001 * kSolved) continue;
    if (repeats > 1)
      us = median_us(
          repeats, [&] { f.setZero(); }, [&] { solve(tolerance, kMaxSweeps, f); });
    return Solved{us, residual};
  }
  return std::nullopt;
}

// --- Residual over microseconds and over sweeps --------------------------------------------------------------------

/// One curve: each budget is a solve of its own from the same start.
ordered_json residual_curve(const std::string& problem, const std::string& start, const std::string& method,
                            const ContactSolver& solve, const VectorXd& f_start, const auto& residual) {
  constexpr double kNever = 1e-16;
  ordered_json curve{{"problem", problem}, {"start", start}, {"method", method}};
  double best = std::numeric_limits<double>::infinity();
  for (int budget = 1; budget <= 1000; budget = budget < 10 ? budget + 1 : budget * 6 / 5) {
    VectorXd f;
    const double us = median_us(
        31, [&] { f = f_start; }, [&] { solve(kNever, budget, f); });
    const double reached = residual(f);
    curve["sweeps"].push_back(budget);
    curve["us"].push_back(us);
    curve["residual"].push_back(std::min(reached, 10.0));
    // Where sweeps no longer gain, the curve ends.
    if (reached > 0.999 * best && (best < 1e-12 || budget > 300)) break;
    best = std::min(best, reached);
    if (reached < 1e-15) break;
  }
  return curve;
}

void contact_residual(ordered_json& curves) {
  struct Case {
    std::string problem, start;
    const MatrixXd& W;
    const VectorXd &delta_free, &mu, f_start;
  };
  const ContactFile& scene = recorded_run(60).contacts.front();
  const RandomContacts pressed = pressed_contacts(20, 1);
  std::vector<Case> cases;
  cases.push_back({"box grasp, 60 contacts", "cold", scene.W, scene.delta_free.front(), scene.mu, VectorXd::Zero(180)});
  cases.push_back({"box grasp, 60 contacts", "warm", scene.W, scene.delta_free.front(), scene.mu, scene.f_last});
  cases.push_back({"60 pressed contacts", "cold", pressed.W, pressed.delta_free, pressed.mu, VectorXd::Zero(180)});
  for (const Case& c : cases) {
    const auto residual = [&](const VectorXd& f) { return residual_of(c.W, c.delta_free, c.mu, f); };
    for (const ContactMethod& method : contact_methods()) {
      // Newton alone, without the many sweeps that usually leave it nothing to do.
      const bool is_newton = std::string_view(method.name) == "newton";
      const ContactSolver solve =
          is_newton ? newton_after_sweeps(c.W, c.delta_free, c.mu, 20) : method.prepare(c.W, c.delta_free, c.mu);
      curves.push_back(
          residual_curve(c.problem, c.start, is_newton ? "newton_alone" : method.name, solve, c.f_start, residual));
    }
  }
}

// --- Time over the number of contacts ------------------------------------------------------------------------------

void contact_growth(ordered_json& curves) {
  constexpr std::array<Index, 11> kPerFinger{2, 3, 5, 7, 10, 14, 20, 28, 40, 56, 83};
  constexpr std::uint64_t kProblems = 5;
  constexpr double kPatience_us = 10e3;
  for (const ContactMethod& method : coulomb_methods()) {
    std::vector<double> sizes, times;
    double worst = 0.0;
    for (const Index k : kPerFinger) {
      std::vector<double> us;
      for (std::uint64_t seed = 0; seed < kProblems; ++seed) {
        const RandomContacts p = pressed_contacts(k, seed);
        if (const auto solved = time_to_solve(method, p, 11)) {
          us.push_back(solved->us);
          worst = std::max(worst, solved->residual);
        }
      }
      if (us.size() < kProblems) continue;
      sizes.push_back(static_cast<double>(3 * k));
      times.push_back(percentiles(us).p50);
      if (times.back() > kPatience_us) break;
    }
    if (sizes.size() < 2) continue;
    curves.push_back({{"method", method.name},
                      {"contacts", sizes},
                      {"us", times},
                      {"residual_worst", worst},
                      {"exponent", exponent(sizes, times)}});
  }
}

// --- Grasp forces --------------------------------------------------------------------------------------------------

struct GraspMethod {
  const char* name;
  FrictionCone cone;
  std::function<GraspReport(const GraspProblem&, VectorXd&)> solve;
};

std::vector<GraspMethod> grasp_methods() {
  auto work = std::make_shared<GraspWorkspace>();
  return {{"active_set", FrictionCone::kPyramid,
           [](const GraspProblem& p, VectorXd& f) { return solve_grasp_forces(p, f); }},
          {"lemke", FrictionCone::kPyramid,
           [work](const GraspProblem& p, VectorXd& f) { return solve_grasp_forces_by_lemke(p, *work, f); }},
          {"exact_cone", FrictionCone::kExact,
           [](const GraspProblem& p, VectorXd& f) { return solve_grasp_forces(p, f); }}};
}

/// Problems of a hand at work with n contacts: half of them out of reach.
std::vector<Grasp> grasps(Index n, int count) {
  std::vector<Grasp> all;
  for (int seed = 0; seed < count; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    all.push_back(grasp_families::box_or_sphere(random, n));
  }
  return all;
}

void grasp_growth(ordered_json& curves) {
  for (const GraspMethod& method : grasp_methods()) {
    ordered_json curve{{"method", method.name}};
    for (Index n = 2; n <= 8; ++n) {
      std::vector<double> us;
      double worst = 0.0;
      VectorXd f(3 * n);
      for (const Grasp& grasp : grasps(n, 1000)) {
        const GraspProblem problem = grasp.problem(method.cone);
        GraspReport report;
        us.push_back(median_us(
            5, [] {}, [&] { report = method.solve(problem, f); }));
        const bool optimal = report.status == GraspStatus::kOptimal;
        if (report.status == GraspStatus::kBudgetSpent) worst = std::numeric_limits<double>::infinity();
        worst = std::max(worst, optimal ? grasp_kkt_error(problem, report.multiplier, f)
                                        : infeasibility_gap(problem, report.multiplier));
      }
      const Percentiles times = percentiles(us);
      curve["contacts"].push_back(n);
      curve["us"].push_back(times.p50);
      curve["p99_us"].push_back(times.p99);
      curve["worst_proof"].push_back(worst);
    }
    curves.push_back(curve);
  }
  for (const LcpMethod& peer : lcp_peers()) {
    ordered_json curve{{"method", peer.name}};
    for (Index n = 2; n <= 8; ++n) {
      std::vector<double> us;
      int wrong = 0;
      const std::vector<Grasp> problems = grasps(n, 200);
      for (const Grasp& grasp : problems) {
        const GraspProblem problem = grasp.problem(FrictionCone::kPyramid);
        VectorXd f(3 * n), z = VectorXd::Zero(5 * n);
        const bool feasible = solve_grasp_forces(problem, f).status == GraspStatus::kOptimal;
        GraspWorkspace work;
        (void)solve_grasp_forces_by_lemke(problem, work, f);  // For its M and q: a peer is given the LCP.
        if (work.q.size() != 5 * n) continue;
        const LcpSolver solve = peer.prepare(work.M.topRows(5 * n), work.q);
        bool claimed = false;
        us.push_back(median_us(
            5, [&] { z.setZero(); }, [&] { claimed = solve(z); }));
        wrong += claimed != feasible;
      }
      curve["contacts"].push_back(n);
      curve["us"].push_back(percentiles(us).p50);
      curve["wrong_verdicts_percent"].push_back(100.0 * wrong / static_cast<double>(problems.size()));
    }
    curves.push_back(curve);
  }
}

/// What a pyramid of N sides errs, against the exact cone, on problems whose solution is on the cone.
void pyramid_error(ordered_json& points) {
  constexpr Index kContacts = 3;
  constexpr std::array kSides{4, 8, 16, 32};
  std::vector<std::vector<double>> us(kSides.size() + 1), error(kSides.size() + 1);
  int used = 0;
  for (std::uint64_t seed = 0; used < 1000; ++seed) {
    Random random(seed);
    const Grasp grasp = grasp_families::box_or_sphere(random, kContacts);
    const GraspProblem problem = grasp.problem(FrictionCone::kExact);
    VectorXd exact(3 * kContacts), f(3 * kContacts);
    GraspReport report = solve_grasp_forces(problem, exact);
    if (report.status != GraspStatus::kOptimal || report.iterations == 0) continue;
    ++used;
    us.back().push_back(median_us(
        5, [] {}, [&] { report = solve_grasp_forces(problem, f); }));
    error.back().push_back(grasp_kkt_error(problem, report.multiplier, exact));
    for (std::size_t s = 0; s < kSides.size(); ++s) {
      us[s].push_back(median_us(
          5, [] {}, [&] { solve_polygon_cone(problem, kSides[s], f); }));
      error[s].push_back((f - exact).norm() / exact.norm());
    }
  }
  for (std::size_t s = 0; s <= kSides.size(); ++s) {
    std::sort(error[s].begin(), error[s].end());
    points.push_back({{"name", s < kSides.size() ? std::to_string(kSides[s]) + " sides" : "exact cone"},
                      {"us", percentiles(us[s]).p50},
                      {"error_median", percentile(error[s], 0.5)},
                      {"error_p90", percentile(error[s], 0.9)}});
  }
}

// --- Share of solved problems over time ----------------------------------------------------------------------------

void profile(ordered_json& curves, std::uint64_t problems) {
  for (const ContactFamily& family : kContactFamilies) {
    for (const ContactMethod& method : coulomb_methods()) {
      std::vector<double> us;
      for (std::uint64_t seed = 0; seed < problems; ++seed) {
        if (const auto solved = time_to_solve(method, family.make(seed), 1)) us.push_back(solved->us);
      }
      curves.push_back({{"family", family.name}, {"method", method.name}, {"problems", problems}, {"us", us}});
    }
  }
}

// --- Verdicts on fresh problems ------------------------------------------------------------------------------------

// Seeds that no solver's constants were chosen on.
constexpr std::uint64_t kFresh = 1'000'000;
constexpr int kFreshProblems = 1000;

void contact_verdicts(ordered_json& rows) {
  AccurateWorkspace work(64);  // The largest of them: a box on 8 x 8 points.
  for (const ContactFamily& family : kContactFamilies) {
    const FamilyRecord record = run_family(family, kFresh, kFreshProblems, [&](const RandomContacts& p) {
      VectorXd f = VectorXd::Zero(3 * p.contacts()), delta(f.size());
      FamilyAnswer answer;
      answer.time_us = time_us(
          [&] { answer.report = solve_contacts_accurately(p.W, p.delta_free, p.mu, {}, work, f, delta).solve; });
      // Judged here, not by the solver: forces by their residual, the lack of them by the proof.
      if (answer.report.status == SolveStatus::kConverged) {
        answer.report.residual = residual_of(p.W, p.delta_free, p.mu, f);
        if (answer.report.residual > 1.001e-8) answer.report.status = SolveStatus::kBudgetSpent;
      }
      return answer;
    });
    const Percentiles us = percentiles(record.times_us);
    rows.push_back({{"family", family.name},
                    {"solved", record.solved},
                    {"no_solution", record.no_solution},
                    {"unanswered", record.unanswered},
                    {"worst_residual", record.worst_residual},
                    {"p50_us", us.p50},
                    {"p99_us", us.p99}});
  }
}

void grasp_verdicts(ordered_json& rows) {
  for (const GraspMethod& method : grasp_methods()) {
    for (const GraspFamily& family : kGraspFamilies) {
      int optimal = 0, infeasible = 0, unanswered = 0;
      double worst = 0.0, worst_gap = 0.0;
      std::vector<double> us;
      for (int i = 0; i < kFreshProblems; ++i) {
        const Grasp grasp = family.problem(kFresh + static_cast<std::uint64_t>(i));
        const GraspProblem problem = grasp.problem(method.cone);
        VectorXd f(3 * grasp.n());
        GraspReport report;
        us.push_back(time_us([&] { report = method.solve(problem, f); }));
        if (report.status == GraspStatus::kOptimal) {
          ++optimal;
          worst = std::max(worst, grasp_kkt_error(problem, report.multiplier, f));
        } else if (report.status == GraspStatus::kInfeasible) {
          ++infeasible;
          worst_gap = std::max(worst_gap, infeasibility_gap(problem, report.multiplier));
        } else {
          ++unanswered;
        }
      }
      const Percentiles times = percentiles(us);
      rows.push_back({{"method", method.name},
                      {"family", family.name},
                      {"optimal", optimal},
                      {"infeasible", infeasible},
                      {"unanswered", unanswered},
                      {"worst_kkt_error", worst},
                      {"worst_gap", worst_gap},
                      {"p50_us", times.p50},
                      {"p99_us", times.p99}});
    }
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  if (argc != 2) {
    std::cerr << "usage: solver_charts FILE\n";
    return 2;
  }
  nlohmann::ordered_json data{{"build", build_settings()}, {"peers", !contact_peers().empty()}};
  data["note"] = "medians; " + data["build"].at("compiler").get<std::string>() + " " +
                 data["build"].at("flags").get<std::string>();
  std::cerr << "residual over time ...\n";
  contact_residual(data["contact_residual"]);
  std::cerr << "time over contacts ...\n";
  grasp_growth(data["grasp_growth"]);
  contact_growth(data["contact_growth"]);
  std::cerr << "pyramids ...\n";
  pyramid_error(data["pyramid"]);
  std::cerr << "families ...\n";
  profile(data["profile"], 100);
  std::cerr << "verdicts ...\n";
  contact_verdicts(data["contact_verdicts"]);
  grasp_verdicts(data["grasp_verdicts"]);
  std::ofstream(argv[1]) << data.dump(1) << '\n';
}
