// SPDX-License-Identifier: Apache-2.0
// The published timing table of Rougeron et al. 2006 beside ours: the same computations on the same sizes, with the
// accuracy that ours are had at, and what of the ratio is the hardware's.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <stdexcept>
#include <vector>

#include "bench/cases/recorded.h"
#include "bench/methods/contact_computation.h"
#include "bench/report/figure.h"
#include "bench/report/machine.h"
#include "bench/report/measure.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscles/muscle_forces.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr std::array<Index, 3> kContacts{15, 30, 60};

// --- What hardware explains -----------------------------------------------------------------------------------------

constexpr double kPentium_GHz = 2.2;
// SSE2 on a Pentium 4: an addition and a multiplication of two doubles take turns, each at half rate [Intel, IA-32
// Architecture Optimization Manual]. In single precision both processors do twice as much.
constexpr double kPentium_flops_per_cycle = 2.0;

/// How many times as fast this processor is as a Pentium IV at 2.2 GHz, by its clock alone and by its arithmetic alone.
struct Handicap {
  double GHz, Gflops;
  [[nodiscard]] double low() const { return GHz / kPentium_GHz; }
  [[nodiscard]] double high() const { return Gflops / (kPentium_GHz * kPentium_flops_per_cycle); }
};

void hardware(ordered_json& part, const Handicap& h) {
  ordered_json& figure = add_figure(
      part, "table", "hardware", "How much faster the hardware is",
      "What of the ratios above is the processor's. Clock: the least that hardware gives, if a cycle did as much then "
      "as now. Arithmetic: double-precision multiply-adds a second in the vectors of this build, the most that it "
      "gives, to code that does nothing else; a Pentium IV ends at one addition or multiplication of two doubles a "
      "cycle. The two ends are a range, not an error bar: where between them the published program lies is not known, "
      "nor are its compiler and its flags.",
      "the best of 100 loops each");
  figure["columns"] = {"measure", "Pentium IV, 2.2 GHz", "here", "times"};
  figure["rows"] = {{"clock [GHz]", kPentium_GHz, h.GHz, h.low()},
                    {"double-precision peak [Gflop/s]", kPentium_GHz * kPentium_flops_per_cycle, h.Gflops, h.high()}};
}

// --- Small problems -------------------------------------------------------------------------------------------------

/// Times of a method and the worst of its answers.
struct Solves {
  std::vector<double> us;
  double worst_error = 0.0;

  template <typename Solve, typename Error>
  void add(Solve&& solve, Error&& error) {
    us.push_back(time_us(solve));
    worst_error = std::max(worst_error, error());
  }
};

struct SmallProblems {
  Solves grasp_by_lemke, grasp, grasp_round, active_by_lemke, active, active_round, muscles_by_lemke, muscles;
};

/// A half of the friction that the least forces use, so that they no longer lie within the cones.
double too_little_friction(const GraspProblem& problem) {
  VectorXd f(3 * std::ssize(problem.contacts));
  if (solve_grasp_forces(problem, f).status != GraspStatus::kOptimal) throw std::runtime_error("no grasp forces");
  double used = 0.0;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const Vector3d force_N = f.segment<3>(3 * static_cast<Index>(i));
    const double normal_N = force_N.dot(problem.contacts[i].axes.col(0));
    used = std::max(used, std::sqrt(force_N.squaredNorm() - normal_N * normal_N) / normal_N);
  }
  return 0.5 * used;
}

/// Both cones, and the published method, on one problem.
void solve_grasp(GraspProblem pyramid, GraspWorkspace& work, Solves& by_lemke, Solves& by_pyramids, Solves& by_cones) {
  pyramid.cone = FrictionCone::kPyramid;
  GraspProblem round_cone = pyramid;
  round_cone.cone = FrictionCone::kExact;
  VectorXd f(3 * std::ssize(pyramid.contacts));
  GraspReport report;
  const auto add = [&](Solves& to, const GraspProblem& problem, auto solve) {
    to.add([&] { report = solve(problem); }, [&] { return grasp_kkt_error(problem, report.multiplier, f); });
    if (report.status != GraspStatus::kOptimal) throw std::runtime_error("no grasp forces");
  };
  add(by_lemke, pyramid, [&](const auto& p) { return solve_grasp_forces_by_lemke(p, work, f); });
  add(by_pyramids, pyramid, [&](const auto& p) { return solve_grasp_forces(p, f); });
  add(by_cones, round_cone, [&](const auto& p) { return solve_grasp_forces(p, f); });
}

