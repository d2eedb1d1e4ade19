// SPDX-License-Identifier: Apache-2.0
// Our solvers on the problems of the box grasp as recorded, and on problem files with known answers: time with the
// accuracy it was had at, cold and warm, for who tunes them. Names read problem kind / problems / method / start. Other
// settings, other projects and random problems are in the report (bench/report).
//
// Files come from the folder that the environment's THENAR_PROBLEMS names, with its folders `contact` and `small`;
// without it, from the tests'. A benchmark goes through its problems round and round: its time is their mean.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "bench/cases/recorded.h"
#include "bench/cases/stiff_problems.h"
#include "bench/methods/contact_methods.h"
#include "solvers/muscles/stiff_muscles.h"
#include "solvers/muscles/stiff_proof.h"
#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
namespace fs = std::filesystem;

constexpr double kPublishedGraspLcp_us = 40.0;  // Rougeron et al. 2006, Pentium IV 2.2 GHz.
constexpr double kTolerance = 1e-6;
constexpr int kMaxSweeps = 2000;

// --- Contact forces ------------------------------------------------------------------------------------------------

struct ContactCase {
  ContactData problem;
  VectorXd f_start;
};

/// The method's residual on each case, computed here; infinity where it has none.
void judge_contacts(const std::vector<ContactCase>& cases, const std::vector<ContactSolver>& solvers,
                    benchmark::State& bench) {
  double worst = 0.0, worst_contact = 0.0;
  int solved = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const ContactCase& c = cases[i];
    VectorXd f = c.f_start;
    solvers[i](kTolerance, kMaxSweeps, f);
    const Residual residual = natural_map(c.problem, f, c.problem.W * f + c.problem.delta_free);
    solved += residual.norm <= 1.001 * kTolerance ? 1 : 0;
    if (residual.norm > 1.001 * kTolerance) continue;
    worst = std::max(worst, residual.norm);
    worst_contact = std::max(worst_contact, residual.worst);
  }
  bench.counters["solved_percent"] = 100.0 * solved / static_cast<double>(cases.size());
  // Of those that are solved.
  bench.counters["worst_residual"] = worst;
  bench.counters["worst_contact"] = worst_contact;
}

void run_contacts(benchmark::State& bench, const std::vector<ContactCase>& cases, const ContactMethod& method) {
  std::vector<ContactSolver> solvers;
  for (const ContactCase& c : cases) solvers.push_back(method.prepare(c.problem));
  VectorXd f;
  std::size_t i = 0;
  for (auto _ : bench) {
    f = cases[i].f_start;
    solvers[i](kTolerance, kMaxSweeps, f);
    benchmark::DoNotOptimize(f.data());
    i = (i + 1) % cases.size();
  }
  judge_contacts(cases, solvers, bench);
}

void register_contacts(const std::string& problems, const std::string& start,
                       const std::shared_ptr<std::vector<ContactCase>>& cases) {
  for (const ContactMethod& method : our_contact_methods()) {
    const std::string name = "contact/" + problems + "/" + method.name + "/" + start;
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& bench) {
      run_contacts(bench, *cases, method);
    })->Unit(benchmark::kMicrosecond);
  }
}

void register_contacts() {
  for (const Index contacts : {15, 30, 60}) {
    auto cold = std::make_shared<std::vector<ContactCase>>(), warm = std::make_shared<std::vector<ContactCase>>();
    for (const ContactFile& p : recorded_run(contacts).contacts) {
      cold->push_back({{p.W, p.delta_free.front(), p.mu}, VectorXd::Zero(p.f_last.size())});
      warm->push_back({{p.W, p.delta_free.front(), p.mu}, p.f_last});
    }
    register_contacts("recorded_" + std::to_string(contacts), "cold", cold);
    register_contacts("recorded_" + std::to_string(contacts), "warm", warm);
  }
}

