// Grasp forces: error against time, verdicts, growth.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "bench/grasp_families.h"
#include "bench/peers.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "bench/report/polygon_cone.h"
#include "bench/scene_problems.h"
#include "solvers/grasp_deficit.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

/// Problems to be solved by every method, with the proved optima of both cones.
struct Case {
  std::string name;
  std::vector<Grasp> grasps;
  std::vector<VectorXd> pyramid, exact;

  /// Takes a problem that both cones can solve.
  void add(const Grasp& grasp) {
    VectorXd f_pyramid(3 * grasp.n()), f_exact(3 * grasp.n());
    if (solve_grasp_forces(grasp.problem(FrictionCone::kPyramid), f_pyramid).status != GraspStatus::kOptimal ||
        solve_grasp_forces(grasp.problem(FrictionCone::kExact), f_exact).status != GraspStatus::kOptimal) {
      return;
    }
    grasps.push_back(grasp);
    pyramid.push_back(f_pyramid);
    exact.push_back(f_exact);
  }
};

Grasp grasp_of(const GraspFile& file) {
  Grasp grasp;
  grasp.contacts = file.contacts;
  grasp.wrench = file.wrench;
  grasp.friction = file.friction;
  grasp.internal_force_N = file.internal_force_N;
  return grasp;
}

/// How a method does on a problem: its forces, and for a method that proves its answer how far it is from the proof.
struct Answer {
  bool solved = false;
  VectorXd f;
  double kkt = std::numeric_limits<double>::quiet_NaN();
};

struct Method {
  std::string name, setting;
  bool is_default, peer, published, exact;
  /// Prepares a problem; the call solves it. What it answered is asked for afterwards.
  struct Prepared {
    std::function<void()> solve;
    std::function<Answer()> answer;
  };
  std::function<Prepared(const Grasp&)> prepare;
};

using Solve = std::function<GraspReport(const GraspProblem&, VectorXd&)>;

Method ours(const std::string& name, const std::string& setting, FrictionCone cone, Solve solve) {
  const bool lemke = name == "Lemke";
  return {name,
          setting,
          !lemke && cone == FrictionCone::kPyramid,
          false,
          lemke,
          cone == FrictionCone::kExact,
          [cone, solve](const Grasp& grasp) {
            const GraspProblem problem = grasp.problem(cone);
            auto f = std::make_shared<VectorXd>(3 * grasp.n());
            auto report = std::make_shared<GraspReport>();
            return Method::Prepared{[=] { *report = solve(problem, *f); },
                                    [=] {
                                      return Answer{report->status == GraspStatus::kOptimal, *f,
                                                    grasp_kkt_error(problem, report->multiplier, *f)};
                                    }};
          }};
}

