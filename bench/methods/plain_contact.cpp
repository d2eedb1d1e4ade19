// SPDX-License-Identifier: Apache-2.0
#include "bench/methods/plain_contact.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/grasp/compliance.h"
#include "engine/grasp/delassus.h"
#include "engine/grasp/handover.h"
#include "engine/results/recorder.h"
#include "solvers/gauss_seidel.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Springs of the control points of a pulp [N/m], normal and tangential.
struct Springs {
  explicit Springs(const Pulp& pulp)
      : normal_N_per_m(4.0 * pulp.material.reduced_modulus_Pa * std::sqrt(8.0) /
                       (3.0 * std::numbers::pi * pulp.radius_m) * pulp.area_m2),
        tangential_N_per_m(normal_N_per_m / pulp.tangential),
        stretch_m(Eigen::Matrix2Xd::Zero(2, pulp.controls())) {}

  VectorXd normal_N_per_m, tangential_N_per_m;
  Eigen::Matrix2Xd stretch_m;  ///< Of the tangential ones, contact rows; zero where nothing touches.
};

/// Projected Gauss-Seidel with each tangential row in an interval of its own.
SolveReport solve_box_friction(const ContactProblem& problem, const GaussSeidelSettings& settings,
                               ContactSolution solution) {
  Eigen::Ref<VectorXd>&f = solution.f, &delta = solution.delta;
  SolveReport report{SolveStatus::kBudgetSpent};
  delta = problem.delta_free + problem.W * f;
  while (report.sweeps < settings.max_sweeps && report.status == SolveStatus::kBudgetSpent) {
    double squared_change = 0.0;
    for (Index row = 0; row < f.size(); ++row) {
      const double limit = problem.mu[row / 3] * f[row - row % 3];
      const double step = f[row] - delta[row] / problem.W(row, row);
      const double change = (row % 3 == 0 ? std::max(0.0, step) : std::clamp(step, -limit, limit)) - f[row];
      if (change == 0.0) continue;
      f[row] += change;
      delta += change * problem.W.col(row);
      squared_change += change * change;
    }
    ++report.sweeps;
    report.residual = std::sqrt(squared_change) / std::max(f.norm(), std::numeric_limits<double>::min());
    if (report.residual <= settings.tolerance) report.status = SolveStatus::kConverged;
  }
  return f.allFinite() ? report : not_finite(report.sweeps);
}

class PlainTick {
 public:
  PlainTick(const Model& model, const PlainContact& plain)
      : model_(model),
        plain_(plain),
        operator_model_(model),
        now_(model),
        motion_(model.max_contacts, model.fingers()),
        loads_(model),
        patches_(model),
        carried_(3 * model.max_contacts) {
    if (plain.law == ContactLaw::kWrongStep) operator_model_.scene.step_s = plain.operator_step_s;
    for (const Pulp& pulp : model.pulps) springs_.emplace_back(pulp);
  }

  TickReport tick(const Frame& frame, State& state);
  [[nodiscard]] std::function<double(const Scene&)> penalty_limit(const Frame& frame) const;

 private:
  [[nodiscard]] VectorXd free_gaps_and_slips(const Frame& frame, const State& state, const JointVector& dq,
                                             const Vector6d& dx) const;
  SolveReport solve(const Frame& frame, const State& state, const JointVector& dq, const Vector6d& dx);
  void press_springs(const Frame& frame);
  void stretch_springs(const Frame& frame, const JointVector& dq, const Vector6d& dx);
  void take_stock(const Frame& frame, State& state, TickReport& report) const;
  [[nodiscard]] Vector3d motion_at(Index i, int finger, const JointVector& dq, const Vector6d& dx) const;

  const Model& model_;
  PlainContact plain_;
  Model operator_model_;  ///< Whose step W is made for.
  ContactKinematics now_;
  GroupedWorkspace motion_;
  PulpLoads loads_;
  PatchPoints patches_;
  HandPose pose_;
  std::vector<Springs> springs_;
  VectorXd carried_, f_, delta_;  ///< delta_: of penalty springs, what has slid.
  std::int64_t sequence_ = -1;
};

/// How the bodies' motion changes the gap and slip of contact i.
Vector3d PlainTick::motion_at(Index i, int finger, const JointVector& dq, const Vector6d& dx) const {
  const FingerVector own = model_.scene.hand.of_finger(finger, dq);
  Vector3d motion = now_.J_finger.middleRows<3>(3 * i) * own.head<4>();
  if (own.size() > 4) motion += own[4] * now_.J_fifth.segment<3>(3 * i);
  return motion + now_.J_object.middleRows<3>(3 * i).leftCols<6>() * dx;
}