/// All methods on each recorded problem in turn.
SmallProblems solve_small_problems(int rounds) {
  const RecordedProblems& run = recorded_run(60);
  SmallProblems all;
  GraspWorkspace lemke;
  for (int round = 0; round < rounds; ++round) {
    for (const GraspFile& file : run.grasps) {
      GraspProblem problem = file.problem(FrictionCone::kExact);
      solve_grasp(problem, lemke, all.grasp_by_lemke, all.grasp, all.grasp_round);
      problem.friction = too_little_friction(problem);
      solve_grasp(problem, lemke, all.active_by_lemke, all.active, all.active_round);
    }
    for (const MuscleFile& file : run.muscles) {
      MuscleWorkspace work(file.H.rows(), file.H.cols());
      VectorXd f(file.H.cols());
      MuscleReport report;
      const auto error = [&] { return muscle_kkt_error(file, report.multiplier, f); };
      all.muscles_by_lemke.add([&] { report = solve_muscle_forces_by_lemke(file, work, f); }, error);
      all.muscles.add([&] { report = solve_muscle_forces(file, f); }, error);
    }
  }
  return all;
}

// --- Contact computations -------------------------------------------------------------------------------------------

struct Computation {
  std::vector<ContactComputation> ticks;
  std::vector<double> force_errors;  ///< Of some of the ticks.
  double hertz_error = 0.0;

  template <typename Value>
  [[nodiscard]] Percentiles over_ticks(Value&& value) const {
    std::vector<double> values;
    for (const ContactComputation& tick : ticks) values.push_back(value(tick));
    return percentiles(std::move(values));
  }
};

/// Timed first, then judged: what the accurate solves do to the caches is in no time.
std::array<Computation, kContacts.size()> compute_contacts(int turns) {
  constexpr int kToTheTolerance = 1000, kJudged = 100, kEvery = 5;
  std::deque<ContactRun> runs;
  for (const Index contacts : kContacts) runs.emplace_back(contacts, kToTheTolerance);
  std::vector<std::vector<ContactComputation>> ticks = in_turns(runs, turns);
  std::array<Computation, kContacts.size()> all;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    all[k].ticks = std::move(ticks[k]);
    all[k].hertz_error = runs[k].hertz_error();
    for (int i = 0; i < kJudged; ++i) {
      (void)runs[k].tick();
      if (i % kEvery == 0) all[k].force_errors.push_back(runs[k].force_error());
    }
  }
  return all;
}

double total_us(const ContactComputation& tick) { return 1e6 * tick.total_s(); }

// --- Tables ---------------------------------------------------------------------------------------------------------

std::string left(double published_us, double us, const Handicap& h) {
  return fmt::format("{:.0f} to {:.0f}", published_us / us / h.high(), published_us / us / h.low());
}

