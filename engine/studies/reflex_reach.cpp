// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/reflex_reach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/control/control_tick.h"
#include "engine/control/controller.h"
#include "engine/pulps/pressed_pulp.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

constexpr double kRest_s = 1.0;    // Time until a grip has built up and is regulated.
constexpr double kAnswer_s = 1.0;  // Time until a slip has been caught or is lost.
constexpr double kRimSlips = 0.1;  // Share of the limit from which on a rim slips.
constexpr int kHalvings = 12;

/// The scene's own control tick on reduced mechanics along one line: a viscous object and viscous fingers, friction
/// between them, and normal forces that follow their commands with a lag.
class LineModel {
 public:
  LineModel(const Model& model, const Vector3d& down)
      : model_(model), state_(model), frame_(model), controller_(model), down_(down), normal_N_(model.fingers()) {
    HandPose pose;
    const Scene& scene = model.scene;
    forward_kinematics(scene.hand, state_.q, pose);
    for (int k = 0; k < model.fingers(); ++k) {
      const GraspContact contact = finger_contact(model, pose, state_, k);
      const Vector3d normal = contact.axes.col(0);
      const Eigen::Matrix3d yields = damped(squared(finger_jacobian(scene.hand, pose, k, contact.point_m)));
      drag_ += scene.viscosity(k) * down.dot(yields.inverse() * down);
      press_drag_.push_back(scene.viscosity(k) / normal.dot(yields * normal));
      aside_.push_back(-normal.dot(yields * down) / normal.dot(yields * normal));
      state_.load[k] = {.centre_m = contact.point_m, .normal = normal};
    }
  }

  /// Runs one control period under a load besides the weight.
  void step(double friction, double load_N) {
    const Scene& scene = model_.scene;
    state_.tick = std::llround((time_s_ += scene.control_period_s) / scene.step_s);
    const ControlReport report = control_tick(model_, state_, controller_, frame_);
    answered_ = answered_ || report.reflex.event != ReflexEvent::kNone;
    double pressing_N = 0.0, wanted_N = 0.0;
    for (int k = 0; k < model_.fingers(); ++k) {
      const double lifting_N = -report.f_desired.col(k).dot(down_);
      const double settles_N = report.f_desired.col(k).dot(state_.load[k].normal) +
                               aside_[k] * (lifting_N + state_.load[k].force_N.dot(down_));
      normal_N_[k] = std::max(0.0, normal_N_[k] + follow(k) * (settles_N - normal_N_[k]));
      pressing_N += normal_N_[k];
      wanted_N += lifting_N;
    }
    if (!(pressing_N > 0.0)) {
      slip_m_ = std::numeric_limits<double>::infinity();
      return;
    }
    const double b = scene.object.translation_damping, dt_s = scene.control_period_s;
    const double acting_N = scene.object.mass_kg * scene.gravity.dot(down_) + load_N, most_N = friction * pressing_N;
    const double together_m_per_s = (acting_N - wanted_N) / (b + drag_);
    const double carried_N = std::min(acting_N - b * together_m_per_s, most_N);
    const bool slides = carried_N >= most_N;
    const double object_m_per_s = slides ? (acting_N - most_N) / b : together_m_per_s;
    if (slides) slip_m_ += (object_m_per_s - (most_N - wanted_N) / drag_) * dt_s;
    state_.X_WO.translation() += object_m_per_s * dt_s * down_;
    for (int k = 0; k < model_.fingers(); ++k)
      feel(k, friction, carried_N * normal_N_[k] / pressing_N, carried_N / most_N);
  }

  [[nodiscard]] double slip_m() const { return slip_m_; }
  [[nodiscard]] bool answered() const { return answered_; }
  void forget() { answered_ = false; }

 private:
  /// Returns the share by which a finger's force approaches its command in a period: a viscous finger on its pulp.
  [[nodiscard]] double follow(int k) const {
    const Pulp& pulp = model_.pulps[k];
    const double N = normal_N_[k];
    if (!(N > 0.0)) return 1.0;  // The start.
    const double lag_s = press_drag_[k] * hertz_depth_m(pulp, N) / (1.5 * N);
    return 1.0 - std::exp(-model_.scene.control_period_s / lag_s);
  }