Method polygon(int sides) {
  return {"polygon cone", std::to_string(sides) + " sides", false, false, false, true, [sides](const Grasp& grasp) {
            const GraspProblem problem = grasp.problem(FrictionCone::kExact);
            auto f = std::make_shared<VectorXd>(3 * grasp.n());
            auto solved = std::make_shared<bool>();
            return Method::Prepared{[=] { *solved = solve_polygon_cone(problem, sides, *f); },
                                    [=] {
                                      return Answer{*solved, *f};
                                    }};
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
    pulled.segment<3>(3 * i) = grasp.contacts[i].frame * f_C;
  }
  const VectorXd missing = grasp.wrench - G * pulled;
  return pulled + G.completeOrthogonalDecomposition().solve(missing);
}

/// The problem's LCP, as our Lemke forms it; empty if it is seen to be out of reach before there is one.
struct GraspLcp {
  MatrixXd M;
  VectorXd q;

  explicit GraspLcp(const Grasp& grasp) {
    GraspWorkspace work;
    VectorXd f(3 * grasp.n());
    (void)solve_grasp_forces_by_lemke(grasp.problem(FrictionCone::kPyramid), work, f);
    q = work.q;
    M = work.M.topRows(q.size());
  }
};

Method peer_method(const LcpMethod& peer) {
  return {peer.name, "", false, true, false, false, [peer](const Grasp& grasp) {
            const GraspLcp lcp(grasp);
            auto z = std::make_shared<VectorXd>(VectorXd::Zero(5 * grasp.n()));
            auto solved = std::make_shared<bool>(false);
            if (lcp.q.size() == 0) return Method::Prepared{[] {}, [=] { return Answer{false, {}}; }};
            const LcpSolver solve = peer.prepare(lcp.M, lcp.q);
            return Method::Prepared{[=] {
                                      z->setZero();
                                      *solved = solve(*z);
                                    },
                                    [=] {
                                      return Answer{*solved, forces_of(grasp, *z)};
                                    }};
          }};
}

/// Of the forces' size; 1, all of it, if there is no answer.
double force_error(const Answer& answer, const VectorXd& f) {
  if (!answer.solved || !answer.f.allFinite()) return 1.0;
  return std::min(1.0, (answer.f - f).norm() / f.norm());
}

std::vector<Method> solvers() {
  const Solve active_set = [](const GraspProblem& p, VectorXd& f) { return solve_grasp_forces(p, f); };
  const Solve lemke = [work = std::make_shared<GraspWorkspace>()](const GraspProblem& p, VectorXd& f) {
    return solve_grasp_forces_by_lemke(p, *work, f);
  };
  std::vector<Method> methods{ours("active set", "pyramid", FrictionCone::kPyramid, active_set),
                              ours("Lemke", "pyramid", FrictionCone::kPyramid, lemke),
                              ours("exact cone", "", FrictionCone::kExact, active_set)};
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
      Grasp grasp = grasp_of(file);
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
      const Answer answer = prepared[m][i].answer();
      const double off = force_error(answer, method.exact ? c.exact[i] : c.pyramid[i]);
      own = std::max(own, std::isnan(answer.kkt) || !answer.solved ? off : answer.kkt);
      // The exact cone's optimum is what it is judged by itself: for it the proof counts.
      coulomb =
          std::max(coulomb, std::isnan(answer.kkt) || !method.exact ? force_error(answer, c.exact[i]) : answer.kkt);
    }
    WorkPoint point{.method = method.name,
                    .setting = method.setting,
                    .is_default = method.is_default,
                    .peer = method.peer,
                    .published = method.published};
    points.push_back({point, point});
    points.back().of_own_problem.error = own;
    points.back().of_coulomb.error = coulomb;
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

void add_work_precision(ordered_json& part, const std::vector<Case>& cases, bool quick) {
  const int turns = quick ? 31 : 101;
  ordered_json own = ordered_json::array(), coulomb = ordered_json::array(), rows = ordered_json::array();
  for (const Case& c : cases) {
    std::vector<Method> methods = solvers();
    const std::size_t count = methods.size();
    for (const int sides : {4, 8, 16, 32}) methods.push_back(polygon(sides));
    std::vector<WorkPoint> own_points, coulomb_points;
    const std::vector<Measured> measured = measure(c, methods, turns);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      if (m < count) own_points.push_back(measured[m].of_own_problem);
      coulomb_points.push_back(measured[m].of_coulomb);
    }
    const auto chosen = std::find_if(own_points.begin(), own_points.end(), [](const auto& p) { return p.is_default; });
    const auto exact = std::find_if(coulomb_points.begin(), coulomb_points.end(),
                                    [](const auto& p) { return p.method == "exact cone"; });
    const auto pyramid =
        std::find_if(coulomb_points.begin(), coulomb_points.end(), [](const auto& p) { return p.is_default; });
    rows.push_back({c.name, c.grasps.size(), chosen->us, chosen->error, over_front(own_points), pyramid->error,
                    exact->us, exact->error});
    own.push_back({{"name", c.name}, {"points", own_points}});
    coulomb.push_back({{"name", c.name}, {"points", coulomb_points}});
  }
  const std::string runs = "Time of a call: a round of all the panel's problems, over their number; medians of " +
                           std::to_string(turns) +
                           " rounds, in which the methods took turns. Errors: the worst of the panel's problems.";
  const std::string problems =
      " The problems are those that the controller met in four scenes, at instants evenly spread over the motion "
      "(three "
      "fingers, friction 0.55: the least forces lie within the cones, so that there is nothing to decide); the same "
      "with 1.2 "
      "times the friction below which the task cannot be done, where the cones decide; and random hands on boxes and "
      "balls whose least forces leave the cones.";
  auto& first = add_figure(
      part, "work_precision", "grasp_own", "Grasp forces: error in the method's own problem",
      "How exactly each method solves the problem it was given, against its time; down and to the left is better. "
      "Error 0 "
      "would be the optimum of eq. (15) with the method's own cone, by the optimality conditions, as a share of the "
      "forces; "
      "of other projects' LCP solvers, which give no proof, the distance to the proved optimum. 1 means that a problem "
      "had no answer. They are "
      "given the finished LCP: forming it, which our times contain, is not in theirs. The default, the active set on "
      "pyramids, is exact to rounding and the fastest; Lemke's method on the LCP is the published one." +
          problems,
      runs);
  first.update({{"error", "worst error of the forces, in the method's own problem"},
                {"time", "time of a solve [us]"},
                {"choice", "grasp-force solver"},
                {"cases", own}});
  auto& second = add_figure(
      part, "work_precision", "grasp_coulomb", "Grasp forces: error against Coulomb's cone",
      "The same solves, judged by what they are for: forces in Coulomb's round cone. The error is the distance to the "
      "optimum in that cone as a share of the forces, and of the exact cone's own answer its optimality conditions. A "
      "pyramid around the cone lets forces out of it at its edges, however exactly it is solved; polygons of more "
      "sides "
      "approach the cone, but at the exact cone's time they still err by percents. Where friction is ample, as the "
      "scenes have it, all cones give the same forces, and the pyramid, the default and the published one, costs "
      "least. "
      "Where friction is scarce, `control.grasp.cone: exact` takes all of the error away for two microseconds." +
          problems,
      runs);
  second.update({{"error", "worst distance of the forces from the optimum in Coulomb's cone"},
                 {"time", "time of a solve [us]"},
                 {"choice", "friction cone and solver"},
                 {"cases", coulomb}});
  auto& table = add_figure(part, "table", "grasp_default", "Grasp forces: the default",
                           "The active set on pyramids against the fastest of ours that errs no more in its own "
                           "problem (1: it is the fastest; "
                           "up to 1.1 passes for on the front), what the pyramid errs against Coulomb's cone, and what "
                           "the exact cone costs.",
                           runs);
  table["columns"] = {"problems",        "number",          "default [us]",
                      "error",           "time over front", "error against Coulomb's cone",
                      "exact cone [us]", "its error"};
  table["rows"] = rows;
}

