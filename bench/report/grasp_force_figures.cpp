// SPDX-License-Identifier: Apache-2.0
// Grasp forces: error against time, verdicts, growth.

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "bench/cases/grasp_families.h"
#include "bench/cases/scene_problems.h"
#include "bench/peers/peers.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "bench/report/polygon_cone.h"
#include "bench/report/verdicts.h"
#include "engine/finder/grasp_deficit.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr const char* kExactCone = "exact cone";  // What a scene gets that says nothing.
constexpr double kProved = 1e-6;                  // Error below which an answer counts as right.

/// A problem's optimum in one cone, and how far its proof leaves it open, as a share of the forces: no error is told
/// more closely.
struct Optimum {
  VectorXd f;
  double open = 0.0;
};

std::optional<Optimum> optimum_of(const GraspProblem& problem) {
  Optimum optimum{VectorXd(3 * std::ssize(problem.contacts))};
  const GraspReport report = solve_grasp_forces(problem, optimum.f);
  if (report.status != GraspStatus::kOptimal) return {};
  optimum.open = grasp_kkt_error(problem, report.multiplier, optimum.f);
  return optimum;
}

/// The distance of forces from the optimum, as a share of the optimum; no number where there are none.
double error_of(const std::optional<VectorXd>& f, const Optimum& optimum) {
  if (!f || !f->allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return std::max(optimum.open, (*f - optimum.f).norm() / optimum.f.norm());
}

/// Problems to be solved by every method, with the proved optima of both cones.
struct Case {
  std::string name;
  std::vector<Grasp> grasps;
  std::vector<Optimum> pyramid, exact;

  /// Takes a problem that both cones can solve.
  void add(const Grasp& grasp) {
    const auto in_pyramid = optimum_of(grasp.problem(FrictionCone::kPyramid)),
               in_exact = optimum_of(grasp.problem(FrictionCone::kExact));
    if (!in_pyramid || !in_exact) return;
    grasps.push_back(grasp);
    pyramid.push_back(*in_pyramid);
    exact.push_back(*in_exact);
  }
};

struct Method {
  std::string name, setting;
  bool peer, published;
  FrictionCone cone;  ///< Of the problem that it is given.
  /// Prepares a problem; the call solves it. The forces are asked for afterwards; none without an answer.
  struct Prepared {
    std::function<void()> solve;
    std::function<std::optional<VectorXd>()> forces;
  };
  std::function<Prepared(const Grasp&)> prepare;
};

/// Of solve(problem, f), true if it solves into f.
template <typename Solve>
Method::Prepared prepared(const GraspProblem& problem, const Solve& solve) {
  auto f = std::make_shared<VectorXd>(3 * std::ssize(problem.contacts));
  auto solved = std::make_shared<bool>(false);
  return {[=] { *solved = solve(problem, *f); }, [=] { return *solved ? std::optional<VectorXd>(*f) : std::nullopt; }};
}

using Solver = std::function<GraspReport(const GraspProblem&, VectorXd&)>;

/// One of ours.
struct Ours {
  const char* name;
  FrictionCone cone;
  bool published;
  Solver solve;
};

std::vector<Ours> our_solvers() {
  const Solver active_set = [](const GraspProblem& p, VectorXd& f) { return solve_grasp_forces(p, f); };
  const Solver lemke = [work = std::make_shared<GraspWorkspace>()](const GraspProblem& p, VectorXd& f) {
    return solve_grasp_forces_by_lemke(p, *work, f);
  };
  return {{"active set on pyramids", FrictionCone::kPyramid, false, active_set},
          {"Lemke on pyramids", FrictionCone::kPyramid, true, lemke},
          {kExactCone, FrictionCone::kExact, false, active_set}};
}

Method polygon(int sides) {
  return {"polygon cone", fmt::format("{} sides", sides), true, false, FrictionCone::kExact, [=](const Grasp& grasp) {
            return prepared(grasp.problem(FrictionCone::kExact),
                            [=](const GraspProblem& p, VectorXd& f) { return solve_polygon_cone(p, sides, f); });
          }};
}

/// f = pi (A'z - c) + G^+ W^d of the LCP's z, whose rows are those of Lemke's method: face by face over the contacts.
VectorXd forces_of(const Grasp& grasp, const VectorXd& z) {
  const Index n = grasp.n();
  MatrixXd G(6, 3 * n);
  grasp_map(grasp.contacts, grasp.centre_m, G);
  VectorXd pulled(3 * n);
  for (Index i = 0; i < n; ++i) {
    const Eigen::Vector3d f_C(
        grasp.friction * (z[i] + z[n + i] + z[2 * n + i] + z[3 * n + i]) + z[4 * n + i] + grasp.internal_force_N,
        z[n + i] - z[i], z[3 * n + i] - z[2 * n + i]);
    pulled.segment<3>(3 * i) = grasp.contacts[i].axes * f_C;
  }
  const VectorXd missing = grasp.wrench - G * pulled;
  return pulled + G.completeOrthogonalDecomposition().solve(missing);
}

/// The problem's LCP, as our Lemke forms it; empty if it is seen to be out of reach before there is one.
LcpData lcp_of(const Grasp& grasp) {
  GraspWorkspace work;
  VectorXd f(3 * grasp.n());
  (void)solve_grasp_forces_by_lemke(grasp.problem(FrictionCone::kPyramid), work, f);
  return {work.M.topRows(work.q.size()), work.q};
}

Method peer_method(const LcpMethod& peer) {
  return {peer.name, "", true, false, FrictionCone::kPyramid, [peer](const Grasp& grasp) {
            const LcpData lcp = lcp_of(grasp);
            if (lcp.q.size() == 0) {
              return Method::Prepared{[] {}, [] { return std::optional<VectorXd>(); }};
            }
            auto z = std::make_shared<VectorXd>(lcp.q.size());
            auto solved = std::make_shared<bool>(false);
            return Method::Prepared{
                [=, solve = peer.prepare(lcp)] {
                  z->setZero();
                  *solved = solve(*z);
                },
                [=] { return *solved ? std::optional<VectorXd>(forces_of(grasp, *z)) : std::nullopt; }};
          }};
}

std::vector<Method> solvers() {
  std::vector<Method> methods;
  for (const Ours& ours : our_solvers()) {
    const auto solve = [solver = ours.solve](const GraspProblem& p, VectorXd& f) {
      return solver(p, f).status == GraspStatus::kOptimal;
    };
    methods.push_back({ours.name, "", false, ours.published, ours.cone,
                       [=](const Grasp& grasp) { return prepared(grasp.problem(ours.cone), solve); }});
  }
  for (const LcpMethod& peer : lcp_peers()) methods.push_back(peer_method(peer));
  return methods;
}

std::vector<Case> make_cases(bool quick) {
  constexpr double kMoreFriction = 1.2;
  const int count = quick ? 20 : 50;
  std::vector<Case> as_asked, scarce;
  for (const char* scene : {"box_grasp", "box_turn", "capsule", "mug"}) {
    Case asked{scene, {}, {}, {}}, little{std::string(scene) + ", little friction", {}, {}, {}};
    for (const GraspFile& file : scene_problems(scene, {}, {0.4, 1.2, count}).grasps) {
      Grasp grasp{file};
      asked.add(grasp);
      grasp.friction = kMoreFriction * explain_infeasible_grasp(grasp.problem(FrictionCone::kExact)).least_friction;
      little.add(grasp);
    }
    as_asked.push_back(asked);
    scarce.push_back(little);
  }
  Case random{"random, three contacts", {}, {}, {}};
  for (std::uint64_t seed = 0; std::ssize(random.grasps) < count; ++seed) {
    Random numbers(seed);
    const Grasp grasp = grasp_families::box_or_sphere(numbers, 3);
    VectorXd f(9);
    // Where no cone is touched there is nothing to solve.
    if (solve_grasp_forces(grasp.problem(FrictionCone::kExact), f).iterations > 0) random.add(grasp);
  }
  std::vector<Case> cases = as_asked;
  cases.insert(cases.end(), scarce.begin(), scarce.end());
  cases.push_back(random);
  return cases;
}

// --- Error against time --------------------------------------------------------------------------------------------

struct Measured {
  WorkPoint of_own_problem, of_coulomb;
};

std::vector<Measured> measure(const Case& c, const std::vector<Method>& methods, int turns) {
  std::vector<Measured> points;
  std::vector<std::vector<Method::Prepared>> prepared;
  std::vector<std::function<void()>> rounds;
  for (const Method& method : methods) {
    auto& problems = prepared.emplace_back();
    for (const Grasp& grasp : c.grasps) problems.push_back(method.prepare(grasp));
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const Method& method = methods[m];
    double own = 0.0, coulomb = 0.0;
    for (std::size_t i = 0; i < c.grasps.size(); ++i) {
      prepared[m][i].solve();
      const std::optional<VectorXd> f = prepared[m][i].forces();
      own = worse(own, error_of(f, method.cone == FrictionCone::kExact ? c.exact[i] : c.pyramid[i]));
      coulomb = worse(coulomb, error_of(f, c.exact[i]));
    }
    const WorkPoint point{
        .method = method.name, .setting = method.setting, .peer = method.peer, .published = method.published};
    points.push_back({point, point});
    points.back().of_own_problem.error = own;
    points.back().of_coulomb.error = coulomb;
    points.back().of_coulomb.is_default = method.name == kExactCone;
    rounds.emplace_back([&problems = prepared[m]] {
      for (const Method::Prepared& problem : problems) problem.solve();
    });
  }
  const std::vector<double> us = times_in_turns(rounds, turns);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    points[m].of_own_problem.us = points[m].of_coulomb.us = us[m] / static_cast<double>(c.grasps.size());
  }
  return points;
}