  /// Sets what finger k senses at a share eta of the friction limit, by Cattaneo and Mindlin.
  void feel(int k, double friction, double carried_N, double eta) {
    FingerLoad& load = state_.load[k];
    load.normal_N = normal_N_[k];
    load.force_N = normal_N_[k] * load.normal - carried_N * down_;
    Touch touch;
    touch.stick = std::pow(std::max(0.0, 1.0 - eta), 2.0 / 3.0);
    if (eta > kRimSlips) touch.friction = friction;
    touch.normal_N = normal_N_[k];
    touch.tangential_N = -carried_N * down_;
    state_.touch[k] = touch;
  }

  const Model& model_;
  State state_;
  Frame frame_;
  Controller controller_;
  Vector3d down_;  ///< Direction of the load, unit, across the fingers' normals.
  PerFinger<double> normal_N_;
  std::vector<double> press_drag_;  ///< Viscosity of each finger along its normal [N s/m].
  std::vector<double> aside_;       ///< and how much it is pressed by what pulls it against the load.
  double drag_ = 0.0;               ///< Viscosity of all fingers along the load.
  double time_s_ = 0.0, slip_m_ = 0.0;
  bool answered_ = false;
};

/// Returns the part of a direction that no finger's normal bears.
Vector3d across(const Model& model, const Vector3d& direction) {
  HandPose pose;
  const State start(model);
  forward_kinematics(model.scene.hand, start.q, pose);
  const Vector3d axis = finger_contact(model, pose, start, 0).axes.col(0);
  return direction - axis.dot(direction) * axis;
}

/// Finds the largest held value between one that is held and one that is not.
template <typename Holds>
double bisect(double good, double bad, Holds&& holds) {
  for (int i = 0; i < kHalvings; ++i) (holds(0.5 * (good + bad)) ? good : bad) = 0.5 * (good + bad);
  return good;
}

}  // namespace

std::optional<ReflexReach> reflex_reach(const Model& of) {
  if (!of.scene.control || !of.scene.control->reflex) return std::nullopt;
  Model model = of;
  const TaskSettings task = std::exchange(model.scene.task, {});  // Only sliding moves.
  const Scene& scene = model.scene;
  const bool pushed = task.push && !task.push->force_N.isZero();
  const Vector3d along = pushed ? Vector3d(scene.object.X_WO.linear() * task.push->force_N) : scene.gravity;
  const Vector3d line = across(model, along);
  if (!(line.norm() > 0.5 * along.norm())) return std::nullopt;
  const double friction = scene.contact.friction, rise_s = pushed ? task.push->rise_s : 0.0;

  ReflexReach reach;
  reach.of_push = pushed;
  reach.slip_m = scene.hand.fingertips[0].radius_m;
  for (const Fingertip& tip : scene.hand.fingertips) reach.slip_m = std::min(reach.slip_m, tip.radius_m);
  reach.slip_m = task.lost_m.value_or(reach.slip_m);
  LineModel rest(model, line.normalized());
  for (double s = 0.0; s < kRest_s; s += scene.control_period_s) rest.step(friction, 0.0);
  if (!(rest.slip_m() < 0.1 * reach.slip_m)) return std::nullopt;
  rest.forget();
  const auto holds = [&](double to_friction, double load_N) {
    LineModel slide = rest;
    for (double s = 0.0; s < kAnswer_s; s += scene.control_period_s) {
      slide.step(to_friction, rise_s > s ? load_N * s / rise_s : load_N);
      if (slide.slip_m() - rest.slip_m() > reach.slip_m) return false;
    }
    return true;
  };
  double most_N = 1.0;
  while (most_N < 100.0 && holds(friction, most_N)) most_N *= 2.0;
  reach.load_N = bisect(0.0, most_N, [&](double load_N) { return holds(friction, load_N); });
  if (scene.control->felt_margin) {
    reach.friction = bisect(friction, 0.0, [&](double to) { return holds(to, 0.0); });
  }
  for (LineModel slide = rest; !slide.answered() && reach.answer_s < kAnswer_s;
       reach.answer_s += scene.control_period_s) {
    slide.step(friction, rise_s > reach.answer_s ? reach.load_N * reach.answer_s / rise_s : reach.load_N);
  }
  return reach;
}

}  // namespace thenar