// --- Verdicts ------------------------------------------------------------------------------------------------------

/// Seeds that no solver's constants were chosen on.
constexpr std::uint64_t kFresh = 1'000'000;

struct Verdicts {
  int wrong = 0, none = 0;
  double worst = 0.0;
  std::vector<double> us;

  void add(bool answered, bool right, double error, double time_us) {
    us.push_back(time_us);
    if (!answered) return void(++none);
    wrong += right ? 0 : 1;
    if (right) worst = std::max(worst, error);
  }
};

// A proof is one that is checked here: forces by their optimality conditions, the lack of them by a twist.
constexpr double kProved = 1e-6;

/// Judges one of our solvers; true or false if it proved that there are forces or none.
std::optional<bool> judge(const GraspProblem& problem, const Solve& solve, Verdicts& verdicts) {
  VectorXd f(3 * std::ssize(problem.contacts));
  GraspReport report;
  const double us = time_us([&] { report = solve(problem, f); });
  const bool found = report.status == GraspStatus::kOptimal;
  const double error =
      found ? grasp_kkt_error(problem, report.multiplier, f) : infeasibility_gap(problem, report.multiplier);
  verdicts.add(report.status != GraspStatus::kBudgetSpent, error <= kProved, error, us);
  if (report.status == GraspStatus::kBudgetSpent || error > kProved) return {};
  return found;
}

