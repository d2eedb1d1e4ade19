// SPDX-License-Identifier: Apache-2.0
#include "engine/control/task_run.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Vector3d;
using Kind = Phase::Kind;

namespace {

// Rate of forces between the parts of a phase: a pulp follows in milliseconds.
constexpr double kRamp_s = 0.2;
// Share of the grip force of a finger that waits for the others: too little to shift the object.
constexpr double kTouchShare = 0.1;
constexpr double kPressed = 0.1;      // Relative error below which a force is reached.
constexpr double kLoaded = 0.005;     // Missing share of the weight at which it is borne: the object would sink for it.
constexpr double kSettle_s = 0.5;     // Time after which it counts as reached with the muscles' error.
constexpr double kUnaided = 0.05;     // Tolerance on the weight, where nothing else should bear the object,
constexpr double kLeast_N = 0.01;     // and the least one.
constexpr double kBehind_m = 2e-3;    // Distance from its target at which an object has followed the arm,
constexpr double kStopped_m = 10e-3;  // and at which it does not any more: a verdict calls it off target.
constexpr double kSupported = 0.5;    // Share of the weight borne by a support: rubbing walls bear less, a table all.
constexpr double kMet_s = 20e-3;      // Time for which it must bear it: an oscillating load does not.
constexpr double kProbe_m = 0.3e-3;   // Way of the arm on which a support must stop the object,
constexpr double kGives = 0.5;        // but for this share: walls that rub let it go with the arm.
constexpr double kLeft = 0.2;         // Share that the fingers may still bear at release.
constexpr double kLeastWay_m = 1e-9;

bool is_holding(Kind kind) { return kind != Kind::kApproach && kind != Kind::kClose && kind != Kind::kRelease; }

/// Returns the sum of the fingers' forces on the object.
Vector3d borne(const Snapshot& seen) {
  Vector3d sum_N = Vector3d::Zero();
  for (const FingerLoad& load : seen.load) sum_N += load.force_N;
  return sum_N;
}

int first_loaded(const Snapshot& seen) {
  for (std::size_t k = 0; k < seen.load.size(); ++k) {
    if (seen.load[k].normal_N > 0.0) return static_cast<int>(k);
  }
  return -1;
}

Vector3d weight_N(const Scene& scene) { return scene.object.mass_kg * scene.gravity; }

/// Returns the internal force, interpolated by the borne share of the weight from that of closing to the scene's.
double squeeze_N(const Scene& scene, double press_N, double weight_share) {
  return press_N + weight_share * (scene.control->internal_force_N - press_N);
}

Vector3d down(const Scene& scene) {
  return scene.gravity.isZero(0.0) ? Vector3d(Vector3d::Zero()) : scene.gravity.normalized();
}

/// Returns the weight that the fingers bear: their force against gravity.
double load_N(const Scene& scene, const Vector3d& borne_N) { return -borne_N.dot(down(scene)); }

Vector3d direction(const Vector3d& way_m) {
  return way_m.norm() > kLeastWay_m ? Vector3d(way_m.normalized()) : Vector3d(Vector3d::Zero());
}

double share_of(double since_s, double now_s, double over_s) {
  return std::clamp((now_s - since_s) / over_s, 0.0, 1.0);
}

}  // namespace

TaskRun::TaskRun(const Model& model) : press_N_(model.scene.control->internal_force_N) {
  report_.squeeze_N = press_N_;
  report_.has_touched = PerFinger<bool>(model.fingers());
}

const Phase* TaskRun::phase(const Scene& scene) const {
  const auto& phases = scene.task.phases;
  const bool runs = report_.phase >= 0 && report_.phase < std::ssize(phases);
  return runs ? &phases[static_cast<std::size_t>(report_.phase)] : nullptr;
}

void TaskRun::update(const Model& model, const HandPose& pose, const Snapshot& seen, const Eigen::VectorXd& asked_N) {
  if (frozen_) return;
  now_s_ = static_cast<double>(seen.tick) * model.scene.step_s;
  if (report_.phase < 0) {
    arm_.number = seen.arm.order;
    begin(model, seen, 0);
  }
  if (report_.has_failed || phase(model.scene) == nullptr) return;
  const Vector3d arm = arm_m(seen.arm, now_s_), by_m = model.scene.object.X_WO.linear() * phase(model.scene)->by_m;
  report_.at_s = now_s_;
  report_.arm_way_m = (arm - arm_from_m_).norm();
  report_.object_way_m = direction(by_m).dot(seen.X_WO.translation() + arm - object_from_m_);
  const Step now = step(model, pose, seen, asked_N);
  report_.lack = now.lack;
  if (now.lack.fault == PhaseFault::kNone) {
    begin(model, seen, report_.phase + 1);
  } else if (now.is_fatal || now_s_ - report_.since_s > phase(model.scene)->within_s) {
    report_.has_failed = true;
    stop_arm();
  }
}