/// A file is one problem cold; if it has several steps, they are a sequence in which each starts from the last one's
/// forces.
void register_contact_file(const ContactFile& p) {
  auto cold = std::make_shared<std::vector<ContactCase>>();
  cold->push_back({{p.W, p.delta_free.front(), p.mu}, VectorXd::Zero(3 * p.contacts())});
  register_contacts(p.name, "cold", cold);
  if (p.delta_free.size() < 2) return;
  auto warm = std::make_shared<std::vector<ContactCase>>();
  AccurateWorkspace work(p.contacts());
  VectorXd f = VectorXd::Zero(3 * p.contacts()), delta(f.size());
  for (std::size_t step = 0; step < p.delta_free.size(); ++step) {
    if (step > 0) warm->push_back({{p.W, p.delta_free[step], p.mu}, f});
    (void)solve_contacts_accurately(p.problem(step), {}, work, {f, delta});
  }
  register_contacts(p.name, "warm", warm);
}

// --- Grasp forces --------------------------------------------------------------------------------------------------

struct GraspMethod {
  const char* name;
  FrictionCone cone;
  bool lemke;
};

constexpr std::array kGraspMethods{GraspMethod{"active_set", FrictionCone::kPyramid, false},
                                   GraspMethod{"lemke", FrictionCone::kPyramid, true},
                                   GraspMethod{"exact_cone", FrictionCone::kExact, false}};

void run_grasps(benchmark::State& bench, const std::vector<GraspData>& grasps, const GraspMethod& method) {
  GraspWorkspace work;
  VectorXd f(3 * kMaxGraspContacts);
  const auto solve = [&](const GraspProblem& problem) {
    auto f_used = f.head(3 * std::ssize(problem.contacts));
    return method.lemke ? solve_grasp_forces_by_lemke(problem, work, f_used) : solve_grasp_forces(problem, f_used);
  };
  std::size_t i = 0;
  for (auto _ : bench) {
    const GraspReport report = solve(grasps[i].problem(method.cone));
    benchmark::DoNotOptimize(report.status);
    benchmark::DoNotOptimize(f.data());
    i = (i + 1) % grasps.size();
  }
  int infeasible = 0, unanswered = 0;
  double worst = 0.0;
  for (const GraspData& grasp : grasps) {
    const GraspProblem problem = grasp.problem(method.cone);
    const GraspReport report = solve(problem);
    infeasible += report.status == GraspStatus::kInfeasible ? 1 : 0;
    unanswered += report.status == GraspStatus::kBudgetSpent ? 1 : 0;
    if (report.status != GraspStatus::kOptimal) continue;
    worst = std::max(worst, grasp_kkt_error(problem, report.multiplier, f.head(3 * std::ssize(grasp.contacts))));
  }
  bench.counters["infeasible_percent"] = 100.0 * infeasible / static_cast<double>(grasps.size());
  bench.counters["unanswered_percent"] = 100.0 * unanswered / static_cast<double>(grasps.size());
  bench.counters["worst_kkt_error"] = worst;
  bench.counters["published_us"] = kPublishedGraspLcp_us;
}

void register_grasps(const std::string& problems, const std::shared_ptr<std::vector<GraspData>>& grasps) {
  for (const GraspMethod& method : kGraspMethods) {
    const std::string name = "grasp/" + problems + "/" + method.name + "/cold";
    benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& bench) {
      run_grasps(bench, *grasps, method);
    })->Unit(benchmark::kMicrosecond);
  }
}

void register_grasps() {
  // With the scene's friction no constraint is active; with less the methods have to work.
  for (const double friction : {0.55, 0.2}) {
    auto grasps = std::make_shared<std::vector<GraspData>>();
    for (const GraspFile& file : recorded_run(60).grasps) {
      grasps->push_back(file);
      grasps->back().friction = friction;
    }
    register_grasps("recorded_friction_" + std::to_string(std::lround(100.0 * friction)), grasps);
  }
}

// --- Muscle forces -------------------------------------------------------------------------------------------------