void published(ordered_json& part, const SmallProblems& small,
               const std::array<Computation, kContacts.size()>& contacts, const Handicap& h, const std::string& runs) {
  ordered_json& figure = add_figure(
      part, "table", "published", "The published timings, side by side",
      fmt::format(
          "Times of Rougeron et al. 2006 on a Pentium IV at 2.2 GHz, and here on one core. Hardware alone explains a "
          "factor of {:.1f} (clock) to {:.0f} (arithmetic), see the next table; what is left when it is taken out is "
          "the method's: above 1, the same program on the old machine would have been so much faster. The paper has no "
          "time for muscles. Grasp forces: the recorded problems have nothing to decide, their least forces lie within "
          "the cones; with half the friction that these use, cones are active. Which kind the paper timed is not "
          "known. A contact computation is contact finding among 36 000 + 3 x 2400 points, the compliance, "
          "Gauss-Seidel to a residual of 1e-6, the deformation of the control points, 12 for each contact (3 x 60, "
          "120, 240), and the display of 3 x 2400 points, which is {:.0f} % of it at 60 contacts and not in a loop "
          "that nobody watches. With 320 control points 5 or 10 contacts a finger do not hold the patch, and the pulps "
          "pass into the box. KKT: how far forces are from the optimum's conditions, the worst; solver: the forces "
          "against an accurate solve, |f - f*| / |f*|, median; Hertz: a pulp's force on a plane against Hertz's, rms "
          "over six directions and three depths up to the expected load.",
          h.low(), h.high(),
          100.0 * contacts.back().over_ticks([](const auto& tick) { return tick.display_s / tick.total_s(); }).p50),
      runs);
  figure["columns"] = {"computation",    "published [µs]", "here, median [µs]",
                       "here, p99 [µs]", "times as fast",  "left when the hardware is taken out",
                       "accuracy here"};
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  const auto row = [&](const std::string& name, double theirs_us, const Percentiles& ours,
                       const std::string& accuracy) {
    if (std::isnan(theirs_us)) {
      figure["rows"].push_back({name, "-", ours.p50, ours.p99, "-", "-", accuracy});
    } else {
      least = std::min(least, theirs_us / ours.p50);
      most = std::max(most, theirs_us / ours.p50);
      figure["rows"].push_back(
          {name, theirs_us, ours.p50, ours.p99, theirs_us / ours.p50, left(theirs_us, ours.p50, h), accuracy});
    }
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN(), kGrasp_us = 40.0;
  const auto small_row = [&](const std::string& name, double theirs_us, const Solves& solves) {
    row(name, theirs_us, percentiles(solves.us), fmt::format("KKT {:.0e}", solves.worst_error));
  };
  const auto ours = [](const std::string& problem, FrictionCone cone) {
    return fmt::format("{} ({})", problem, grasp_method(cone));
  };
  small_row("grasp forces, the published method (Lemke on the LCP)", kGrasp_us, small.grasp_by_lemke);
  small_row(ours("grasp forces", FrictionCone::kPyramid), kGrasp_us, small.grasp);
  small_row(ours("grasp forces", FrictionCone::kExact), kGrasp_us, small.grasp_round);
  small_row("grasp forces, cones active, the published method (Lemke on the LCP)", kGrasp_us, small.active_by_lemke);
  small_row(ours("grasp forces, cones active", FrictionCone::kPyramid), kGrasp_us, small.active);
  small_row(ours("grasp forces, cones active", FrictionCone::kExact), kGrasp_us, small.active_round);
  for (std::size_t k = 0; k < kContacts.size(); ++k) {
    const Percentiles residual = contacts[k].over_ticks([](const auto& tick) { return tick.solve.residual; });
    row(fmt::format("contact computation, {} contacts", kContacts[k]), published_us(kContacts[k]),
        contacts[k].over_ticks(total_us),
        fmt::format("force: Hertz {:.1f} %, solver {:.0e}; residual {:.0e}, worst {:.0e}",
                    100.0 * contacts[k].hertz_error, percentiles(contacts[k].force_errors).p50, residual.p50,
                    residual.max));
  }
  small_row("muscle forces, the published method (Lemke on the LCP)", kNone, small.muscles_by_lemke);
  small_row("muscle forces (active set)", kNone, small.muscles);
  figure["caption"] = fmt::format("Everything is {:.0f} to {:.0f} times as fast as published. ", least, most) +
                      figure["caption"].get<std::string>();
}

void tables(ordered_json& part, bool quick) {
  const int turns = quick ? 20 : 200, rounds = quick ? 10 : 100;
  const Handicap handicap{measured_GHz(), measured_Gflops()};
  const SmallProblems small = solve_small_problems(rounds);
  const auto contacts = compute_contacts(turns);
  published(part, small, contacts, handicap,
            fmt::format("{} contact computations of each size, which took turns of {}, the first {} of a turn dropped; "
                        "{} solves of each small problem, methods in turns, clock included",
                        contacts[0].ticks.size(), kTicksATurn, kDroppedTicks, small.grasp.us.size()));
  hardware(part, handicap);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(
      argc, argv, "published", "The published timings, side by side",
      "The paper's timing table is the one measure that it shares with this program: the same hand, box and "
      "numbers of points. Lower is better; no time stands without its accuracy.",
      {tables});
}