void add_work_precision(ordered_json& part, bool quick) {
  const int turns = quick ? 31 : 101;
  std::vector<Method> methods = solvers();
  const std::size_t count = methods.size();
  for (const int sides : {4, 8, 16, 32}) methods.push_back(polygon(sides));
  ordered_json own = ordered_json::array(), coulomb = ordered_json::array();
  for (const Case& c : make_cases(quick)) {
    std::vector<WorkPoint> own_points, coulomb_points;
    const std::vector<Measured> measured = measure(c, methods, turns);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      if (m < count) own_points.push_back(measured[m].of_own_problem);
      coulomb_points.push_back(measured[m].of_coulomb);
    }
    own.push_back({{"name", c.name}, {"points", own_points}});
    coulomb.push_back({{"name", c.name}, {"points", coulomb_points}});
  }
  const std::string runs = fmt::format(
      "Time of a call: a round of all the panel's problems, over their number; medians of {} rounds, in which the "
      "methods took turns. Errors: the worst of the panel's problems.",
      turns);
  auto& first = add_figure(
      part, "work_precision", "grasp_own", "Grasp forces: error in the method's own problem",
      "Every method that answers solves its own problem far more closely than a hand could feel: this compares times. "
      "The error is the distance of the forces from the proved optimum in the method's own cone, as a share of the "
      "forces, and no less than what the proof leaves open; below 1e-12 it is rounding.",
      runs);
  first.update({{"error", "worst error of the forces, in the method's own problem"},
                {"time", "time of a solve [µs]"},
                {"cases", own}});
  auto& second = add_figure(
      part, "work_precision", "grasp_coulomb", "Grasp forces: error against Coulomb's cone",
      "The same solves, judged by what they are for: forces in Coulomb's round cone. The error is the distance of the "
      "forces from the proved optimum in that cone, as a share of them, and no less than what the proof leaves open; "
      "below 1e-12 it is rounding. Where friction is scarce a pyramid lets forces out of the cone at its edges, "
      "however exactly it is solved, and polygons of more sides, a textbook's way, only approach the exact cone, the "
      "default. Where friction is ample, as the scenes have it, all cones give the same forces, and the pyramid, "
      "which the shipped scenes name, costs least of ours.",
      runs);
  second.update({{"error", "worst distance of the forces from the optimum in Coulomb's cone"},
                 {"time", "time of a solve [µs]"},
                 {"choice", "friction cone and solver"},
                 {"cases", coulomb}});
}

