// The contact computation of the paper's timing table, stage by stage, on states recorded from the box grasp: contact
// finding, Delassus operator, Gauss-Seidel, deformation of the control points, interpolation at 3 x 2400 samples.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench/recorded.h"
#include "engine/stopwatch.h"
#include "engine/surface_display.h"

namespace thenar {
namespace {

struct StageTimes {
  double find_s, assemble_s, solve_s, deform_s, interpolate_s;
};

enum Stage { kFind, kAssemble, kSolve, kDeform, kInterpolate, kTotal };

double time_of(Stage stage, const StageTimes& t) {
  switch (stage) {
    case kFind:
      return t.find_s;
    case kAssemble:
      return t.assemble_s;
    case kSolve:
      return t.solve_s;
    case kDeform:
      return t.deform_s;
    case kInterpolate:
      return t.interpolate_s;
    case kTotal:
      break;
  }
  return t.find_s + t.assemble_s + t.solve_s + t.deform_s + t.interpolate_s;
}

// Rougeron et al. 2006, Pentium IV 2.2 GHz.
double published_us(long contacts) { return contacts <= 15 ? 6000.0 : contacts <= 30 ? 10000.0 : 20000.0; }

/// Every iteration does a whole contact computation on the next recorded state, and counts one stage of it.
void contact_computation(benchmark::State& bench, Stage stage) {
  const RecordedRun& run = recorded_run(bench.range(0));
  Frame frame(run.model);
  Controller controller(run.model);
  ContactWorkspace work(run.model);
  std::vector<SurfaceDisplay> displays(run.model.pulps.begin(), run.model.pulps.end());
  State state = run.states.front();
  double residual = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % run.states.size();
    state = run.states[i];
    const ControlReport control = control_tick(run.model, state, controller, frame);
    const TickReport tick = contact_tick(run.model, frame, work, state);
    Stopwatch watch;
    for (std::size_t k = 0; k < displays.size(); ++k)
      benchmark::DoNotOptimize(displays[k].displace(state.u_m[k]).data());
    bench.SetIterationTime(time_of(
        stage, {control.find_s, control.factors_s + tick.assemble_s, tick.solve_s, tick.deform_s, watch.lap()}));
    residual = std::max(residual, tick.solve.residual);
    if (tick.solve.status != SolveStatus::kConverged) bench.SkipWithError("did not converge");
  }
  bench.counters["worst_residual"] = residual;
  if (stage == kTotal) bench.counters["published_us"] = published_us(bench.range(0));
}

#define STAGE(name)                                     \
  BENCHMARK_CAPTURE(contact_computation, name, k##name) \
      ->Arg(15)                                         \
      ->Arg(30)                                         \
      ->Arg(60)                                         \
      ->ArgName("contacts")                             \
      ->UseManualTime()                                 \
      ->Unit(benchmark::kMicrosecond)
STAGE(Find);
STAGE(Assemble);
STAGE(Solve);
STAGE(Deform);
STAGE(Interpolate);
STAGE(Total);

}  // namespace
}  // namespace thenar