VectorXd PlainTick::free_gaps_and_slips(const Frame& frame, const State& state, const JointVector& dq,
                                        const Vector6d& dx) const {
  VectorXd delta_free(3 * frame.size());
  const double rho = retained_share(model_.pulps.front().material, model_.scene.step_s);
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    Vector3d delta = motion_at(i, contact.finger, dq, dx);
    delta -= (1.0 - rho) * (now_.E_F[i].transpose() * displacement(state, contact));
    delta[0] += now_.gap_m[i];
    delta_free.segment<3>(3 * i) = delta;
  }
  return delta_free;
}

SolveReport PlainTick::solve(const Frame& frame, const State& state, const JointVector& dq, const Vector6d& dx) {
  const ContactSettings& contact = model_.scene.contact;
  const ContactData problem{dense_delassus(operator_model_, frame, now_, mobility(operator_model_.scene)),
                            free_gaps_and_slips(frame, state, dq, dx),
                            VectorXd::Constant(frame.size(), contact.friction)};
  const GaussSeidelSettings settings{contact.tolerance, contact.max_sweeps};
  delta_.resize(problem.delta_free.size());
  if (plain_.law == ContactLaw::kBoxFriction) return solve_box_friction(problem, settings, {f_, delta_});
  return solve_contacts(problem, settings, {f_, delta_});
}

/// Penalty forces at the start of the tick; what exceeds friction slides.
void PlainTick::press_springs(const Frame& frame) {
  delta_.setZero(3 * frame.size());
  for (Index i = 0; i < frame.size(); ++i) {
    const auto& [finger, point] = std::tie(frame.contacts[i].finger, frame.contacts[i].control_point);
    Springs& springs = springs_[finger];
    auto stretch = springs.stretch_m.col(point);
    const double f_n = std::max(0.0, -springs.normal_N_per_m[point] * now_.gap_m[i]);
    const Vector2d trial = -springs.tangential_N_per_m[point] * stretch;
    const double limit = model_.scene.contact.friction * f_n;
    const double kept = trial.norm() > limit ? limit / trial.norm() : 1.0;
    if (f_n > 0.0) delta_.segment<2>(3 * i + 1) = (1.0 - kept) * stretch;
    stretch *= kept;
    f_.segment<3>(3 * i) << f_n, kept * trial;
  }
}

void PlainTick::stretch_springs(const Frame& frame, const JointVector& dq, const Vector6d& dx) {
  for (Index i = 0; i < frame.size(); ++i) {
    if (f_[3 * i] <= 0.0) continue;
    const FrameContact& contact = frame.contacts[i];
    springs_[contact.finger].stretch_m.col(contact.control_point) += motion_at(i, contact.finger, dq, dx).tail<2>();
  }
}

void PlainTick::take_stock(const Frame& frame, State& state, TickReport& report) const {
  report.contacts = frame.size();
  state.forces.clear();
  for (int k = 0; k < model_.fingers(); ++k) {
    FingerLoad load;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const Vector3d f = f_.segment<3>(3 * i);
      state.forces.push_back({k, frame.contacts[i].control_point, f});
      if (f[0] <= 0.0) continue;
      load.force_N += now_.E_W[i] * f;
      load.normal_N += f[0];
      load.centre_m += f[0] * now_.c_W[i];
      load.normal += f[0] * now_.E_W[i].col(0);
      ++report.active;
    }
    if (load.normal_N > 0.0) {
      load.centre_m /= load.normal_N;
      load.normal.normalize();
    }
    state.load[k] = load;
  }
}

TickReport PlainTick::tick(const Frame& frame, State& state) {
  const Mobility m = mobility(model_.scene);
  forward_kinematics(model_.scene.hand, state.q, pose_);
  contact_kinematics(model_, frame, pose_, state, now_);
  TickReport report(model_.scene.hand);
  report.sequence = frame.sequence;
  report.frame_age = state.tick - frame.tick;
  if (frame.sequence != sequence_) {
    carry_forces(model_, frame, state.forces, carried_);
    f_ = carried_.head(3 * frame.size());
    sequence_ = frame.sequence;
  }
  JointVector dq = m.joint * frame.torque_Nm;
  Vector6d dx;
  dx << m.translation * frame.wrench.head<3>(), m.rotation * frame.wrench.tail<3>();
  const bool penalty = plain_.law == ContactLaw::kPenalty;
  if (penalty) {
    press_springs(frame);
  } else {
    report.solve = solve(frame, state, dq, dx);
  }
  find_motion(delassus_operator(model_, frame, now_, m), f_, motion_);
  add_joint_motion(model_.scene.hand, m, motion_, dq);
  dx += motion_.common_motion.head<6>();
  ++state.tick;
  if (!dq.allFinite() || !dx.allFinite()) {
    report.solve = not_finite(report.solve.sweeps);
    return report;
  }
  if (penalty) stretch_springs(frame, dq, dx);
  state.q += dq;
  state.X_WO.translation() += dx.head<3>();
  const Vector3d turn = dx.tail<3>();
  state.X_WO.linear() = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) * state.X_WO.linear();
  take_stock(frame, state, report);
  for (int k = 0; k < model_.fingers() && !penalty; ++k)
    deform(model_, frame, now_, k, f_, motion_.surface_motion, loads_, state);
  forward_kinematics(model_.scene.hand, state.q, pose_);
  find_displacements(model_, frame, now_, pose_, state, f_, patches_);
  for (int k = 0; k < model_.fingers(); ++k) {
    report.patch[k] =
        patch_report(patches_.of_finger(k), state.load[k], model_.scene.contact.friction, model_.scene.step_s);
  }
  return report;
}