void run_muscles(benchmark::State& bench, const std::vector<MuscleData>& problems, bool lemke) {
  const Index joints = problems.front().H.rows(), muscles = problems.front().H.cols();
  MuscleWorkspace work(joints, muscles);
  VectorXd f(muscles);
  const auto solve = [&](const MuscleProblem& p) {
    return lemke ? solve_muscle_forces_by_lemke(p, work, f) : solve_muscle_forces(p, f);
  };
  std::size_t i = 0;
  for (auto _ : bench) {
    const MuscleReport report = solve(problems[i]);
    benchmark::DoNotOptimize(report.status);
    benchmark::DoNotOptimize(f.data());
    i = (i + 1) % problems.size();
  }
  int infeasible = 0, unanswered = 0;
  double worst = 0.0;
  for (const MuscleData& p : problems) {
    const MuscleReport report = solve(p);
    infeasible += report.status == MuscleStatus::kInfeasible ? 1 : 0;
    unanswered += report.status == MuscleStatus::kBudgetSpent ? 1 : 0;
    if (report.status != MuscleStatus::kOptimal) continue;
    worst = std::max(worst, muscle_kkt_error(p, report.multiplier, f));
  }
  bench.counters["infeasible_percent"] = 100.0 * infeasible / static_cast<double>(problems.size());
  bench.counters["unanswered_percent"] = 100.0 * unanswered / static_cast<double>(problems.size());
  bench.counters["worst_kkt_error"] = worst;
}

void register_muscles(const std::string& name, const std::shared_ptr<std::vector<MuscleData>>& problems) {
  const auto add = [&](const char* method, bool lemke) {
    const std::string full = "muscle/" + name + "/" + method + "/cold";
    benchmark::RegisterBenchmark(full.c_str(), [=](benchmark::State& bench) {
      run_muscles(bench, *problems, lemke);
    })->Unit(benchmark::kMicrosecond);
  };
  add("active_set", false);
  add("lemke", true);
}

void register_muscles() {
  auto recorded = std::make_shared<std::vector<MuscleData>>();
  for (const MuscleFile& file : recorded_run(60).muscles) recorded->push_back(file);
  register_muscles("recorded", recorded);
}

// --- Muscle forces under an object stiffness ------------------------------------------------------------------------

/// Periods of a loop whose torques drift by a thousandth each, of hands that are drawn.
std::vector<StiffMuscleData> drifting_problems(bool has_tendons, bool has_squeeze) {
  constexpr int kHands = 10, kPeriods = 40;
  std::vector<StiffMuscleData> problems;
  StiffDraw draw;
  draw.has_tendons = has_tendons;
  draw.has_squeeze = has_squeeze;
  VectorXd f(draw.muscles);
  for (std::uint64_t seed = 1000; std::ssize(problems) < kHands * kPeriods; ++seed) {
    draw.draw(seed);
    draw.want(1.0);
    const StiffMuscleReport report = solve_stiff_muscles(draw.problem, f);
    if (report.status != MuscleStatus::kOptimal || report.Z.isZero(0.0)) continue;
    for (int period = 0; period < kPeriods; ++period) {
      problems.push_back(draw.problem);
      problems.back().tau *= 1.0 + 1e-3 * std::abs(period - kPeriods / 2);
    }
  }
  return problems;
}