void TaskRun::begin(const Model& model, const Snapshot& seen, int number) {
  report_.phase = number;
  report_.since_s = step_since_s_ = now_s_;
  arm_from_m_ = arm_m(seen.arm, now_s_);
  object_from_m_ = seen.X_WO.translation() + arm_from_m_;
  share_from_ = report_.weight_share;
  meet(model.scene, seen);
  second_ = false;
  const Phase* const phase = this->phase(model.scene);
  if (phase == nullptr) {
    // A hand that has released the object stays open.
    report_.speed_m_per_s = 0.0;
    return;
  }
  const bool posed = report_.poses;
  report_.grasps = report_.holds = report_.poses = is_holding(phase->kind);
  report_.integrates = report_.poses && phase->kind != Kind::kLoad;
  report_.touch_N = report_.speed_m_per_s = 0.0;
  std::ranges::fill(report_.has_touched, false);
  if (report_.poses && !posed) report_.X_WT = seen.X_WO;  // It is held at its grasped pose.
  switch (phase->kind) {
    case Kind::kApproach:
      report_.weight_share = 0.0;
      send_arm(model.scene.object.X_WO.linear() * phase->by_m, phase->over_s);
      break;
    case Kind::kClose:
      press_N_ = phase->press_N;
      report_.weight_share = 0.0;
      report_.touch_N = kTouchShare * press_N_;
      report_.speed_m_per_s = phase->speed_m_per_s;
      break;
    case Kind::kLoad:
      report_.weight_share = 0.0;
      break;
    case Kind::kLift:
    case Kind::kMove:
    case Kind::kInsert:
    case Kind::kPlace:
      send_arm(model.scene.object.X_WO.linear() * phase->by_m, phase->over_s);
      break;
    case Kind::kRelease:
      report_.weight_share = 0.0;
      report_.grasps = true;
      break;
  }
}

TaskRun::Step TaskRun::step(const Model& model, const HandPose& pose, const Snapshot& seen,
                            const Eigen::VectorXd& asked_N) {
  const Scene& scene = model.scene;
  const Phase& phase = *this->phase(scene);
  const Vector3d borne_N = borne(seen);
  const double load = load_N(scene, borne_N), full_N = weight_N(scene).norm();
  const double for_s = now_s_ - report_.since_s;
  const Vector3d against_N = borne_N + scene.object.mass_kg * model.gravity(now_s_);
  if (phase.kind == Kind::kLoad) report_.weight_share = share_of(report_.since_s, now_s_, phase.over_s);
  if (report_.holds) report_.squeeze_N = squeeze_N(scene, press_N_, report_.weight_share);
  switch (phase.kind) {
    case Kind::kApproach:
      if (const int finger = first_loaded(seen); finger >= 0)
        return {{PhaseFault::kTouchesEarly, seen.load[finger].normal_N, 0.0, finger}, true};
      return {arm_lacks(seen, phase)};
    case Kind::kClose:
      return close(model, pose, seen, asked_N);
    case Kind::kLoad: {
      const double within_N = (for_s < phase.over_s + kSettle_s ? kLoaded : kUnaided) * full_N;
      const bool is_borne = report_.weight_share >= 1.0 && std::abs(load - full_N) <= within_N;
      return is_borne ? Step{} : Step{{PhaseFault::kNotLoaded, load, full_N}};
    }
    case Kind::kLift:
    case Kind::kMove:
      return carry(model, seen, against_N);
    case Kind::kInsert:
      return insert(model, seen, against_N);
    case Kind::kPlace:
      return second_ ? hand_over(model, seen, load) : place(model, seen, load);
    case Kind::kRelease:
      return release(phase, seen);
  }
  return {};
}

