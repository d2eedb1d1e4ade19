// SPDX-License-Identifier: Apache-2.0
// Muscle forces: error against time, verdicts, growth.

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
#include "bench/report/verdicts.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kProved = 1e-6;  // Error below which an answer counts as right.

/// A problem with its proved optimum, and how far the proof leaves it open, as a share of the forces: no error is told
/// more closely.
struct Solvable {
  MuscleData problem;
  VectorXd optimum;
  double open;

  /// The distance of forces from the optimum, as a share of it; no number where there are none.
  [[nodiscard]] double error_of(const std::optional<VectorXd>& f) const {
    if (!f || !f->allFinite()) return std::numeric_limits<double>::quiet_NaN();
    return std::max(open, (*f - optimum).norm() / optimum.norm());
  }
};

/// Problems to be solved by every method.
struct Case {
  std::string name;
  std::vector<Solvable> problems;

  /// Takes a problem that has an answer.
  void add(const MuscleData& problem) {
    VectorXd f(problem.H.cols());
    const MuscleReport report = solve_muscle_forces(problem, f);
    if (report.status == MuscleStatus::kOptimal) problems.push_back({problem, f, report.residual});
  }
};

/// A hand of so many fingers: one thumb of 4 joints x 8 muscles, fingers of 4 x 7, and an extensor common to these.
/// Torques are those that muscles pulling at random give.
MuscleData repeated_hand(Index fingers, Random& random) {
  const MatrixXd known = muscle_families::moment_arms(random);
  constexpr Index kThumb = 8, kOwn = 7, kCommon = 15;  // Columns of the known hand: its common extensor is the 16th.
  const Index muscles = kThumb + kOwn * (fingers - 1) + 1;
  MuscleData problem{MatrixXd::Zero(4 * fingers, muscles), VectorXd::Zero(4 * fingers)};
  problem.H.topLeftCorner<4, kThumb>() = known.topLeftCorner<4, kThumb>();
  for (Index k = 1; k < fingers; ++k) {
    problem.H.block<4, kOwn>(4 * k, kThumb + kOwn * (k - 1)) = known.block<4, kOwn>(4, kThumb);
    problem.H.block<4, 1>(4 * k, muscles - 1) = known.block<4, 1>(4, kCommon);
  }
  for (Index j = 0; j < muscles; ++j) problem.tau += random.uniform(0.0, 30.0) * problem.H.col(j);
  return problem;
}

std::vector<Case> make_cases(bool quick) {
  const int count = quick ? 20 : 50;
  std::vector<Case> cases;
  for (const char* scene : {"box_grasp", "box_turn", "capsule", "mug"}) {
    Case& c = cases.emplace_back(Case{scene, {}});
    for (const MuscleFile& file : scene_problems(scene, {}, {0.4, 1.2, count}).muscles) c.add(file);
  }
  for (const MuscleFamily& family : kMuscleFamilies) {
    if (family.name != "muscles_held" && family.name != "muscles_few") continue;
    Case& c = cases.emplace_back(
        Case{family.name == "muscles_held" ? "random, all muscles pull" : "random, few muscles pull", {}});
    for (std::uint64_t seed = 0; std::ssize(c.problems) < count; ++seed) c.add(family.problem(seed));
  }
  return cases;
}

// --- Methods -------------------------------------------------------------------------------------------------------

struct Prepared {
  std::function<void()> solve;
  std::function<std::optional<VectorXd>()> forces;  ///< None without an answer.
};

struct Method {
  std::string name;
  bool is_default, peer, published;
  std::function<Prepared(const MuscleProblem&)> prepare;
};

using Solver = std::function<MuscleReport(const MuscleProblem&, VectorXd&)>;

struct Ours {
  const char* name;
  bool is_default;
  Solver solve;
};

std::vector<Ours> our_solvers(Index joints, Index muscles) {
  return {{"active set", true, [](const MuscleProblem& p, VectorXd& f) { return solve_muscle_forces(p, f); }},
          {"Lemke", false,
           [work = std::make_shared<MuscleWorkspace>(joints, muscles)](const MuscleProblem& p, VectorXd& f) {
             return solve_muscle_forces_by_lemke(p, *work, f);
           }}};
}

Method method_of(const Ours& ours) {
  return {ours.name, ours.is_default, false, !ours.is_default, [solve = ours.solve](const MuscleProblem& p) {
            auto f = std::make_shared<VectorXd>(p.H.cols());
            auto report = std::make_shared<MuscleReport>();
            return Prepared{
                [=] { *report = solve(p, *f); },
                [=] { return report->status == MuscleStatus::kOptimal ? std::optional<VectorXd>(*f) : std::nullopt; }};
          }};
}

