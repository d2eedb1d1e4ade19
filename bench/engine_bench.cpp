// The contact computation of the paper's timing table, stage by stage, in the box grasp: contact finding, compliance,
// Gauss-Seidel, deformation of the control points, interpolation at 3 x 2400 samples.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench/contact_computation.h"
#include "bench/recorded.h"
#include "engine/percentiles.h"
#include "engine/stopwatch.h"
#include "solvers/contact_sweeps.h"
#include "solvers/grouped_delassus.h"

namespace thenar {
namespace {

using Eigen::Index;

constexpr int kWarmSweeps = 10;

/// Every iteration is a whole contact computation on the next tick; its time is the total, all samples interpolated. The
/// counters are medians of the stages [us], and the residual: the median tick's and the worst one's.
void contact_computation(benchmark::State& bench, int max_sweeps) {
  ContactRun run(bench.range(0), max_sweeps);
  constexpr int kUntimed = 10;
  for (int i = 0; i < kUntimed; ++i) (void)run.tick();
  std::vector<ContactComputation> ticks;
  for (auto _ : bench) {
    ticks.push_back(run.tick());
    bench.SetIterationTime(ticks.back().total_s());
    if (max_sweeps > kWarmSweeps && ticks.back().solve.status != SolveStatus::kConverged) {
      bench.SkipWithError("did not converge");
    }
  }
  const auto median_us = [&](auto stage) {
    std::vector<double> us;
    for (const ContactComputation& tick : ticks) us.push_back(1e6 * stage(tick));
    return percentiles(std::move(us)).p50;
  };
  const auto add = [&](const char* name, auto stage) { bench.counters[name] = median_us(stage); };
  using Tick = ContactComputation;
  add("1_find", [](const Tick& t) { return t.find_s; });
  add("2_compliance", [](const Tick& t) { return t.compliance_s; });
  add("3_assemble", [](const Tick& t) { return t.assemble_s; });
  add("4_solve", [](const Tick& t) { return t.solve_s; });
  add("5_deform", [](const Tick& t) { return t.deform_s; });
  add("6_display", [](const Tick& t) { return t.display_s; });
  add("contact_thread", [](const Tick& t) { return t.contact_thread_s(); });
  add("slow_thread", [](const Tick& t) { return t.slow_thread_s(); });
  add("no_display", [](const Tick& t) { return t.total_s() - t.display_s; });
  add("total", [](const Tick& t) { return t.total_s(); });
  const auto residual = [](const Tick& t) { return t.solve.residual; };
  bench.counters["residual"] = 1e-6 * median_us(residual);
  bench.counters["worst_residual"] = residual(*std::max_element(
      ticks.begin(), ticks.end(), [&](const Tick& a, const Tick& b) { return residual(a) < residual(b); }));
  bench.counters["sweeps"] = 1e-6 * median_us([](const Tick& t) { return static_cast<double>(t.solve.sweeps); });
  if (bench.range(0) <= 60) bench.counters["published"] = published_us(bench.range(0));
}

void at_published_contacts(benchmark::internal::Benchmark* bench) {
  bench->Arg(15)->Arg(30)->Arg(60)->ArgName("contacts")->UseManualTime()->Unit(benchmark::kMicrosecond);
}
// The budget of a haptic loop, from the last tick's forces; and the scene's own, to its tolerance.
BENCHMARK_CAPTURE(contact_computation, ten_warm_sweeps, kWarmSweeps)->Apply(at_published_contacts)->Arg(120);
BENCHMARK_CAPTURE(contact_computation, solved, 1000)->Apply(at_published_contacts)->Arg(120);

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
