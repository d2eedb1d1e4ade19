// SPDX-License-Identifier: Apache-2.0
// How far each stage of a contact computation is from what the machine could do at most.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <string>
#include <vector>

#include "bench/methods/contact_computation.h"
#include "bench/report/figure.h"
#include "bench/report/machine.h"
#include "solvers/contact_sweeps.h"

namespace thenar {
namespace {

using Eigen::Index;
using nlohmann::ordered_json;

/// What one core does at most.
struct Machine {
  double GHz = measured_GHz();
  double madds_per_us = 0.5e3 * measured_Gflops();  ///< In double precision; twice as many in single.
  double bytes_per_us = 1e3 * measured_GB_per_s();
  double step_us = 0.0;  ///< A contact's local step in a sweep, which waits for the one before it.
};

/// Nanoseconds that a local step of a sweep takes where all it needs is in registers and only the last one's result
/// keeps it waiting: the chain that no sweep of one contact after the other can be faster than.
double measured_step_us() {
  constexpr int kSteps = 4096;
  const LocalStep local = local_step(1e-3, 1e-5, 2e-5, 1.1e-3, 1.2e-3);
  Rows f{1.0, 0.1, 0.0}, gap{1e-6, 1e-7, 1e-7};
  const double us = least_us([&] {
    for (int i = 0; i < kSteps; ++i) {
      const Rows updated = update_force(local, 0.5, gap, f);
      gap = {1e-6 - 1e-4 * (updated.n - f.n), 1e-7 - 1e-4 * (updated.t1 - f.t1), 1e-7 - 1e-4 * (updated.t2 - f.t2)};
      asm volatile("" : "+x"(gap.n), "+x"(gap.t1), "+x"(gap.t2));
    }
  });
  return f.n + gap.n > 0.0 ? us / kSteps : 0.0;
}

/// The least that a stage must do, whatever its method's details.
struct Least {
  double madds = 0.0;          ///< Multiply-adds, of double precision; one of single precision counts half.
  double bytes = 0.0;          ///< Read and written, once each.
  double chained_steps = 0.0;  ///< Local steps that wait for one another.
};

struct Stage {
  std::string name, rest;
  Least least;
  double us;
};

std::vector<Stage> stages_of(const Workload& w, const std::vector<ContactComputation>& ticks) {
  const auto median_us = [&](double ContactComputation::*seconds) {
    std::vector<double> us;
    for (const ContactComputation& tick : ticks) us.push_back(1e6 * tick.*seconds);
    return percentiles(std::move(us)).p50;
  };
  const double n = w.contacts, pairs = w.pairs, loaded = w.loaded, sweeps = w.sweeps;
  const double block = 9.0 * pairs;           // entries of W among the contacts of a finger
  const double swept = 9.0 * w.loaded_pairs;  // of them in the columns of loaded contacts
  // A patch of the surface: 45 coefficients, its plane and frame.
  const Least find{n * 80.0, n * 330.0};
  // Three numbers a pair, read in double precision and written in double and, by rows, in single.
  const Least compliance{0.0, pairs * (3 * 8.0 + 3 * 8.0 + 9 * 4.0)};
  // Jacobians of a finger's four joints and of the object's six freedoms, axes, gaps; read and written in doubles.
  const Least assemble{n * 150.0, n * 8.0 * (12.0 + 24.0 + 18.0 + 24.0)};
  // Blocks in single precision by 14 multiply-adds an entry; gaps in double precision, 10 multiply-adds a pair, before
  // the first sweep and after the last; sweeps; their acceleration, 20 numbers a row.
  const Least solve{
      7.0 * block + 2.0 * 10.0 * w.loaded_pairs + sweeps * (0.5 * swept + 0.5 * 20.0 * 3.0 * n),
      block * 4.0 + pairs * 9.0 * 4.0 + 2.0 * w.loaded_pairs * 24.0 + sweeps * (4.0 * swept + 4.0 * 20.0 * 3.0 * n),
      sweeps * loaded};
  const Least deform{3.0 * loaded * w.controls, 8.0 * loaded * w.controls + 48.0 * w.controls * 3.0};
  // Ten weights a sample.
  const Least display{0.5 * 30.0 * w.samples, w.samples * (10.0 * 4.0 + 12.0)};
  using Tick = ContactComputation;
  return {{"find", "which points might touch, and which sample is nearest: searches that branch", find,
           median_us(&Tick::find_s)},
          {"compliance", "gathering from the kernel of all control points", compliance, median_us(&Tick::compliance_s)},
          {"assemble", "small matrices, four contacts at a time; the hand's kinematics", assemble,
           median_us(&Tick::assemble_s)},
          {"solve", "contacts that do not bear, padding, conversions; the ledger and the commit", solve,
           median_us(&Tick::solve_s)},
          {"deform", "columns of the kernel come from beyond the nearest cache", deform, median_us(&Tick::deform_s)},
          {"display", "eight samples share a product with all that one of them needs: 17 weights, not 10", display,
           median_us(&Tick::display_s)}};
}

void limits(ordered_json& part, bool quick) {
  constexpr std::array<Index, 3> kSizes{15, 60, 240};
  const int turns = quick ? 4 : 20;
  std::deque<ContactRun> runs;
  for (const Index size : kSizes) runs.emplace_back(size, 1000);
  const std::vector<std::vector<ContactComputation>> ticks = in_turns(runs, turns);
  Machine machine;
  machine.step_us = measured_step_us();
  ordered_json& figure = add_figure(
      part, "table", "limits", "Share of the machine's limit",
      fmt::format(
          "What each stage of a contact computation must do at the least, whatever its details, over what one core "
          "does "
          "at most: {:.0f} multiply-adds a nanosecond in double precision (twice as many in single), {:.0f} bytes a "
          "nanosecond from a megabyte that it has just read, and {:.0f} ns for a contact's local step in a sweep, "
          "which "
          "must wait for the one before it (at {:.1f} GHz). The largest of the three is the stage's limit; the share "
          "is how much of the stage's time that is, and the last column says what the rest is. The box grasp on its "
          "way, solved to a residual of 1e-6.",
          1e-3 * machine.madds_per_us, 1e-3 * machine.bytes_per_us, 1e3 * machine.step_us, machine.GHz),
      fmt::format("medians of {} ticks of each size, which took turns of {} ticks, the first {} of a turn dropped; "
                  "the machine: the best of 100 loops each",
                  turns * (kTicksATurn - kDroppedTicks), kTicksATurn, kDroppedTicks));
  figure["columns"] = {"contacts",   "stage",      "median [µs]", "multiply-adds [µs]",
                       "bytes [µs]", "chain [µs]", "share [%]",   "what the rest is"};
  for (std::size_t k = 0; k < kSizes.size(); ++k) {
    for (const Stage& stage : stages_of(runs[k].workload(), ticks[k])) {
      const double madds_us = stage.least.madds / machine.madds_per_us,
                   bytes_us = stage.least.bytes / machine.bytes_per_us,
                   chain_us = stage.least.chained_steps * machine.step_us;
      figure["rows"].push_back({kSizes[k], stage.name, stage.us, madds_us, bytes_us, chain_us,
                                100.0 * std::max({madds_us, bytes_us, chain_us}) / stage.us, stage.rest});
    }
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "limits", "Share of the limit",
                  "Where nothing else does the same work, the machine is the measure: what a core could do at most, "
                  "and how much of the time that explains.",
                  {limits});
}
