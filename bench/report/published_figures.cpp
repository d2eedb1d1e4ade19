// The published timing table of Rougeron et al. 2006 beside ours: the same computations on the same sizes, with the
// accuracy that ours are had at, stage by stage, and what of the ratio is the hardware's.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <vector>

#include "bench/contact_computation.h"
#include "bench/recorded.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscle_forces.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr std::array<Index, 3> kContacts{15, 30, 60};

// --- What hardware explains -----------------------------------------------------------------------------------------

constexpr double kPentium_GHz = 2.2;
// SSE2 on a Pentium 4: an addition and a multiplication of two doubles take turns, each at half rate [Intel, IA-32
// Architecture Optimization Manual]. In single precision both processors do twice as much.
constexpr double kPentium_flops_per_cycle = 2.0;

/// Least time of many calls: what the hardware can do.
template <typename Work>
double least_us(Work&& work) {
  double least = time_us(work);
  for (int i = 0; i < 100; ++i) least = std::min(least, time_us(work));
  return least;
}

/// Cycles a nanosecond: additions that wait for one another take a cycle each.
double measured_GHz() {
  constexpr int kAdditions = 1 << 20;
  const double us = least_us([] {
    std::uint64_t sum = 1;
    for (int i = 0; i < kAdditions; i += 8) {
      // Opaque to the compiler, which would fold additions of a constant.
      for (int k = 0; k < 8; ++k) {
        sum += sum;
        asm volatile("" : "+r"(sum));
      }
    }
  });
  return 1e-3 * kAdditions / us;
}

/// Floating-point operations a nanosecond of multiply-adds that wait for nothing, in the vectors that this build uses.
double measured_Gflops() {
  constexpr int kSteps = 1 << 15, kLanes = 32;
  using Lanes = Eigen::Array<double, kLanes, 1>;
  Lanes sums = Lanes::LinSpaced(0.1, 0.9);  // In no more registers than there are.
  const Lanes factor = Lanes::Constant(0.999), more = Lanes::Constant(1e-3);
  const double us = least_us([&] {
    Lanes s = sums;
    for (int i = 0; i < kSteps; ++i) s = s * factor + more;
    sums = s;
  });
  return sums.isFinite().all() ? 2e-3 * kSteps * kLanes / us : 0.0;
}

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
      "cycle. What is neither lies between: 7-Zip's own benchmark, integers and memory, reads 1033 MIPS on a 2.4 GHz "
      "Pentium IV of the same core (p7zip 9.20, one thread, pastebin.com/JbU94SUn), and on a busy virtual machine of "
      "an EPYC of 2024 some 3500 per second of processor time (7-Zip 26.02, measured once): at least 3.7 times as much "
      "at 2.2 GHz. The published program, its compiler and its flags are not known: the two ends are a range, not an "
      "error bar.",
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
  Solves grasp_by_lemke, grasp, grasp_round, muscles_by_lemke, muscles;
};

/// All methods on each recorded problem in turn.
SmallProblems solve_small_problems(int rounds) {
  const RecordedRun& run = recorded_run(60);
  SmallProblems all;
  GraspWorkspace lemke;
  for (int round = 0; round < rounds; ++round) {
    for (const GraspFile& file : run.grasps) {
      GraspProblem pyramid{.contacts = file.contacts,
                           .wrench = file.wrench,
                           .friction = file.friction,
                           .cone = FrictionCone::kPyramid,
                           .internal_force_N = file.internal_force_N};
      GraspProblem round_cone = pyramid;
      round_cone.cone = FrictionCone::kExact;
      VectorXd f(3 * std::ssize(file.contacts));
      GraspReport report;
      const auto add = [&](Solves& to, const GraspProblem& problem, auto solve) {
        to.add([&] { report = solve(problem); }, [&] { return grasp_kkt_error(problem, report.multiplier, f); });
      };
      add(all.grasp_by_lemke, pyramid, [&](const auto& p) { return solve_grasp_forces_by_lemke(p, lemke, f); });
      add(all.grasp, pyramid, [&](const auto& p) { return solve_grasp_forces(p, f); });
      add(all.grasp_round, round_cone, [&](const auto& p) { return solve_grasp_forces(p, f); });
    }
    for (const MuscleFile& file : run.muscles) {
      MuscleWorkspace work(file.H.rows(), file.H.cols());
      VectorXd f(file.H.cols());
      MuscleReport report;
      const VectorXd no_limits;
      const auto error = [&] { return muscle_kkt_error(file.H, file.tau, no_limits, report.multiplier, f); };
      all.muscles_by_lemke.add([&] { report = solve_muscle_forces_by_lemke(file.H, file.tau, work, f); }, error);
      all.muscles.add([&] { report = solve_muscle_forces(file.H, file.tau, f); }, error);
    }
  }
  return all;
}

// --- Contact computations -------------------------------------------------------------------------------------------

struct Computation {
  std::vector<ContactComputation> ticks;
  std::vector<double> force_errors;  ///< Of some of the ticks.

  template <typename Value>
  [[nodiscard]] Percentiles over_ticks(Value&& value) const {
    std::vector<double> values;
    for (const ContactComputation& tick : ticks) values.push_back(value(tick));
    return percentiles(std::move(values));
  }
};

