// The three small problems of a tick, on inputs recorded from the box grasp: time with the accuracy it was had at.

#include <benchmark/benchmark.h>

#include <algorithm>

#include "bench/recorded.h"
#include "solvers/gauss_seidel.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscle_forces.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kPublishedLcp_us = 40.0;  // Rougeron et al. 2006, Pentium IV 2.2 GHz.

// Grasp forces of three fingers, all included: from the contact geometry and W^d to the forces. With the scene's
// friction no constraint is active; with less the method has to pivot.
void BM_GraspForces(benchmark::State& bench) {
  const RecordedRun& run = recorded_run(60);
  GraspWorkspace work;
  VectorXd f(3 * kFingers);
  Eigen::MatrixXd G(6, 3 * kFingers);
  const auto problem_of = [&](std::size_t i) {
    GraspProblem problem = run.grasps[i].problem(FrictionCone::kPyramid);
    problem.friction = 0.01 * static_cast<double>(bench.range(0));
    return problem;
  };
  std::size_t i = 0;
  double pivots = 0.0;
  for (auto _ : bench) {
    i = (i + 1) % run.grasps.size();
    const GraspReport report = solve_grasp_forces(problem_of(i), work, f);
    benchmark::DoNotOptimize(f.data());
    pivots += report.pivots;
    if (report.status != GraspStatus::kOptimal) bench.SkipWithError("not optimal");
  }
  grasp_map(problem_of(i).contacts, problem_of(i).centre_m, G);
  bench.counters["wrench_residual"] = (G * f - problem_of(i).wrench).cwiseAbs().maxCoeff();
  bench.counters["pivots"] = pivots / static_cast<double>(bench.iterations());
  bench.counters["published_us"] = kPublishedLcp_us;
}
BENCHMARK(BM_GraspForces)->Arg(55)->Arg(20)->ArgName("friction_percent")->Unit(benchmark::kMicrosecond);

// 23 muscle forces for 12 joint torques.
void BM_MuscleForces(benchmark::State& bench) {
  const std::vector<MuscleFile>& problems = recorded_run(60).muscles;
  MuscleWorkspace work(problems.front().H.rows(), problems.front().H.cols());
  VectorXd f(problems.front().H.cols());
  double residual_Nm = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % problems.size();
    const MuscleReport report = solve_muscle_forces(problems[i].H, problems[i].tau, work, f);
    benchmark::DoNotOptimize(f.data());
    residual_Nm = std::max(residual_Nm, report.residual_Nm);
    if (report.status != MuscleStatus::kOptimal) bench.SkipWithError("not optimal");
  }
  bench.counters["residual_Nm"] = residual_Nm;
}
BENCHMARK(BM_MuscleForces)->Unit(benchmark::kMicrosecond);

// Contact forces to 1e-6, from nothing or from the last tick's.
void BM_SolveContacts(benchmark::State& bench) {
  const bool warm = bench.range(1) != 0;
  const auto& problems = recorded_run(bench.range(0)).contacts;
  VectorXd f(3 * bench.range(0)), delta(f.size());
  double residual = 0.0, sweeps = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % problems.size();
    const ContactFile& p = problems[i];
    if (warm) {
      f = p.f_last;
    } else {
      f.setZero();
    }
    const SolveReport report =
        solve_contacts(p.W, p.delta_free.front(), p.mu, {.tolerance = 1e-6, .max_sweeps = 2000}, f, delta);
    benchmark::DoNotOptimize(f.data());
    residual = std::max(residual, report.residual);
    sweeps += report.sweeps;
    if (report.status != SolveStatus::kConverged) bench.SkipWithError("did not converge");
  }
  bench.counters["worst_residual"] = residual;
  bench.counters["sweeps"] = sweeps / static_cast<double>(bench.iterations());
}
BENCHMARK(BM_SolveContacts)
    ->ArgsProduct({{15, 30, 60}, {0, 1}})
    ->ArgNames({"contacts", "warm"})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace thenar
