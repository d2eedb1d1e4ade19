// SPDX-License-Identifier: Apache-2.0
#include "engine/stiffness/stiffness_range.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "engine/stiffness/object_stiffness.h"

namespace thenar {

using Eigen::VectorXd;

namespace {

constexpr double kSettled_s = 0.3;
constexpr double kAccurate = 1e-6;  // Accuracy of the largest multiple: forces still rise steeply before it.
constexpr std::array kBeyond{1e-4, 1e-3, 1e-2};  // Excess, the first of which there is a proof.
constexpr double kAtLimit = 0.99;
constexpr int kFrontPoints = 15;
// Reference stiffness of a scene without demand.
constexpr double kUsual_N_per_m = 100.0;

/// Returns the first multiple that the contacts alone exclude: clamped joints give A, the largest stiffness.
double never(const StiffGrasp& grasp, const Matrix6d& K) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 6; ++i) {
    if (K(i, i) > 0.0) least = std::min(least, grasp.problem.A(i, i) / K(i, i));
  }
  return least;
}

/// Finds the limit of K_des, which is beyond a range. Proofs are of planes near the end or far beyond it, and may name
/// muscles that are not at their limits at the end itself, with the forces `most`: these are left out.
StiffnessReport lack_of(const StiffGrasp& grasp, const Matrix6d& K_des, const std::optional<StiffForces>& most) {
  StiffMuscleData data = grasp.problem;
  data.K_des = K_des;
  const StiffMuscleProblem problem = data;
  VectorXd f(data.limit.size());
  StiffnessReport report;
  const StiffMuscleReport found = solve_stiff_muscles(problem, f);
  report.is_infeasible = found.status == MuscleStatus::kInfeasible;
  if (report.is_infeasible) {
    tell_lack(find_stiff_lack(problem), found.cause, problem.length_m, Matrix6d::Zero(), grasp.X_WO, report);
  }
  for (Eigen::Index m = 0; most && m < most->forces_N.size(); ++m) {
    const bool is_there = most->forces_N[m] >= kAtLimit * grasp.problem.limit[m];
    if (!is_there) report.at_limit &= ~(std::uint64_t{1} << m);
  }
  return report;
}

std::vector<StiffForces> front_of(const StiffGrasp& grasp, const StiffForces& last) {
  std::vector<StiffForces> front;
  for (int i = 0; i + 1 < kFrontPoints; ++i) {
    if (auto forces = stiff_forces(grasp, grasp.K_scene, last.asked * i / (kFrontPoints - 1.0))) {
      front.push_back(std::move(*forces));
    }
  }
  front.push_back(last);
  return front;
}

bool all_bear_load(const GraspRun& run) {
  return std::ranges::all_of(run.state.load, [](const FingerLoad& load) { return load.normal_N > 0.0; });
}

}  // namespace

StiffGrasp::StiffGrasp(const GraspRun& run) : problem(stiff_problem(run.model.scene)), X_WO(run.state.X_WO) {
  const Model& model = run.model;
  const Hand& hand = model.scene.hand;
  const SeenRun seen(run);
  std::vector<ContactPlace> places;
  places_of(seen.at.frame, seen.pose, hand, places);
  set_grasp(hand, seen.at.frame.bellies, seen.grasp(places), problem);
  problem.tau = muscle_torques(hand, seen.at.frame.bellies, seen.at.state.muscle_N);
  const auto& asked = model.scene.control->muscles->object_stiffness;
  centre_m = asked ? asked->centre_m : Eigen::Vector3d::Zero();
  asks = asked && asked->translation_N_per_m.maxCoeff() + asked->rotation_Nm_per_rad.maxCoeff() > 0.0;
  const double arm_m = problem.length_m;
  K_scene = asks ? wanted_stiffness(*asked, X_WO) : wanted(kUsual_N_per_m, kUsual_N_per_m * arm_m * arm_m);
}