/// The sizes take turns, tick by tick.
std::array<Computation, kContacts.size()> compute_contacts(int ticks) {
  constexpr int kToTheTolerance = 1000, kUntimed = 50, kJudged = 40;
  std::deque<ContactRun> runs;
  for (const Index contacts : kContacts) runs.emplace_back(contacts, kToTheTolerance);
  std::array<Computation, kContacts.size()> all;
  for (int i = -kUntimed; i < ticks; ++i) {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const ContactComputation tick = runs[k].tick();
      if (i < 0) continue;
      all[k].ticks.push_back(tick);
      if (i % (ticks / kJudged) == 0) all[k].force_errors.push_back(runs[k].force_error());
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
          "Times that Rougeron et al. 2006 measured on a Pentium IV at 2.2 GHz, and ours on one core here. \"Times as "
          "fast\" is their time over our median. Hardware alone explains a factor of {:.1f} (clock) to {:.0f} "
          "(arithmetic), see the table of the hardware; what is left is the method's: more than 1 means that the same "
          "program on the old machine would have been so much faster. No published time stands beside the muscles. A "
          "contact computation is contact finding among 36 000 + 3 x 2400 points, the compliance among the contacts, "
          "Gauss-Seidel to a residual of 1e-6, the deformation of 3 x 320 control points, and its display at 3 x 2400 "
          "points. KKT: how far forces are from the optimum's conditions, the worst; force error: against an accurate "
          "solve of the same problem, |f - f*| / |f*|, median.",
          h.low(), h.high()),
      runs);
  figure["columns"] = {"computation",    "published [us]", "here, median [us]",
                       "here, p99 [us]", "times as fast",  "left without the hardware",
                       "accuracy here"};
  const auto row = [&](const std::string& name, double theirs_us, const Percentiles& ours,
                       const std::string& accuracy) {
    if (std::isnan(theirs_us)) {
      figure["rows"].push_back({name, "-", ours.p50, ours.p99, "-", "-", accuracy});
    } else {
      figure["rows"].push_back(
          {name, theirs_us, ours.p50, ours.p99, theirs_us / ours.p50, left(theirs_us, ours.p50, h), accuracy});
    }
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN(), kGrasp_us = 40.0;
  const auto small_row = [&](const std::string& name, double theirs_us, const Solves& solves) {
    row(name, theirs_us, percentiles(solves.us), fmt::format("KKT {:.0e}", solves.worst_error));
  };
  small_row("grasp forces, the published method (Lemke on the LCP)", kGrasp_us, small.grasp_by_lemke);
  small_row("grasp forces, pyramids (active set)", kGrasp_us, small.grasp);
  small_row("grasp forces, round cones", kGrasp_us, small.grasp_round);
  for (std::size_t k = 0; k < kContacts.size(); ++k) {
    const Percentiles residual = contacts[k].over_ticks([](const auto& tick) { return tick.solve.residual; });
    row(fmt::format("contact computation, {} contacts", kContacts[k]), published_us(kContacts[k]),
        contacts[k].over_ticks(total_us),
        fmt::format("residual {:.0e}, worst {:.0e}; force error {:.0e}", residual.p50, residual.max,
                    percentiles(contacts[k].force_errors).p50));
  }
  small_row("muscle forces, the published method (Lemke on the LCP)", kNone, small.muscles_by_lemke);
  small_row("muscle forces (active set)", kNone, small.muscles);
}

void stages(ordered_json& part, const std::array<Computation, kContacts.size()>& contacts, const std::string& runs) {
  ordered_json& figure = add_figure(
      part, "table", "stages", "A contact computation, stage by stage",
      "Where the time of a contact computation goes, medians in microseconds; the median of the total is not the sum "
      "of medians. Contacts are found and their compliance made once a control period; assembling (gaps, Jacobians), "
      "solving and deforming are done in every contact tick; the display is a viewer's, and a loop that nobody watches "
      "does without.",
      runs);
  figure["columns"] = {"contacts", "find", "compliance", "assemble", "solve", "deform", "display", "total", "sweeps"};
  for (std::size_t k = 0; k < kContacts.size(); ++k) {
    using Tick = ContactComputation;
    const auto us = [&](double Tick::*stage) {
      return contacts[k].over_ticks([&](const Tick& tick) { return 1e6 * tick.*stage; }).p50;
    };
    figure["rows"].push_back({kContacts[k], us(&Tick::find_s), us(&Tick::compliance_s), us(&Tick::assemble_s),
                              us(&Tick::solve_s), us(&Tick::deform_s), us(&Tick::display_s),
                              contacts[k].over_ticks(total_us).p50,
                              contacts[k].over_ticks([](const Tick& tick) { return tick.solve.sweeps; }).p50});
  }
}

void run(const PartArguments& arguments) {
  const int ticks = arguments.quick ? 400 : 4000, rounds = arguments.quick ? 10 : 100;
  ordered_json part =
      make_part("published", "The published timings, side by side",
                "The paper's timing table is the one measure that it shares with this program: the same hand, box and "
                "numbers of points. Lower is better; no time stands without its accuracy.",
                arguments);
  const Handicap handicap{measured_GHz(), measured_Gflops()};
  const SmallProblems small = solve_small_problems(rounds);
  const auto contacts = compute_contacts(ticks);
  const std::string runs = fmt::format(
      "{} contact computations of each size, which took turns; {} solves of each small problem, methods in turns, "
      "clock included",
      ticks, small.grasp.us.size());
  published(part, small, contacts, handicap, runs);
  stages(part, contacts, runs);
  hardware(part, handicap);
  write_part(part, arguments);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) { thenar::run(thenar::part_arguments(argc, argv)); }
