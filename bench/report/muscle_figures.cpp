// Muscle forces: error against time, verdicts, growth.

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
#include "bench/scene_problems.h"
#include "solvers/muscle_forces.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kProved = 1e-6;  // Error below which an answer counts as right.

/// Problems to be solved by every method, with their proved optima without limits.
struct Case {
  std::string name;
  VectorXd f_max;
  std::vector<MuscleProblem> problems;
  std::vector<VectorXd> optima;

  /// Takes a problem that has an answer with limits, and so without.
  void add(const MuscleProblem& problem) {
    VectorXd f(problem.H.cols());
    if (solve_muscle_forces(problem.H, problem.tau_Nm, f_max, f).status != MuscleStatus::kOptimal) return;
    if (solve_muscle_forces(problem.H, problem.tau_Nm, f).status != MuscleStatus::kOptimal) return;
    problems.push_back(problem);
    optima.push_back(f);
  }
};

/// A hand of so many fingers: one thumb of 4 joints x 8 muscles, fingers of 4 x 7, and an extensor common to these.
/// Torques are those that muscles pulling at random give.
MuscleProblem repeated_hand(Index fingers, Random& random) {
  const MatrixXd known = muscle_families::moment_arms(random);
  constexpr Index kThumb = 8, kOwn = 7, kCommon = 15;  // Columns of the known hand: its common extensor is the 16th.
  const Index muscles = kThumb + kOwn * (fingers - 1) + 1;
  MuscleProblem problem{MatrixXd::Zero(4 * fingers, muscles), VectorXd::Zero(4 * fingers)};
  problem.H.topLeftCorner<4, kThumb>() = known.topLeftCorner<4, kThumb>();
  for (Index k = 1; k < fingers; ++k) {
    problem.H.block<4, kOwn>(4 * k, kThumb + kOwn * (k - 1)) = known.block<4, kOwn>(4, kThumb);
    problem.H.block<4, 1>(4 * k, muscles - 1) = known.block<4, 1>(4, kCommon);
  }
  for (Index j = 0; j < muscles; ++j) problem.tau_Nm += random.uniform(0.0, 30.0) * problem.H.col(j);
  return problem;
}

std::vector<Case> make_cases(bool quick) {
  const int count = quick ? 20 : 50;
  std::vector<Case> cases;
  for (const char* scene : {"box_grasp", "box_turn", "capsule", "mug"}) {
    const SceneProblems recorded = scene_problems(scene, {}, {0.4, 1.2, count});
    Case c{scene, recorded.f_max_N, {}, {}};
    for (const MuscleFile& file : recorded.muscles) c.add({file.H, file.tau});
    cases.push_back(c);
  }
  for (const MuscleFamily& family : kMuscleFamilies) {
    if (family.name != "muscles_held" && family.name != "muscles_few") continue;
    Case c{family.name == "muscles_held" ? "random, all muscles pull" : "random, few muscles pull",
           VectorXd::Constant(23, 100.0),
           {},
           {}};
    for (std::uint64_t seed = 0; std::ssize(c.problems) < count; ++seed) c.add(family.problem(seed));
    cases.push_back(c);
  }
  return cases;
}

// --- Methods -------------------------------------------------------------------------------------------------------

/// How far an answer is from the optimum of its own problem; 1 without an answer.
struct Prepared {
  std::function<void()> solve;
  std::function<double()> error;
};

struct Method {
  std::string name;
  bool is_default, peer, published;
  std::function<Prepared(const MuscleProblem&, const VectorXd& optimum)> prepare;
};

using Solve = std::function<MuscleReport(const MuscleProblem&, VectorXd&)>;

Method ours(const std::string& name, const VectorXd& f_max, const Solve& solve) {
  return {name, name == "active set", false, name == "Lemke", [=](const MuscleProblem& p, const VectorXd&) {
            auto f = std::make_shared<VectorXd>(p.H.cols());
            auto report = std::make_shared<MuscleReport>();
            return Prepared{[=, &p] { *report = solve(p, *f); },
                            [=, &p] {
                              if (report->status != MuscleStatus::kOptimal) return 1.0;
                              return muscle_kkt_error(p.H, p.tau_Nm, f_max, report->multiplier, *f);
                            }};
          }};
}

/// The LCP of eq. (23): 0 <= f = pi z + H^+ tau _|_ z >= 0.
struct MuscleLcp {
  MatrixXd M;
  VectorXd q;