TaskRun::Step TaskRun::close(const Model& model, const HandPose& pose, const Snapshot& seen,
                             const Eigen::VectorXd& asked_N) {
  if (!second_) {
    for (int k = 0; k < model.fingers(); ++k)
      report_.has_touched[k] = report_.has_touched[k] || seen.load[k].normal_N > 0.0;
    const auto unmet = std::ranges::find(report_.has_touched, false);
    if (unmet != report_.has_touched.end()) {
      const int apart = static_cast<int>(unmet - report_.has_touched.begin());
      return {{PhaseFault::kNotThere, finger_gap_m(model, pose, seen, apart), 0.0, apart}};
    }
    second_ = report_.grasps = true;
    step_since_s_ = now_s_;
  }
  const double rise = share_of(step_since_s_, now_s_, kRamp_s);
  report_.squeeze_N = std::max(kTouchShare, rise) * press_N_;
  for (int k = 0; k < model.fingers(); ++k) {
    const Vector3d asked = asked_N.segment<3>(3 * k);
    // The object may give way to those that touched first.
    if (seen.load[k].normal_N <= 0.0) return {{PhaseFault::kNotThere, finger_gap_m(model, pose, seen, k), 0.0, k}};
    const double off_N = (asked - seen.load[k].force_N).norm();
    if (off_N > kPressed * asked.norm()) return {{PhaseFault::kNotPressing, off_N, asked.norm(), k}};
  }
  return rise >= 1.0 ? Step{} : Step{{PhaseFault::kNotPressing, 0.0, press_N_, 0}};
}

TaskRun::Step TaskRun::carry(const Model& model, const Snapshot& seen, const Vector3d& against_N) {
  const Scene& scene = model.scene;
  const double most_N = std::max(kLeast_N, kUnaided * weight_N(scene).norm()), resists_N = against_N.norm();
  const double behind = behind_m(scene, seen).norm();
  const bool is_free = resists_N <= most_N;
  const PhaseLack held{PhaseFault::kNotFree, resists_N, most_N};
  if (!arm_is_there(seen)) {
    const bool is_stopped = !is_free && behind > kStopped_m;
    return is_stopped ? Step{held, true} : Step{arm_lacks(seen, *phase(scene))};
  }
  if (is_free) {
    step_since_s_ = now_s_;
    return behind <= kBehind_m ? Step{} : Step{{PhaseFault::kBehind, behind, kBehind_m}};
  }
  const double wait_s = kSettle_s + lag_s(scene);
  return {held, now_s_ - step_since_s_ > wait_s && arm_rests(seen, wait_s)};
}

TaskRun::Step TaskRun::insert(const Model& model, const Snapshot& seen, const Vector3d& against_N) {
  const Phase& phase = *this->phase(model.scene);
  const Vector3d way = direction(model.scene.object.X_WO.linear() * phase.by_m);
  const double resists_N = against_N.dot(way), behind = behind_m(model.scene, seen).dot(way);
  if (resists_N > phase.most_N) return {{PhaseFault::kJammed, resists_N, phase.most_N}, true};
  if (!arm_is_there(seen)) return {arm_lacks(seen, phase)};
  if (behind <= kBehind_m) return {};
  return {{PhaseFault::kBehind, behind, kBehind_m}, arm_rests(seen, kSettle_s + lag_s(model.scene))};
}

void TaskRun::meet(const Scene& scene, const Snapshot& seen) {
  met_since_s_ = now_s_;
  met_arm_m_ = down(scene).dot(arm_m(seen.arm, now_s_));
  met_object_m_ = met_arm_m_ + down(scene).dot(seen.X_WO.translation());
}

TaskRun::Step TaskRun::place(const Model& model, const Snapshot& seen, double load) {
  const Scene& scene = model.scene;
  const double full_N = weight_N(scene).norm();
  report_.weight_share = std::min(1.0, share_from_ + share_of(step_since_s_, now_s_, kRamp_s));
  const bool is_over = arm_rests(seen, kSettle_s);
  const PhaseLack none{PhaseFault::kNothingUnder, full_N - load, full_N};
  if (load > (1.0 - kSupported) * full_N) meet(scene, seen);
  if (now_s_ - met_since_s_ < kMet_s + lag_s(scene)) {
    // At the end of the arm's way gains without integrals may press too little: what bears anything is tried.
    if (!is_over || load > (1.0 - kUnaided) * full_N) return {none, is_over};
  }
  // What is under the object stops it; walls that rub bear as much, and let it go on with the arm.
  const double arm_down_m = down(scene).dot(arm_m(seen.arm, now_s_));
  const double arm_way_m = arm_down_m - met_arm_m_;
  const double object_way_m = arm_down_m + down(scene).dot(seen.X_WO.translation()) - met_object_m_;
  if (arm_way_m < kProbe_m && !is_over) return {none};
  if (object_way_m > kGives * arm_way_m && !is_over) {
    meet(scene, seen);
    return {none};
  }
  second_ = true;
  step_since_s_ = met_since_s_ = now_s_;
  report_.integrates = false;
  report_.X_WT = seen.X_WO;  // Its support now bears it.
  stop_arm();
  return hand_over(model, seen, load);
}