Matrix6d StiffGrasp::wanted(double translation_N_per_m, double rotation_Nm_per_rad) const {
  ObjectStiffness all;
  all.translation_N_per_m.setConstant(translation_N_per_m);
  all.rotation_Nm_per_rad.setConstant(rotation_Nm_per_rad);
  all.centre_m = centre_m;
  return wanted_stiffness(all, X_WO);
}

bool StiffForces::is_stable() const {
  return K_object && Eigen::LLT<Matrix6d>(0.5 * (*K_object + K_object->transpose())).info() == Eigen::Success;
}

StiffForces with_stiffness(const StiffGrasp& grasp, VectorXd forces_N, double asked) {
  StiffForces found{asked, std::move(forces_N), std::nullopt};
  Matrix6d K;
  if (object_stiffness(grasp.problem, found.forces_N, 0.0, K)) found.K_object = K;
  return found;
}

std::optional<StiffForces> stiff_forces(const StiffGrasp& grasp, const Matrix6d& K, double asked) {
  StiffMuscleData data = grasp.problem;
  data.K_des = asked * K;
  const StiffMuscleProblem problem = data;
  VectorXd f(data.limit.size());
  if (solve_stiff_muscles(problem, f).status != MuscleStatus::kOptimal) return std::nullopt;
  return with_stiffness(grasp, std::move(f), asked);
}

std::optional<StiffForces> least_forces(const StiffGrasp& grasp) {
  const StiffMuscleProblem problem = grasp.problem;
  VectorXd f(problem.limit.size());
  const MuscleProblem alone{problem.H, problem.tau, problem.limit};
  if (solve_muscle_forces(alone, f).status != MuscleStatus::kOptimal) return std::nullopt;
  return with_stiffness(grasp, std::move(f));
}

StiffEnd stiff_end(const StiffGrasp& grasp, const Matrix6d& K) {
  StiffEnd end;
  end.most = stiff_forces(grasp, K, 0.0);
  if (!end.most) {
    end.beyond = lack_of(grasp, Matrix6d::Zero(), std::nullopt);
    return end;
  }
  double low = 0.0, high = never(grasp, K);
  while (high - low > kAccurate * high) {
    const double middle = 0.5 * (low + high);
    if (auto forces = stiff_forces(grasp, K, middle)) {
      end.most = std::move(forces);
      low = middle;
    } else {
      high = middle;
    }
  }
  for (const double beyond : kBeyond) {
    end.beyond = lack_of(grasp, (1.0 + beyond) * high * K, end.most);
    if (end.beyond.is_infeasible) break;
  }
  end.near = stiff_forces(grasp, K, kNearEnd * end.most->asked);
  if (!end.near) end.near = end.most;  // They exist, but were not found.
  return end;
}

std::optional<StiffnessRange> stiffness_range(const GraspRun& run) {
  if (!all_bear_load(run)) return std::nullopt;
  const StiffGrasp grasp(run);
  StiffnessRange range;
  range.at_s = run.time_s();
  range.asks = grasp.asks;
  range.least = least_forces(grasp);
  range.translation = stiff_end(grasp, grasp.wanted(1.0, 0.0));
  range.rotation = stiff_end(grasp, grasp.wanted(0.0, 1.0));
  range.scene = stiff_end(grasp, grasp.K_scene);
  if (range.scene.near) range.front = front_of(grasp, *range.scene.near);
  if (range.asks && !(range.scene.most && range.scene.most->asked >= 1.0)) {
    range.lack = lack_of(grasp, grasp.K_scene, range.scene.most);
  }
  return range;
}

std::optional<StiffnessRange> settled_stiffness_range(const Model& model) {
  const Scene& scene = model.scene;
  if (!scene.has_muscles() || !scene.control->muscles->short_range || scene.object.compliance) return std::nullopt;
  GraspRun run(model);
  const double end_s = scene.duration_s - 0.5 * scene.step_s;
  while (run.time_s() < end_s && (run.time_s() < kSettled_s - 0.5 * scene.step_s || !all_bear_load(run))) run.tick();
  return stiffness_range(run);
}

}  // namespace thenar