  explicit MuscleLcp(const MuscleProblem& p) {
    const Eigen::CompleteOrthogonalDecomposition<MatrixXd> H(p.H);
    M = MatrixXd::Identity(p.H.cols(), p.H.cols()) - H.pseudoInverse() * p.H;
    q = H.solve(p.tau_Nm);
  }
};

Method peer_method(const LcpMethod& peer) {
  return {peer.name, false, true, false, [peer](const MuscleProblem& p, const VectorXd& optimum) {
            const auto lcp = std::make_shared<MuscleLcp>(p);
            auto z = std::make_shared<VectorXd>(VectorXd::Zero(lcp->q.size()));
            auto solved = std::make_shared<bool>(false);
            const LcpSolver solve = peer.prepare(lcp->M, lcp->q);
            return Prepared{[=] {
                              z->setZero();
                              *solved = solve(*z);
                            },
                            [=] {
                              const VectorXd f = lcp->M * *z + lcp->q;
                              if (!*solved || !f.allFinite()) return 1.0;
                              return std::min(1.0, (f - optimum).norm() / optimum.norm());
                            }};
          }};
}

std::vector<Method> methods_for(const VectorXd& f_max, Index joints, Index muscles) {
  const VectorXd none;
  const Solve free = [](const MuscleProblem& p, VectorXd& f) { return solve_muscle_forces(p.H, p.tau_Nm, f); };
  const Solve limited = [=](const MuscleProblem& p, VectorXd& f) {
    return solve_muscle_forces(p.H, p.tau_Nm, f_max, f);
  };
  const Solve lemke = [work = std::make_shared<MuscleWorkspace>(joints, muscles)](const MuscleProblem& p, VectorXd& f) {
    return solve_muscle_forces_by_lemke(p.H, p.tau_Nm, *work, f);
  };
  std::vector<Method> methods{ours("active set", none, free), ours("Lemke", none, lemke)};
  if (f_max.size() > 0) methods.push_back(ours("active set, with limits", f_max, limited));
  for (const LcpMethod& peer : lcp_peers()) methods.push_back(peer_method(peer));
  return methods;
}

std::vector<WorkPoint> measure(const Case& c, int turns) {
  const std::vector<Method> methods = methods_for(c.f_max, c.problems.front().H.rows(), c.problems.front().H.cols());
  std::vector<std::vector<Prepared>> prepared(methods.size());
  std::vector<std::function<void()>> rounds;
  std::vector<WorkPoint> points;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    double worst = 0.0;
    for (std::size_t i = 0; i < c.problems.size(); ++i) {
      prepared[m].push_back(methods[m].prepare(c.problems[i], c.optima[i]));
      prepared[m].back().solve();
      worst = std::max(worst, prepared[m].back().error());
    }
    points.push_back({.method = methods[m].name,
                      .setting = "",
                      .error = worst,
                      .is_default = methods[m].is_default,
                      .peer = methods[m].peer,
                      .published = methods[m].published});
    rounds.emplace_back([&problems = prepared[m]] {
      for (const Prepared& problem : problems) problem.solve();
    });
  }
  const std::vector<double> us = times_in_turns(rounds, turns);
  for (std::size_t m = 0; m < us.size(); ++m) points[m].us = us[m] / static_cast<double>(c.problems.size());
  return points;
}

// --- Figures -------------------------------------------------------------------------------------------------------