TaskRun::Step TaskRun::hand_over(const Model& model, const Snapshot& seen, double load) {
  const Scene& scene = model.scene;
  const Phase& phase = *this->phase(scene);
  const double full_N = weight_N(scene).norm(), lag = lag_s(scene);
  const double share = 1.0 - share_of(step_since_s_, now_s_, kRamp_s);
  report_.weight_share = share;
  if (load <= (share + kSupported) * full_N) met_since_s_ = now_s_;
  const bool is_back = now_s_ - met_since_s_ >= kMet_s + lag;
  const bool is_left = now_s_ - step_since_s_ > kRamp_s + kSettle_s + lag && load > kLeft * full_N;
  if (is_back || is_left) {
    // It gave way: the arm goes on.
    const Vector3d left_m = scene.object.X_WO.linear() * phase.by_m + arm_from_m_ - arm_m(seen.arm, now_s_);
    if (left_m.norm() < kProbe_m) return {{PhaseFault::kGaveWay, load, full_N}, true};
    second_ = false;
    report_.integrates = true;
    step_since_s_ = now_s_;
    share_from_ = share;
    meet(scene, seen);
    send_arm(left_m, std::max(kRamp_s, phase.over_s * left_m.norm() / phase.by_m.norm()));
    return {{PhaseFault::kNothingUnder, full_N - load, full_N}};
  }
  if (share <= 0.0 && std::abs(load) <= kLeft * full_N) return {};
  return {{PhaseFault::kNotUnloaded, load, 0.0}};
}

TaskRun::Step TaskRun::release(const Phase& phase, const Snapshot& seen) {
  if (!second_) {
    const double left = 1.0 - share_of(report_.since_s, now_s_, kRamp_s);
    report_.squeeze_N = left * press_N_;
    if (left > 0.0) return {{PhaseFault::kNotOpen}};
    second_ = true;
    step_since_s_ = now_s_;
    report_.grasps = false;
    report_.speed_m_per_s = -phase.speed_m_per_s;
  }
  const int finger = first_loaded(seen);
  const bool is_open = now_s_ - step_since_s_ >= phase.open_m / phase.speed_m_per_s;
  if (is_open) report_.speed_m_per_s = 0.0;
  if (is_open && finger < 0) return {};
  return {{PhaseFault::kNotOpen, finger >= 0 ? seen.load[finger].normal_N : 0.0, 0.0, finger}};
}

void TaskRun::send_arm(const Vector3d& by_m, double over_s) { arm_ = {arm_.number + 1, by_m, over_s}; }

void TaskRun::stop_arm() { send_arm(Vector3d::Zero(), 1.0); }

bool TaskRun::arm_is_there(const Snapshot& seen) const {
  return seen.arm.order == arm_.number && now_s_ >= seen.arm.begin_s + seen.arm.over_s;
}

bool TaskRun::arm_rests(const Snapshot& seen, double for_s) const {
  return arm_is_there(seen) && now_s_ > seen.arm.begin_s + seen.arm.over_s + for_s;
}

PhaseLack TaskRun::arm_lacks(const Snapshot& seen, const Phase& phase) const {
  return arm_is_there(seen) ? PhaseLack{} : PhaseLack{PhaseFault::kArmLate, report_.arm_way_m, phase.by_m.norm()};
}

Vector3d TaskRun::behind_m(const Scene& scene, const Snapshot& seen) const {
  const Eigen::Isometry3d target = seen.X_WT.value_or(report_.X_WT.value_or(scene.object.X_WO));
  return target.translation() - seen.X_WO.translation();
}

}  // namespace thenar