std::function<double(const Scene&)> PlainTick::penalty_limit(const Frame& frame) const {
  const Index n = 3 * frame.size();
  VectorXd root_k = VectorXd::Zero(n);  // sqrt(K) of what is pressed
  for (Index i = 0; i < frame.size(); ++i) {
    if (f_[3 * i] <= 0.0) continue;
    const Springs& springs = springs_[frame.contacts[i].finger];
    const Index point = frame.contacts[i].control_point;
    const double tangential = std::sqrt(springs.tangential_N_per_m[point]);
    root_k.segment<3>(3 * i) << std::sqrt(springs.normal_N_per_m[point]), tangential, tangential;
  }
  // K J_c B^-1 J_c' of one body at a time, for unit mobilities: joints, the object's translation and rotation.
  std::array<MatrixXd, 3> parts;
  for (int part = 0; part < 3; ++part) {
    GroupedDelassus body =
        delassus_operator(model_, frame, now_, {part == 0 ? 1.0 : 0.0, part == 1 ? 1.0 : 0.0, part == 2 ? 1.0 : 0.0});
    body.compliance = {};
    MatrixXd W(n, n);
    body.to_dense(W);
    parts[part] = root_k.asDiagonal() * W * root_k.asDiagonal();
  }
  return [parts, pressed = !root_k.isZero()](const Scene& scene) {
    if (!pressed) return std::numeric_limits<double>::quiet_NaN();
    const MatrixXd rate = parts[0] / scene.joint_viscosity + parts[1] / scene.object.translation_damping +
                          parts[2] / scene.object.rotation_damping;
    return 2.0 / Eigen::SelfAdjointEigenSolver<MatrixXd>(rate, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  };
}

/// With room for every control point that may touch where contacts are springs.
Model with_room(const Model& model, const PlainContact& plain) {
  Model own = model;
  if (plain.law != ContactLaw::kPenalty) return own;
  own.scene.contact.max_per_finger = std::max<Index>(model.scene.contact.max_per_finger, 100);
  own.max_contacts = model.fingers() * std::min(own.scene.contact.max_per_finger, model.pulps.front().controls());
  return own;
}

/// run_scene's loop; `frame` and `tick` are left as it ended.
Recording run(const Model& model, PlainTick& tick, Frame& frame) {
  State state(model);
  Controller controller(model);
  ControlReport control;
  Recorder recorder(model);
  for (bool held = true; state.tick < recorder.planned() && held;) {
    const double time_s = static_cast<double>(state.tick) * model.scene.step_s;
    const bool controlled = model.control_is_due(state.tick);
    if (controlled) {
      control = control_tick(model, state, controller, frame);
      if (!recorder.see_control(ControlTick{time_s, control, controller.f_muscle})) break;
    }
    const TickReport contact = tick.tick(frame, state);
    held = recorder.see_tick(Tick{state, contact, control, controller.f_muscle, controlled});
  }
  return recorder.finish(state, control, 0.0);
}

}  // namespace

Recording run_plain(const Model& model, const PlainContact& plain) {
  const Model own = with_room(model, plain);
  PlainTick tick(own, plain);
  Frame frame(own);
  return run(own, tick, frame);
}

std::function<double(const Scene&)> penalty_step_limit(const Model& model, double step_s, double duration_s) {
  Model own = with_room(model, {});
  own.scene.step_s = own.scene.control_period_s = step_s;
  own.scene.duration_s = duration_s;
  PlainTick tick(own, {});
  Frame frame(own);
  // Springs that close at the start ask much of muscles for some ticks.
  if (run(own, tick, frame).verdict.outcome > Outcome::kOverLimits) {
    return [](const Scene&) { return std::numeric_limits<double>::quiet_NaN(); };
  }
  return tick.penalty_limit(frame);
}

}  // namespace thenar
