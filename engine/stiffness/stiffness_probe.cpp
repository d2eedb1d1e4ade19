// SPDX-License-Identifier: Apache-2.0
#include "engine/stiffness/stiffness_probe.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace thenar {

using Eigen::VectorXd;

namespace {

constexpr double kLever_m = 0.02;  // Arm that scales rotations to displacements, and moments to forces.
constexpr double kPush_s = 0.05, kSettle_s = 0.1;
constexpr double kRest_m = 1e-7;           // Probes move micrometres.
constexpr double kProbedTolerance = 0.01;  // Of the scene's tolerance.

/// Two runs of one grasp that are pushed in opposite ways.
struct Pair {
  Pair(const Model& model, const GraspRun& from) : plus(model), minus(model) {
    plus.go_on_as(from);
    minus.go_on_as(from);
  }

  void go_on(const Vector6d& wrench, double for_s) {
    const auto ticks = std::max<std::int64_t>(1, std::llround(for_s / plus.model.scene.step_s));
    const TickInput one_way{wrench, {}}, other_way{-wrench, {}};
    for (std::int64_t i = 0; i < ticks; ++i) {
      is_finite &= plus.tick(one_way).solve.status != SolveStatus::kNotFinite;
      is_finite &= minus.tick(other_way).solve.status != SolveStatus::kNotFinite;
    }
  }
  /// Returns half their difference, of the object about its origin, world axes.
  [[nodiscard]] Vector6d object() const { return 0.5 * pose_error(plus.state.X_WO, minus.state.X_WO); }
  /// Returns the common motion of both.
  [[nodiscard]] Vector6d drift(const Eigen::Isometry3d& since) const {
    return 0.5 * (pose_error(plus.state.X_WO, since) + pose_error(minus.state.X_WO, since));
  }
  /// Returns half the difference including the joints.
  [[nodiscard]] VectorXd all() const {
    VectorXd z(6 + plus.state.q.size());
    z << object(), 0.5 * (plus.state.q - minus.state.q);
    return z;
  }

  GraspRun plus, minus;
  bool is_finite = true;
};

/// Returns the model that probes run: with a share of its viscosities, and solved well beyond its own tolerance, for a
/// probe is 1e-4 N beside contact forces of newtons.
Model probed_model(const Model& of, double share) {
  Model model = of;
  model.scene.contact.tolerance *= kProbedTolerance;
  model.scene.joint_viscosity *= share;
  for (Fingertip& tip : model.scene.hand.fingertips) {
    if (tip.joint_viscosity) *tip.joint_viscosity *= share;
  }
  model.scene.object.translation_damping *= share;
  model.scene.object.rotation_damping *= share;
  return model;
}

/// The result of a probe.
struct Probed {
  Vector6d moved;
  double waited_s = 0.0, moving = 0.0, drift_m = 0.0;
  bool is_finite = true;
};

double length(const Vector6d& moved) { return std::hypot(moved.head<3>().norm(), kLever_m * moved.tail<3>().norm()); }

/// Returns the wait until, at a rate of `slowest_per_s`, less than settings.rest of the motion remains.
Probed probe(Pair& pair, const Vector6d& wrench, double slowest_per_s, const ProbeSettings& settings) {
  Probed done;
  const double wait_s = std::min(0.5 / slowest_per_s, 0.1 * settings.most_s);
  const double stays = std::exp(-slowest_per_s * wait_s);
  const Eigen::Isometry3d since = pair.plus.state.X_WO;
  double most_m = 0.0;
  do {
    const Vector6d before = pair.object();
    pair.go_on(wrench, wait_s);
    done.moved = pair.object();
    done.waited_s += wait_s;
    most_m = std::max(most_m, length(done.moved));
    done.moving = length(done.moved - before) * stays / (1.0 - stays) / most_m;
    done.is_finite = pair.is_finite;
    done.drift_m = length(pair.drift(since));
  } while (done.is_finite && done.moving > settings.rest && done.waited_s < settings.most_s - 0.5 * wait_s);
  return done;
}

}  // namespace