void add_work_precision(ordered_json& part, bool quick) {
  const int turns = quick ? 31 : 101;
  const std::string runs = "Time of a call: a round of all the panel's problems, over their number; medians of " +
                           std::to_string(turns) +
                           " rounds, in which the methods took turns. Errors: the worst of the panel's problems.";
  auto& figure = add_figure(
      part, "work_precision", "muscle_own", "Muscle forces: error against time",
      "The least forces of 23 muscles that give the 12 torques which the controller asks for, eq. (23): how exactly "
      "each "
      "method finds them, against its time; down and to the left is better. The error is that of the optimality "
      "conditions "
      "as a share of the largest force, and of other projects, which solve the published LCP and give no proof, the "
      "distance to the proved optimum; 1: at least one problem had no answer. The LCP is given to them finished: "
      "forming it, "
      "which Lemke's time here contains, is not in theirs. The default, an active set on the blocks of joints that "
      "share "
      "muscles, is exact to rounding and the fastest. Lemke's method is the published one. Recorded "
      "problems "
      "are those of the controller at instants evenly spread over the motion of four scenes; random ones have moment "
      "arms of "
      "the hand's signs, and torques that muscles pulling at random give.",
      runs);
  figure.update(
      {{"error", "worst error of the forces"}, {"time", "time of a solve [us]"}, {"choice", "muscle-force solver"}});
  ordered_json rows = ordered_json::array();
  for (const Case& c : make_cases(quick)) {
    std::vector<WorkPoint> points = measure(c, turns);
    const WorkPoint limited = points[2];  // Another problem: it is no candidate.
    points.erase(points.begin() + 2);
    figure["cases"].push_back({{"name", c.name}, {"points", points}});
    rows.push_back({c.name, c.problems.size(), points[0].us, points[0].error, over_front(points), points[1].us,
                    points[1].error, limited.us, limited.error});
  }
  auto& table =
      add_figure(part, "table", "muscle_default", "Muscle forces: the default",
                 "The active set against the fastest of ours that errs no more in the same problem (1: it is the "
                 "fastest; up to 1.1 passes for on the front), beside the published Lemke's method; and the active set "
                 "with limits on the forces (the "
                 "hand's, 100 N for the random ones), another problem, which the LCP cannot state.",
                 runs);
  table["columns"] = {"problems",   "number",    "default [us]",     "error",    "time over front",
                      "Lemke [us]", "its error", "with limits [us]", "its error"};
  table["rows"] = rows;
}

void add_verdicts(ordered_json& part, bool quick) {
  const int count = quick ? 100 : 1000;
  constexpr std::uint64_t kFresh = 1'000'000;  // Seeds that no solver's constants were chosen on.
  const VectorXd none;
  auto& table = add_figure(
      part, "table", "muscle_verdicts", "Muscle forces: verdicts",
      "Fresh random problems: torques at random (`any`), of pulling muscles (`held`), of a few (`few`: at the limit of "
      "what "
      "all can give), with joints that depend on others (`dependent`), and of any size (`scaled`). An answer is wrong "
      "if its "
      "forces are off the optimality conditions by more than 1e-6, or if the joint velocities that should prove that "
      "there are "
      "none do not; with other projects, if solved or not is said against our proof, or the LCP is solved to worse "
      "than 1e-6. "
      "They are not asked where dependent joints contradict each other, for there is no LCP.",
      std::to_string(count) + " problems a family, each solved once; median and 99 % of the times, clock included.");
  table["columns"] = {"family", "solver", "optimal", "infeasible", "wrong", "no answer", "median [us]", "p99 [us]"};
  MuscleWorkspace work(12, 23);
  for (const MuscleFamily& family : kMuscleFamilies) {
    std::vector<MuscleProblem> problems;
    for (int i = 0; i < count; ++i) problems.push_back(family.problem(kFresh + static_cast<std::uint64_t>(i)));
    std::vector<std::optional<bool>> feasible(problems.size());
    const auto tell = [&](const char* name, bool lemke) {
      int optimal = 0, infeasible = 0, wrong = 0, unanswered = 0;
      std::vector<double> us;
      for (std::size_t i = 0; i < problems.size(); ++i) {
        const MuscleProblem& p = problems[i];
        VectorXd f(p.H.cols());
        MuscleReport report;
        us.push_back(time_us([&] {
          report = lemke ? solve_muscle_forces_by_lemke(p.H, p.tau_Nm, work, f) : solve_muscle_forces(p.H, p.tau_Nm, f);
        }));
        const bool found = report.status == MuscleStatus::kOptimal;
        if (report.status == MuscleStatus::kBudgetSpent) {
          ++unanswered;
          continue;
        }
        ++(found ? optimal : infeasible);
        const bool proved = found ? muscle_kkt_error(p.H, p.tau_Nm, none, report.multiplier, f) <= kProved
                                  : muscle_infeasibility_gap(p.H, p.tau_Nm, none, report.multiplier) < 1.0;
        wrong += proved ? 0 : 1;
        if (proved) feasible[i] = found;
      }
      const Percentiles times = percentiles(us);
      table["rows"].push_back(
          {std::string(family.name), name, optimal, infeasible, wrong, unanswered, times.p50, times.p99});
    };
    tell("active set", false);
    tell("Lemke", true);
    for (const LcpMethod& peer : lcp_peers()) {
      int optimal = 0, infeasible = 0, wrong = 0;
      std::vector<double> us;
      for (std::size_t i = 0; i < problems.size(); ++i) {
        const MuscleLcp lcp(problems[i]);
        const double off_Nm = (problems[i].H * lcp.q - problems[i].tau_Nm).norm();
        if (!feasible[i] || off_Nm > 1e-9 * problems[i].tau_Nm.norm()) continue;
        const LcpSolver solve = peer.prepare(lcp.M, lcp.q);
        VectorXd z = VectorXd::Zero(lcp.q.size());
        bool claimed = false;
        us.push_back(time_us([&] { claimed = solve(z); }));
        ++(claimed ? optimal : infeasible);
        const double error = (lcp.M * z + lcp.q).cwiseMin(z).cwiseAbs().maxCoeff();
        wrong += claimed == *feasible[i] && (!claimed || error <= kProved * lcp.q.cwiseAbs().maxCoeff()) ? 0 : 1;
      }
      const Percentiles times = percentiles(us);
      table["rows"].push_back(
          {std::string(family.name), peer.name, optimal, infeasible, wrong, 0, times.p50, times.p99});
    }
  }
}