void run_stiff_muscles(benchmark::State& bench, const std::vector<StiffMuscleData>& problems, bool warm) {
  VectorXd f(problems.front().H.cols());
  StiffWarmStart last;
  const auto solve = [&](const StiffMuscleProblem& p) {
    return warm ? solve_stiff_muscles(p, last, f) : solve_stiff_muscles(p, f);
  };
  std::size_t i = 0;
  for (auto _ : bench) {
    const StiffMuscleReport report = solve(problems[i]);
    benchmark::DoNotOptimize(report.status);
    benchmark::DoNotOptimize(f.data());
    i = (i + 1) % problems.size();
  }
  int unanswered = 0;
  double worst = 0.0, steps = 0.0;
  std::vector<double> times_us;
  for (const StiffMuscleData& p : problems) {
    const auto start = std::chrono::steady_clock::now();
    const StiffMuscleReport report = solve(p);
    times_us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    unanswered += report.status == MuscleStatus::kOptimal ? 0 : 1;
    steps += report.iterations;
    if (report.status == MuscleStatus::kOptimal) worst = std::max(worst, stiff_kkt_error(p, f, report));
  }
  std::sort(times_us.begin(), times_us.end());
  bench.counters["median_us"] = times_us[times_us.size() / 2];
  bench.counters["steps"] = steps / static_cast<double>(problems.size());
  bench.counters["unanswered_percent"] = 100.0 * unanswered / static_cast<double>(problems.size());
  bench.counters["worst_kkt_error"] = worst;
}

void register_stiff_muscles() {
  const auto add = [](const std::string& name, bool has_tendons, bool has_squeeze) {
    const auto problems = std::make_shared<std::vector<StiffMuscleData>>(drifting_problems(has_tendons, has_squeeze));
    for (const bool warm : {false, true}) {
      const std::string full = "stiff_muscle/" + name + "/newton/" + (warm ? "warm" : "cold");
      benchmark::RegisterBenchmark(full.c_str(), [=](benchmark::State& bench) {
        run_stiff_muscles(bench, *problems, warm);
      })->Unit(benchmark::kMicrosecond);
    }
  };
  add("drawn", false, false);
  add("drawn_tendons", true, false);
  add("drawn_tendons_squeeze", true, true);
}

// --- Linear complementarity problems -------------------------------------------------------------------------------

void register_lcp(const LcpFile& file) {
  const auto problem = std::make_shared<LcpFile>(file);
  benchmark::RegisterBenchmark(("lcp/" + file.name + "/lemke/cold").c_str(), [=](benchmark::State& bench) {
    LcpWorkspace work(problem->q.size());
    VectorXd z(problem->q.size());
    LcpReport report;
    for (auto _ : bench) {
      report = solve_lcp(*problem, usual_pivot_budget(problem->q.size()), work, z);
      benchmark::DoNotOptimize(z.data());
    }
    bench.counters["pivots"] = report.pivots;
    bench.counters["worst_complementarity"] = (problem->M * z + problem->q).cwiseMin(z).cwiseAbs().maxCoeff();
    if (report.status == LcpStatus::kBudgetSpent) bench.SkipWithError("no answer");
  })->Unit(benchmark::kMicrosecond);
}

// --- Files ---------------------------------------------------------------------------------------------------------

void register_files() {
  const char* const asked = std::getenv("THENAR_PROBLEMS");
  std::vector<fs::path> files;
  for (const char* folder : {"contact", "small"}) {
    for (const auto& entry : fs::directory_iterator(fs::path(asked ? asked : THENAR_TEST_DATA) / folder)) {
      if (entry.path().extension() == ".fcp" || entry.path().extension() == ".json") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const ProblemFile problem = read_problem(file);
    if (const auto* contacts = std::get_if<ContactFile>(&problem)) register_contact_file(*contacts);
    if (const auto* grasp = std::get_if<GraspFile>(&problem)) {
      register_grasps(grasp->name, std::make_shared<std::vector<GraspData>>(1, *grasp));
    }
    if (const auto* muscle = std::get_if<MuscleFile>(&problem)) {
      register_muscles(muscle->name, std::make_shared<std::vector<MuscleData>>(1, *muscle));
    }
    if (const auto* lcp = std::get_if<LcpFile>(&problem)) register_lcp(*lcp);
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  thenar::register_contacts();
  thenar::register_grasps();
  thenar::register_muscles();
  thenar::register_stiff_muscles();
  thenar::register_files();
  benchmark::RunSpecifiedBenchmarks();
}