/// The LCP of eq. (23): 0 <= f = pi z + H^+ tau _|_ z >= 0.
LcpData lcp_of(const MuscleProblem& p) {
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> H(p.H);
  return {MatrixXd::Identity(p.H.cols(), p.H.cols()) - H.pseudoInverse() * p.H, H.solve(p.tau)};
}

Method peer_method(const LcpMethod& peer) {
  return {peer.name, false, true, false, [peer](const MuscleProblem& p) {
            const auto lcp = std::make_shared<LcpData>(lcp_of(p));
            auto z = std::make_shared<VectorXd>(lcp->q.size());
            auto solved = std::make_shared<bool>(false);
            return Prepared{[=, solve = peer.prepare(*lcp)] {
                              z->setZero();
                              *solved = solve(*z);
                            },
                            [=] { return *solved ? std::optional<VectorXd>(lcp->M * *z + lcp->q) : std::nullopt; }};
          }};
}

std::vector<WorkPoint> measure(const Case& c, int turns) {
  const MatrixXd& H = c.problems.front().problem.H;
  std::vector<Method> methods;
  for (const Ours& ours : our_solvers(H.rows(), H.cols())) methods.push_back(method_of(ours));
  for (const LcpMethod& peer : lcp_peers()) methods.push_back(peer_method(peer));
  std::vector<std::vector<Prepared>> prepared(methods.size());
  std::vector<std::function<void()>> rounds;
  std::vector<WorkPoint> points;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    double worst = 0.0;
    for (const Solvable& solvable : c.problems) {
      prepared[m].push_back(methods[m].prepare(solvable.problem));
      prepared[m].back().solve();
      worst = worse(worst, solvable.error_of(prepared[m].back().forces()));
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
  auto& figure = add_figure(
      part, "work_precision", "muscle_own", "Muscle forces: error against time",
      "Ours are exact to rounding (below 1e-12), so that time decides; the default is the active set on the blocks of "
      "joints that share muscles. The error is the distance of the forces from the proved optimum, as a share of "
      "them, and no less than what the proof leaves open; down and to the left is better. Lemke's method is the "
      "published one. A method without a point where others have one had no answer to a problem. Other projects "
      "(siconos, bullet, ode) are given the finished LCP: forming it, which Lemke's time here contains, is not in "
      "theirs. Panels: the controller's problems at instants evenly spread over the motion of four scenes; and random "
      "ones, moment arms of the hand's signs, torques of many or few muscles pulling at random.",
      fmt::format(
          "Time of a call: a round of all the panel's problems, over their number; medians of {} rounds, in which the "
          "methods took turns. Errors: the worst of the panel's problems.",
          turns));
  figure.update(
      {{"error", "worst error of the forces"}, {"time", "time of a solve [µs]"}, {"choice", "muscle-force solver"}});
  for (const Case& c : make_cases(quick)) figure["cases"].push_back({{"name", c.name}, {"points", measure(c, turns)}});
}

/// Judges one of our solvers; true or false if it proved that there are forces or none.
std::optional<bool> judge(const MuscleProblem& p, const Solver& solve, Verdicts& verdicts) {
  VectorXd f(p.H.cols());
  MuscleReport report;
  const double us = warm_time_us([&] { report = solve(p, f); });
  if (report.status == MuscleStatus::kBudgetSpent) {
    verdicts.add(Claim::kNone, false, 0.0, us);
    return {};
  }
  const bool found = report.status == MuscleStatus::kOptimal;
  // Of a proof that there are none what it leaves open is a share that must be below 1.
  const double error = found ? muscle_kkt_error(p, report.multiplier, f) : 0.0;
  const bool right = found ? error <= kProved : muscle_infeasibility_gap(p, report.multiplier) < 1.0;
  verdicts.add(found ? Claim::kSolved : Claim::kNoSolution, right, error, us);
  return right ? std::optional<bool>(found) : std::nullopt;
}

void add_verdicts(ordered_json& part, bool quick) {
  const int count = quick ? 100 : 1000;
  const std::vector<Ours> ours = our_solvers(12, 23);
  const std::vector<LcpMethod> peers = lcp_peers();
  std::vector<VerdictRow> rows;
  for (const Ours& method : ours) rows.emplace_back(method.name);
  for (const LcpMethod& peer : peers) rows.emplace_back(peer.name);
  for (const MuscleFamily& family : kMuscleFamilies) {
    std::vector<Verdicts> here(rows.size());
    for (int i = 0; i < count; ++i) {
      const MuscleData p = family.problem(kFresh + static_cast<std::uint64_t>(i));
      std::optional<bool> known;
      for (std::size_t m = 0; m < ours.size(); ++m) {
        const auto proved = judge(p, ours[m].solve, here[m]);
        if (!known) known = proved;
      }
      const LcpData lcp = lcp_of(p);
      if (!known || (p.H * lcp.q - p.tau).norm() > 1e-9 * p.tau.norm()) continue;
      for (std::size_t k = 0; k < peers.size(); ++k) judge_lcp(peers[k], lcp, *known, here[ours.size() + k]);
    }
    for (std::size_t m = 0; m < rows.size(); ++m) rows[m].add(family.name, here[m]);
  }
  auto& table = add_figure(
      part, "table", "muscle_verdicts", "Muscle forces: what was said, and how much of it was wrong",
      "Fresh random problems: torques at random (any), of pulling muscles (held), of a few (few: at the limit of what "
      "all can give), with joints that depend on others (dependent), of any size (scaled). The columns tell what a "
      "solver said, and how many of its words were wrong. Of ours is wrong: forces off the optimality conditions by "
      "more than 1e-6, or joint velocities that should prove that there are none and do not; of other projects, a "
      "word against our proof, or an LCP solved to worse than 1e-6. They are not asked where dependent joints "
      "contradict each other, for there is no LCP. The worst error is that of forces, or of the LCP.",
      fmt::format("{} problems a family, solved by each method twice in a row; median and 99 % of the second times, "
                  "clock included.",
                  count));
  table["columns"] = VerdictRow::columns();
  table["rows"] = ordered_json::array();
  for (const VerdictRow& row : rows) table["rows"].push_back(row.row());
}

void add_growth(ordered_json& part, bool quick) {
  const int count = quick ? 20 : 50, turns = quick ? 11 : 51;
  struct Curve {
    std::string name;
    bool peer;
    std::vector<double> fingers, us;
  };
  std::vector<Curve> curves;
  const std::vector<double> sizes{2, 3, 4, 5};
  std::vector<double> bytes;
  for (const double size : sizes) {
    const auto fingers = static_cast<Index>(size);
    Case c;
    for (std::uint64_t seed = 0; std::ssize(c.problems) < count; ++seed) {
      Random random(seed);
      c.add(repeated_hand(fingers, random));
    }
    const double before = heap_bytes();
    const MuscleWorkspace work(4 * fingers, c.problems.front().problem.H.cols());
    bytes.push_back(heap_bytes() - before + sizeof work);
    const std::vector<WorkPoint> points = measure(c, turns);
    if (curves.empty()) {
      for (const WorkPoint& point : points) curves.push_back({point.method, point.peer, {}, {}});
    }
    for (std::size_t m = 0; m < points.size(); ++m) {
      if (!(points[m].error <= kProved)) continue;
      curves[m].fingers.push_back(size);
      curves[m].us.push_back(points[m].us);
    }
  }
  auto& figure = add_figure(
      part, "curves", "growth_muscle", "Muscle forces: time over the number of fingers",
      fmt::format(
          "Hands of a thumb (4 joints, 8 muscles) and one to four fingers (4 joints, 7 muscles each, and one extensor "
          "common to them), moment arms of the hand's signs at random, torques that pulling muscles give. A method "
          "has a point where all its answers are right to 1e-6. The active set forms nothing of the size of the "
          "muscles squared, and works on the thumb by itself. It takes its memory from the stack, the same for any "
          "hand; that of Lemke's method, taken once, grows from {:.0f} to {:.0f} bytes, with the exponent {:.1f} in "
          "fingers.",
          bytes.front(), bytes.back(), exponent(sizes, bytes)),
      fmt::format("Medians of {} rounds of {} problems, methods in turns. Exponents: of the upper half of the sizes, "
                  "of all of fewer than six.",
                  turns, count));
  figure["x"] = {{"label", "fingers"}, {"log", true}};
  figure["y"] = {{"label", "time of a solve [µs]"}, {"log", true}};
  auto& panel = figure["panels"].emplace_back(ordered_json{{"name", "2 to 5 fingers"}});
  for (const Curve& c : curves) {
    if (c.us.size() >= 3) panel["curves"].push_back(curve(c.name, c.fingers, c.us, c.peer));
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(argc, argv, "muscle", "Muscle forces",
                          "Which forces 23 muscles should pull with to give the torques of 12 joints, eq. (23): the "
                          "least that do. Once a control period.",
                          {thenar::add_work_precision, thenar::add_verdicts, thenar::add_growth});
}
