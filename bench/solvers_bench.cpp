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
  const bool by_lemke = bench.range(1) != 0;
  GraspWorkspace work;
  VectorXd f(3 * kFingers);
  Eigen::MatrixXd G(6, 3 * kFingers);
  const auto problem_of = [&](std::size_t i) {
    GraspProblem problem = grasp_problem(run.model.scene, run.ticks[i].control, run.ticks[i].state.X_WO.translation());
    problem.friction = 0.01 * static_cast<double>(bench.range(0));
    return problem;
  };
  std::size_t i = 0;
  double changes = 0.0, residual = 0.0;
  for (auto _ : bench) {
    i = (i + 1) % run.ticks.size();
    const GraspReport report =
        by_lemke ? solve_grasp_forces_by_lemke(problem_of(i), work, f) : solve_grasp_forces(problem_of(i), f);
    benchmark::DoNotOptimize(f.data());
    changes += report.iterations;
    residual = std::max(residual, report.residual);
    if (report.status != GraspStatus::kOptimal) bench.SkipWithError("not optimal");
  }
  grasp_map(problem_of(i).contacts, problem_of(i).centre_m, G);
  bench.counters["wrench_residual"] = (G * f - problem_of(i).wrench).cwiseAbs().maxCoeff();
  bench.counters["worst_residual"] = residual;
  bench.counters["changes"] = changes / static_cast<double>(bench.iterations());
  bench.counters["published_us"] = kPublishedLcp_us;
}
BENCHMARK(BM_GraspForces)
    ->ArgsProduct({{55, 20}, {0, 1}})
    ->ArgNames({"friction_percent", "lemke"})
    ->Unit(benchmark::kMicrosecond);

// 23 muscle forces for 12 joint torques.
void BM_MuscleForces(benchmark::State& bench) {
  const RecordedRun& run = recorded_run(60);
  const Hand& hand = run.model.scene.hand;
  const auto muscles = static_cast<Index>(hand.muscles.size());
  HandPose pose;
  forward_kinematics(hand, run.ticks.front().state.q, pose);
  Eigen::MatrixXd H(kJoints, muscles);
  moment_arms(hand, pose, H);
  std::vector<JointVector> torques;
  for (const auto& [state, controller, control] : run.ticks) {
    torques.push_back(desired_torques(run.model, pose, control.contacts, control.f_desired, FingerForces::Zero()));
  }
  MuscleWorkspace work(kJoints, muscles);
  VectorXd f(muscles);
  double residual_Nm = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % torques.size();
    const MuscleReport report = solve_muscle_forces(H, torques[i], work, f);
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
  const auto& problems = recorded_run(bench.range(0)).problems;
  VectorXd f(3 * bench.range(0)), delta(f.size());
  double residual = 0.0, sweeps = 0.0;
  std::size_t i = 0;
  for (auto _ : bench) {
    i = (i + 1) % problems.size();
    const RecordedContacts& p = problems[i];
    if (warm) {
      f = p.f_last;
    } else {
      f.setZero();
    }
    const SolveReport report =
        solve_contacts(p.W, p.delta_free, p.mu, {.tolerance = 1e-6, .max_sweeps = 2000}, f, delta);
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