void add_growth(ordered_json& part, bool quick) {
  const int count = quick ? 20 : 50, turns = quick ? 11 : 51;
  struct Curve {
    std::string name;
    bool peer;
    std::vector<double> fingers, us;
  };
  std::vector<Curve> curves;
  std::vector<double> bytes;
  for (Index fingers = 2; fingers <= 5; ++fingers) {
    Case c{"", VectorXd::Constant(8 + 7 * (fingers - 1) + 1, 100.0), {}, {}};
    for (std::uint64_t seed = 0; std::ssize(c.problems) < count; ++seed) {
      Random random(seed);
      c.add(repeated_hand(fingers, random));
    }
    const double before = heap_bytes();
    const MuscleWorkspace work(4 * fingers, c.f_max.size());
    bytes.push_back(heap_bytes() - before + sizeof work);
    const std::vector<WorkPoint> points = measure(c, turns);
    if (curves.empty()) {
      for (const WorkPoint& point : points) curves.push_back({point.method, point.peer, {}, {}});
    }
    for (std::size_t m = 0; m < points.size(); ++m) {
      if (points[m].error > kProved) continue;
      curves[m].fingers.push_back(static_cast<double>(fingers));
      curves[m].us.push_back(points[m].us);
    }
  }
  auto& figure = add_figure(
      part, "curves", "growth_muscle", "Muscle forces: time over the number of fingers",
      "Hands of a thumb (4 joints, 8 muscles) and one to four fingers (4 joints, 7 muscles each, and one extensor "
      "common to "
      "them), moment arms of the hand's signs at random, torques that pulling muscles give. A method has a point where "
      "all its "
      "answers are right to 1e-6. The active set does not form anything of the size of the muscles squared, and works "
      "on the "
      "thumb by itself. It takes its memory from the stack, at most 32 joints and 64 muscles, whatever the hand; that "
      "of "
      "Lemke's method, taken once, grows from " +
          std::to_string(static_cast<long>(bytes.front())) + " to " + std::to_string(static_cast<long>(bytes.back())) +
          " bytes, with the exponent " +
          [&] {
            std::string text = std::to_string(exponent({2, 3, 4, 5}, bytes));
            return text.substr(0, text.find('.') + 2);
          }() +
          " in fingers. Exponents are those of time in fingers.",
      "Medians of " + std::to_string(turns) + " rounds of " + std::to_string(count) + " problems, methods in turns.");
  figure["x"] = {{"label", "fingers"}, {"log", true}};
  figure["y"] = {{"label", "time of a solve [us]"}, {"log", true}};
  auto& panel = figure["panels"].emplace_back(ordered_json{{"name", "2 to 5 fingers"}});
  for (const Curve& curve : curves) {
    if (curve.us.size() < 3) continue;
    panel["curves"].push_back({{"name", curve.name},
                               {"x", curve.fingers},
                               {"y", curve.us},
                               {"exponent", exponent(curve.fingers, curve.us)},
                               {"peer", curve.peer}});
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  const PartArguments arguments = part_arguments(argc, argv);
  auto part = make_part(
      "muscle_forces", "Muscle forces",
      "Which forces 23 muscles should pull with to give the torques of 12 joints: once a control period.", arguments);
  add_work_precision(part, arguments.quick);
  add_verdicts(part, arguments.quick);
  add_growth(part, arguments.quick);
  write_part(part, arguments);
}