// --- Verdicts ------------------------------------------------------------------------------------------------------

/// Judges one of our solvers; true or false if it proved that there are forces or none.
std::optional<bool> judge(const Grasp& grasp, const Ours& ours, Verdicts& verdicts) {
  const GraspProblem problem = grasp.problem(ours.cone);
  VectorXd f(3 * grasp.n());
  GraspReport report;
  const double us = warm_time_us([&] { report = ours.solve(problem, f); });
  if (report.status == GraspStatus::kBudgetSpent) {
    verdicts.add(Claim::kNone, false, 0.0, us);
    return {};
  }
  const bool found = report.status == GraspStatus::kOptimal;
  const double error =
      found ? grasp_kkt_error(problem, report.multiplier, f) : infeasibility_gap(problem, report.multiplier);
  verdicts.add(found ? Claim::kSolved : Claim::kNoSolution, error <= kProved, error, us);
  return error <= kProved ? std::optional<bool>(found) : std::nullopt;
}

void add_verdicts(ordered_json& part, bool quick) {
  const int count = quick ? 100 : 1000;
  const std::vector<Ours> ours = our_solvers();
  const std::vector<LcpMethod> peers = lcp_peers();
  std::vector<VerdictRow> rows;
  for (const Ours& method : ours) rows.emplace_back(method.name);
  for (const LcpMethod& peer : peers) rows.emplace_back(peer.name);
  for (const GraspFamily& family : kGraspFamilies) {
    std::vector<Verdicts> here(rows.size());
    for (int i = 0; i < count; ++i) {
      const Grasp grasp = family.problem(kFresh + static_cast<std::uint64_t>(i));
      std::optional<bool> known;  // Of the pyramid.
      for (std::size_t m = 0; m < ours.size(); ++m) {
        const auto proved = judge(grasp, ours[m], here[m]);
        if (ours[m].cone == FrictionCone::kPyramid && !known) known = proved;
      }
      const LcpData lcp = lcp_of(grasp);
      if (lcp.q.size() == 0 || !known) continue;
      for (std::size_t p = 0; p < peers.size(); ++p) judge_lcp(peers[p], lcp, *known, here[ours.size() + p]);
    }
    for (std::size_t m = 0; m < rows.size(); ++m) rows[m].add(family.name, here[m]);
  }
  auto& table = add_figure(
      part, "table", "grasp_verdicts", "Grasp forces: what was said, and how much of it was wrong",
      fmt::format(
          "Fresh random problems of {} families, from those a hand meets (box, sphere, held, scattered) to those that "
          "break solvers: contacts in or near a line or there twice, no friction or much, any scale, forces on a "
          "pyramid's edge, contacts at the tip of their cones or on them (apex), nothing to do (idle), a cube with "
          "wrenches in whole numbers, where all coincides (grid), wrenches 1e-12 to 1e-2 from the limit of what the "
          "cones can give (border). The columns tell what a solver said, and how many of its words were wrong. Of "
          "ours is wrong: forces off the optimality conditions, or a twist that should prove that there are none and "
          "does not, by more than 1e-6; of other projects, a word against our proof, or an LCP solved to worse than "
          "1e-6. They are asked only where there is an LCP and a proof. After no answer of ours the controller keeps "
          "its last forces.",
          kGraspFamilies.size()),
      fmt::format("{} problems a family, solved by each method twice in a row; median and 99 % of the second times, "
                  "clock included.",
                  count));
  table["columns"] = VerdictRow::columns();
  table["rows"] = ordered_json::array();
  for (const VerdictRow& row : rows) table["rows"].push_back(row.row());
}

