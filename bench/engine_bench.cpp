// The contact computation of the paper's timing table, stage by stage, on states recorded from the box grasp: contact
// finding, Delassus operator, Gauss-Seidel, deformation of the control points, interpolation at 3 x 2400 samples.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench/recorded.h"
#include "engine/stopwatch.h"
#include "engine/surface_display.h"
#include "solvers/contact_sweeps.h"
#include "solvers/grouped_delassus.h"

namespace thenar {
namespace {

using Eigen::Index;

// Rougeron et al. 2006, Pentium IV 2.2 GHz.
double published_us(long contacts) { return contacts <= 15 ? 6000.0 : contacts <= 30 ? 10000.0 : 20000.0; }

/// Seconds that a stage took of a tick.
using Stage = double (*)(const ControlReport&, const TickReport&, double interpolate_s);

/// Every iteration does a whole contact computation on the next recorded tick, and counts one stage of it.
void contact_computation(benchmark::State& bench, Stage stage) {
  const RecordedRun& run = recorded_run(bench.range(0));
  Frame frame(run.model);
  ContactWorkspace work(run.model);
  std::vector<SurfaceDisplay> displays(run.model.pulps.begin(), run.model.pulps.end());
  RecordedTick tick = run.ticks.front();
  double residual = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % run.ticks.size();
    tick = run.ticks[i];
    const ControlReport control = control_tick(run.model, tick.state, tick.controller, frame);
    const TickReport contact = contact_tick(run.model, frame, work, tick.state);
    Stopwatch watch;
    for (std::size_t k = 0; k < displays.size(); ++k) {
      benchmark::DoNotOptimize(displays[k].displace(tick.state.u_m[k]).data());
    }
    bench.SetIterationTime(stage(control, contact, watch.lap()));
    residual = std::max(residual, contact.solve.residual);
    if (contact.solve.status != SolveStatus::kConverged) bench.SkipWithError("did not converge");
  }
  bench.counters["worst_residual"] = residual;
  bench.counters["published_total_us"] = published_us(bench.range(0));
}

double find(const ControlReport& control, const TickReport&, double) { return control.find_s; }
double assemble(const ControlReport& control, const TickReport& tick, double) {
  return control.factors_s + tick.assemble_s;
}
double solve(const ControlReport&, const TickReport& tick, double) { return tick.solve_s; }
double deform(const ControlReport&, const TickReport& tick, double) { return tick.deform_s; }
double interpolate(const ControlReport&, const TickReport&, double interpolate_s) { return interpolate_s; }
double total(const ControlReport& control, const TickReport& tick, double interpolate_s) {
  return find(control, tick, interpolate_s) + assemble(control, tick, interpolate_s) + tick.solve_s + tick.deform_s +
         interpolate_s;
}

void at_published_contacts(benchmark::internal::Benchmark* bench) {
  bench->Arg(15)->Arg(30)->Arg(60)->ArgName("contacts")->UseManualTime()->Unit(benchmark::kMicrosecond);
}
BENCHMARK_CAPTURE(contact_computation, find, find)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(contact_computation, assemble, assemble)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(contact_computation, solve, solve)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(contact_computation, deform, deform)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(contact_computation, interpolate, interpolate)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(contact_computation, total, total)->Apply(at_published_contacts);

// Contact forces of a frame, from the last tick's, with W in factors or dense: what the factors save.
enum class Form { kFactors, kDenseGiven, kDenseFormed };

void frame_forces(benchmark::State& bench, Form form) {
  const RecordedRun& run = recorded_run(bench.range(0));
  const Model& model = run.model;
  const Index rows = 3 * bench.range(0);
  Frame frame(model);
  ContactWorkspace work(model);
  SweepWorkspace sweeps(bench.range(0));
  Eigen::MatrixXd W(rows, rows);
  Eigen::VectorXd f(rows), delta(rows);
  RecordedTick tick = run.ticks.front();
  double residual = 0.0, count = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % run.ticks.size();
    tick = run.ticks[i];
    (void)control_tick(model, tick.state, tick.controller, frame);
    (void)contact_tick(model, frame, work, tick.state);
    const GroupedDelassus factors = delassus_operator(model, frame, work.kinematics, work.mobility);
    if (form == Form::kDenseGiven) factors.to_dense(W);
    f = work.f_first.head(rows);
    const GaussSeidelSettings settings{.tolerance = 1e-6, .max_sweeps = 1000};
    Stopwatch watch;
    if (form == Form::kDenseFormed) factors.to_dense(W);
    const SolveReport report =
        form == Form::kFactors
            ? solve_contacts(factors, work.delta_free.head(rows), work.mu.head(rows / 3), settings, work.solver, f,
                             delta)
            : solve_contacts(W, work.delta_free.head(rows), work.mu.head(rows / 3), settings, sweeps, f, delta);
    bench.SetIterationTime(watch.lap());
    residual = std::max(residual, report.residual);
    count += report.sweeps;
    if (report.status != SolveStatus::kConverged) bench.SkipWithError("did not converge");
  }
  bench.counters["worst_residual"] = residual;
  bench.counters["sweeps"] = count / static_cast<double>(bench.iterations());
}
BENCHMARK_CAPTURE(frame_forces, in_factors, Form::kFactors)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(frame_forces, dense_given, Form::kDenseGiven)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(frame_forces, dense_formed, Form::kDenseFormed)->Apply(at_published_contacts);

}  // namespace
}  // namespace thenar