void judge(const LcpMethod& peer, const GraspLcp& lcp, bool feasible, Verdicts& verdicts) {
  const LcpSolver solve = peer.prepare(lcp.M, lcp.q);
  VectorXd z = VectorXd::Zero(lcp.q.size());
  bool claimed = false;
  const double us = time_us([&] { claimed = solve(z); });
  double error = 0.0;
  if (claimed) {
    const double scale = std::max(1e-300, lcp.q.cwiseAbs().maxCoeff());
    error = z.allFinite() ? (lcp.M * z + lcp.q).cwiseMin(z).cwiseAbs().maxCoeff() / scale : 1.0;
  }
  verdicts.add(true, claimed == feasible && error <= kProved, error, us);
}

void add_verdicts(ordered_json& part, bool quick) {
  const int count = quick ? 100 : 1000;
  struct Ours {
    const char* name;
    FrictionCone cone;
    Solve solve;
  };
  const Solve direct = [](const GraspProblem& p, VectorXd& f) { return solve_grasp_forces(p, f); };
  const Solve lemke = [work = std::make_shared<GraspWorkspace>()](const GraspProblem& p, VectorXd& f) {
    return solve_grasp_forces_by_lemke(p, *work, f);
  };
  const std::array<Ours, 3> ours_all{{{"active set", FrictionCone::kPyramid, direct},
                                      {"Lemke", FrictionCone::kPyramid, lemke},
                                      {"exact cone", FrictionCone::kExact, direct}}};
  const std::vector<LcpMethod> peers = lcp_peers();
  std::vector<std::string> names;
  for (const Ours& method : ours_all) names.emplace_back(method.name);
  for (const LcpMethod& peer : peers) names.emplace_back(peer.name);

  ordered_json rows = ordered_json::array();
  std::vector<Verdicts> total(names.size());
  for (const GraspFamily& family : kGraspFamilies) {
    std::vector<Verdicts> here(names.size());
    int feasible = 0;
    for (int i = 0; i < count; ++i) {
      const Grasp grasp = family.problem(kFresh + static_cast<std::uint64_t>(i));
      std::optional<bool> known;  // Of the pyramid.
      for (std::size_t m = 0; m < ours_all.size(); ++m) {
        const auto proved = judge(grasp.problem(ours_all[m].cone), ours_all[m].solve, here[m]);
        if (ours_all[m].cone == FrictionCone::kPyramid && !known) known = proved;
      }
      feasible += known.value_or(false) ? 1 : 0;
      const GraspLcp lcp(grasp);
      if (lcp.q.size() == 0 || !known) continue;
      for (std::size_t p = 0; p < peers.size(); ++p) judge(peers[p], lcp, *known, here[ours_all.size() + p]);
    }
    ordered_json row{std::string(family.name), feasible};
    for (std::size_t m = 0; m < names.size(); ++m) {
      row.push_back(std::to_string(here[m].wrong) + " + " + std::to_string(here[m].none));
      total[m].wrong += here[m].wrong;
      total[m].none += here[m].none;
      total[m].worst = std::max(total[m].worst, here[m].worst);
      total[m].us.insert(total[m].us.end(), here[m].us.begin(), here[m].us.end());
    }
    rows.push_back(row);
  }
  const std::string runs = std::to_string(count) + " problems a family, each solved once.";
  auto& table = add_figure(
      part, "table", "grasp_verdicts", "Grasp forces: wrong answers, and none",
      "Fresh random problems, from those a hand meets (box, sphere, held, scattered) to those that break solvers (the "
      "rest; "
      "wrenches of `border` are within 1e-12 to 1e-2 of the limit of what the cones can give). How many have forces in "
      "the "
      "pyramids, and for each solver wrong answers + no answer. An answer is wrong that does not stand the check made "
      "here: "
      "of ours, forces off the optimality conditions or a twist that proves nothing, by more than 1e-6; of other "
      "projects, "
      "which say solved or not, a word against our proof, or an LCP solved to worse than 1e-6. They are asked only "
      "where "
      "there is an LCP and a proof. No answer of ours is said by status, and the controller keeps its last forces.",
      runs);
  table["columns"] = {"family", "feasible"};
  for (const std::string& name : names) table["columns"].push_back(name);
  table["rows"] = rows;
  auto& summary = add_figure(
      part, "table", "grasp_verdict_times", "Grasp forces: answers to all families together",
      "The same problems. The worst error is that of the right answers: of forces their optimality conditions, of a "
      "proof that there are none what it leaves open, of an LCP its complementarity, each as a share. Other "
      "projects' times are without forming the LCP.",
      runs + " Median and 99 % of the times of single calls, clock included.");
  summary["columns"] = {"solver", "problems", "wrong", "no answer", "worst error", "median [us]", "p99 [us]"};
  for (std::size_t m = 0; m < names.size(); ++m) {
    const Percentiles us = percentiles(total[m].us);
    summary["rows"].push_back(
        {names[m], total[m].us.size(), total[m].wrong, total[m].none, total[m].worst, us.p50, us.p99});
  }
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
      if (points[m].of_own_problem.error > 1e-6) continue;
      curves[m].n.push_back(static_cast<double>(n));
      curves[m].us.push_back(points[m].of_own_problem.us);
    }
  }
  const double before = heap_bytes();
  const GraspWorkspace work;
  const double lemke_bytes = sizeof(GraspWorkspace) + heap_bytes() - before;
  auto& figure = add_figure(
      part, "curves", "growth_grasp", "Grasp forces: time over the number of fingers",
      "Time of a solve of random boxes and balls, half of them with forces on the cones, held by 2 to 8 contacts, one "
      "a "
      "finger. Only where all answers are right to 1e-6 has a method a point. Steps of ours after 4 contacts are the "
      "registers': up to 4 and up to 8 contacts are worked on at once, whatever the number. The exponent is that of "
      "time in "
      "contacts over the whole range. Memory does not grow: the active set and the exact cone need " +
          std::to_string(sizeof(ReducedGrasp<4>) + sizeof(ActiveSet<12>)) + " bytes of stack up to 4 contacts and " +
          std::to_string(sizeof(ReducedGrasp<8>) + sizeof(ActiveSet<24>)) + " up to 8, Lemke's method " +
          std::to_string(static_cast<long>(lemke_bytes)) + " bytes taken once.",
      "Medians of " + std::to_string(turns) + " rounds of " + std::to_string(count) + " problems, methods in turns.");
  figure["x"] = {{"label", "contacts"}, {"log", true}};
  figure["y"] = {{"label", "time of a solve [us]"}, {"log", true}};
  auto& panel = figure["panels"].emplace_back(ordered_json{{"name", "2 to 8 contacts"}});
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (curves[m].n.size() < 3) continue;
    panel["curves"].push_back({{"name", methods[m].name},
                               {"x", curves[m].n},
                               {"y", curves[m].us},
                               {"exponent", exponent(curves[m].n, curves[m].us)},
                               {"peer", methods[m].peer}});
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  const PartArguments arguments = part_arguments(argc, argv);
  auto part =
      make_part("grasp_forces", "Grasp forces",
                "Which forces the fingers should exert: once a control period, one contact a finger.", arguments);
  add_work_precision(part, make_cases(arguments.quick), arguments.quick);
  add_verdicts(part, arguments.quick);
  add_growth(part, arguments.quick);
  write_part(part, arguments);
}