Rest let_rest(GraspAt& grasp, const ProbeSettings& settings) {
  const Model model = probed_model(grasp.model, settings.viscosity);
  GraspRun run(model);
  run.go_on_as(grasp.run);
  const double from_s = run.time_s();
  const Eigen::Isometry3d since = run.state.X_WO;
  const PredictedStiffness first = predict_stiffness(run);
  PredictedStiffness now = first;
  Rest rest;
  while (!rest.reached && now.contacts > 0 && now.is_stable() && run.time_s() < from_s + settings.most_s) {
    const double rate_per_s = now.slowest().rate_per_s;
    const double wait_s = std::min(0.5 / rate_per_s, 0.1 * settings.most_s), stays = std::exp(-rate_per_s * wait_s);
    const Eigen::Isometry3d X_WO = run.state.X_WO;
    const JointVector q = run.state.q;
    for (const double end_s = run.time_s() + wait_s; run.time_s() < end_s;) run.tick();
    const double moved_m =
        length(pose_error(run.state.X_WO, X_WO)) + kLever_m * (run.state.q - q).cwiseAbs().maxCoeff();
    rest.reached = moved_m * stays / (1.0 - stays) < kRest_m;
    now = predict_stiffness(run);
  }
  rest.moved_m = length(pose_error(run.state.X_WO, since));
  rest.changed = compliance_error(first.K_O.inverse(), now.K_O.inverse());
  grasp.run.go_on_as(run);
  return rest;
}

std::optional<MeasuredStiffness> probe_stiffness(const GraspAt& grasp, const PredictedStiffness& predicted,
                                                 const ProbeSettings& settings) {
  const bool frozen = grasp.model.scene.control->muscles->frozen_from_s.has_value();
  if (frozen && !predicted.is_stable()) return std::nullopt;
  const Model model = probed_model(grasp.model, frozen ? settings.viscosity : 1.0);
  ProbeSettings waiting = settings;
  if (!frozen) waiting.most_s = settings.law_s;
  const double slowest_per_s = frozen ? predicted.slowest().rate_per_s / settings.viscosity : 1.0 / settings.law_s;
  Matrix6d R = Matrix6d::Zero();
  R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = predicted.X_WO.linear();
  std::array<Probed, 6> probes;
  tbb::task_arena arena(settings.threads);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, 6, 1),
        [&](const tbb::blocked_range<int>& axes) {
          for (int axis = axes.begin(); axis < axes.end(); ++axis) {
            const double amount = axis < 3 ? settings.force_N : settings.moment_Nm;
            Pair pair(model, grasp.run);
            probes[axis] = probe(pair, amount * R.col(axis), slowest_per_s, waiting);
            probes[axis].moved = R.transpose() * probes[axis].moved / amount;
          }
        },
        tbb::simple_partitioner());
  });
  MeasuredStiffness all;
  for (int axis = 0; axis < 6; ++axis) {
    all.C_O.col(axis) = probes[axis].moved;
    all.waited_s = std::max(all.waited_s, probes[axis].waited_s);
    all.moving = std::max(all.moving, probes[axis].moving);
    all.drift_m = std::max(all.drift_m, probes[axis].drift_m);
    all.is_finite = all.is_finite && probes[axis].is_finite;
  }
  all.K_O = all.C_O.inverse();
  return all;
}

double measure_rate(const GraspAt& grasp, const GraspMode& mode, const ProbeSettings& settings) {
  Vector6d amounts;
  amounts << Eigen::Vector3d::Constant(settings.force_N), Eigen::Vector3d::Constant(settings.moment_Nm);
  const Vector6d pushed = amounts.cwiseProduct(mode.pushed_by);
  const double time_s = 1.0 / std::abs(mode.rate_per_s);
  Pair pair(grasp.model, grasp.run);
  pair.go_on(amounts.cwiseProduct(pushed.normalized()), std::min(kPush_s, 0.3 * time_s));
  pair.go_on(Vector6d::Zero(), std::min(kSettle_s, 0.3 * time_s));
  const auto amplitude = [&] { return std::abs((mode.measure.transpose() * pair.all()).value()); };
  const double before = amplitude(), from_s = pair.plus.time_s();
  pair.go_on(Vector6d::Zero(), std::min(time_s, settings.most_s));
  return std::log(before / amplitude()) / (pair.plus.time_s() - from_s);
}

StiffnessStudy study_stiffness(const Model& model, double at_s, Acting acting,
                               const std::optional<ProbeSettings>& settings) {
  GraspAt grasp(model, at_s, acting);
  StiffnessStudy study{grasp.run.time_s(), acting, predict_stiffness(grasp.run), {}, {}, {}, {}};
  if (study.predicted.contacts > 0) study.range = stiffness_range(grasp.run);
  if (!settings || study.predicted.contacts == 0) return study;
  if (acting == Acting::kMuscles) {
    study.rest = let_rest(grasp, *settings);
    study.predicted = predict_stiffness(grasp.run);
  }
  study.measured = probe_stiffness(grasp, study.predicted, *settings);
  if (acting == Acting::kMuscles) study.slowest_per_s = measure_rate(grasp, study.predicted.slowest(), *settings);
  return study;
}

}  // namespace thenar