// --- Growth --------------------------------------------------------------------------------------------------------

void add_growth(ordered_json& part, bool quick) {
  const int count = quick ? 50 : 200, turns = quick ? 5 : 21;
  struct Curve {
    std::vector<double> n, us;
  };
  const std::vector<Method> methods = solvers();
  std::vector<Curve> curves(methods.size());
  for (Index n = 2; n <= kMaxGraspContacts; ++n) {
    Case c;
    for (std::uint64_t seed = 0; std::ssize(c.grasps) < count; ++seed) {
      Random numbers(seed);
      c.add(grasp_families::box_or_sphere(numbers, n));
    }
    const std::vector<Measured> points = measure(c, methods, turns);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      if (!(points[m].of_own_problem.error <= kProved)) continue;
      curves[m].n.push_back(static_cast<double>(n));
      curves[m].us.push_back(points[m].of_own_problem.us);
    }
  }
  const double before = heap_bytes();
  const GraspWorkspace work;
  const double lemke_bytes = sizeof(GraspWorkspace) + heap_bytes() - before;
  auto& figure = add_figure(
      part, "curves", "growth_grasp", "Grasp forces: time over the number of fingers",
      fmt::format(
          "Random boxes and balls, half of them with forces on the cones, held by 2 to 8 contacts, one a finger; two "
          "contacts, which cannot give every wrench, take a way of their own. A method has a point where all its "
          "answers are right to 1e-6. Ours work on up to 4 and up to 8 contacts at once, whatever the number. Memory "
          "does not grow: the active set and the exact cone need {} bytes of stack up to 4 contacts and {} up to 8, "
          "Lemke's method {:.0f} bytes taken once.",
          sizeof(ReducedGrasp<4>) + sizeof(ActiveSet<12>), sizeof(ReducedGrasp<8>) + sizeof(ActiveSet<24>),
          lemke_bytes),
      fmt::format("Medians of {} rounds of {} problems, methods in turns. Exponents: of the upper half of the sizes, "
                  "of all of fewer than six.",
                  turns, count));
  figure["x"] = {{"label", "contacts"}, {"log", true}};
  figure["y"] = {{"label", "time of a solve [µs]"}, {"log", true}};
  auto& panel = figure["panels"].emplace_back(ordered_json{{"name", "2 to 8 contacts"}});
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (curves[m].n.size() < 3) continue;
    panel["curves"].push_back(curve(methods[m].name, curves[m].n, curves[m].us, methods[m].peer));
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(
      argc, argv, "grasp_force", "Grasp forces",
      "Which forces the fingers should exert, eq. (15): once a control period, one contact a finger. The active set "
      "and the exact cone are ours; Lemke's method on the LCP is the published one. Other projects (siconos, bullet, "
      "ode) are given the finished LCP: forming it, which our times contain, is not in theirs, so that where there is "
      "nothing to decide one of them may be the fastest. A method without a point where others have one had no answer "
      "to a problem. Panels: the problems that the controller met in four scenes, at instants evenly spread over the "
      "motion (three fingers, friction 0.55: the least forces lie within the cones, and there is nothing to decide); "
      "the same with 1.2 times the friction below which the task cannot be done, where the cones decide; and random "
      "hands on boxes and balls whose least forces leave the cones.",
      {thenar::add_work_precision, thenar::add_verdicts, thenar::add_growth});
}
