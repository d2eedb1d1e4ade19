// Contact forces of a frame of the box grasp, from the last tick's, with W in factors or dense: what the factors save.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench/recorded.h"
#include "engine/stopwatch.h"
#include "solvers/contact_sweeps.h"
#include "solvers/grouped_delassus.h"

namespace thenar {
namespace {

using Eigen::Index;

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
void at_published_contacts(benchmark::internal::Benchmark* bench) {
  bench->Arg(15)->Arg(30)->Arg(60)->ArgName("contacts")->UseManualTime()->Unit(benchmark::kMicrosecond);
}
BENCHMARK_CAPTURE(frame_forces, in_factors, Form::kFactors)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(frame_forces, dense_given, Form::kDenseGiven)->Apply(at_published_contacts);
BENCHMARK_CAPTURE(frame_forces, dense_formed, Form::kDenseFormed)->Apply(at_published_contacts);

}  // namespace
}  // namespace thenar
