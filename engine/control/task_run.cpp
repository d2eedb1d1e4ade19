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
constexpr double kPressed = 0.1;    // Relative error below which a force is reached.
constexpr double kLoaded = 0.005;   // Missing share of the weight at which it is borne: the object would sink for it.
constexpr double kSettle_s = 0.5;   // Time after which it counts as reached with the muscles' error.
constexpr double kUnaided = 0.05;   // Tolerance on the weight, where nothing else should bear the object.
constexpr double kSupported = 0.5;  // Share of the weight borne by a support: rubbing walls bear less, a table all.
constexpr double kMet_s = 20e-3;    // Time for which it must bear it: an oscillating load does not.
constexpr double kLeft = 0.2;       // Share that the fingers may still bear at release.
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

/// Returns the weight that the fingers bear: their force against gravity.
double load_N(const Scene& scene, const Vector3d& borne_N) {
  return scene.gravity.isZero(0.0) ? 0.0 : -borne_N.dot(scene.gravity.normalized());
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
  if (report_.fault != PhaseFault::kNone || phase(model.scene) == nullptr) return;
  const bool done = step(model, pose, seen, asked_N);
  if (report_.fault != PhaseFault::kNone) {
    report_.way_m = (arm_m(seen.arm, now_s_) - arm_from_m_).norm();
    report_.failed_s = now_s_;
    stop_arm();
  } else if (done) {
    begin(model, seen, report_.phase + 1);
  }
}

void TaskRun::begin(const Model& model, const Snapshot& seen, int number) {
  report_.phase = number;
  report_.since_s = met_since_s_ = now_s_;
  arm_from_m_ = arm_m(seen.arm, now_s_);
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
      send_arm(model.scene, *phase);
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
      send_arm(model.scene, *phase);
      break;
    case Kind::kRelease:
      report_.weight_share = 0.0;
      report_.grasps = true;
      break;
  }
}

bool TaskRun::step(const Model& model, const HandPose& pose, const Snapshot& seen, const Eigen::VectorXd& asked_N) {
  const Scene& scene = model.scene;
  const Phase& phase = *this->phase(scene);
  const Vector3d borne_N = borne(seen);
  const double load = load_N(scene, borne_N), full_N = weight_N(scene).norm();
  const double for_s = now_s_ - report_.since_s, off_N = std::abs(load - full_N);
  const bool late = for_s > phase.within_s;
  if (phase.kind == Kind::kLoad) report_.weight_share = share_of(report_.since_s, now_s_, phase.over_s);
  if (report_.holds) report_.squeeze_N = squeeze_N(scene, press_N_, report_.weight_share);
  switch (phase.kind) {
    case Kind::kApproach:
      if (const int finger = first_loaded(seen); finger >= 0)
        fail(PhaseFault::kTouchesEarly, seen.load[finger].normal_N, 0.0, finger);
      if (late) fail(PhaseFault::kArmLate, 0.0, phase.by_m.norm());
      return arm_is_there(seen);
    case Kind::kClose:
      return close(model, pose, seen, asked_N);
    case Kind::kLoad:
      if (late) fail(PhaseFault::kNotLoaded, load, full_N);
      return report_.weight_share >= 1.0 && off_N <= (for_s < phase.over_s + kSettle_s ? kLoaded : kUnaided) * full_N;
    case Kind::kLift:
    case Kind::kMove:
      if (late) fail(arm_is_there(seen) ? PhaseFault::kNotFree : PhaseFault::kArmLate, load, full_N);
      return arm_is_there(seen) && off_N <= kUnaided * full_N;
    case Kind::kInsert:
      if (late) fail(PhaseFault::kArmLate, 0.0, phase.by_m.norm());
      return insert(phase, seen, scene.object.X_WO.linear().transpose() * (borne_N + weight_N(scene)));
    case Kind::kPlace:
      return place(model, seen, load);
    case Kind::kRelease:
      return release(phase, seen);
  }
  return false;
}

bool TaskRun::close(const Model& model, const HandPose& pose, const Snapshot& seen, const Eigen::VectorXd& asked_N) {
  const Phase& phase = *this->phase(model.scene);
  const bool late = now_s_ - report_.since_s > phase.within_s;
  if (!second_) {
    for (int k = 0; k < model.fingers(); ++k)
      report_.has_touched[k] = report_.has_touched[k] || seen.load[k].normal_N > 0.0;
    const auto unmet = std::ranges::find(report_.has_touched, false);
    const int apart = unmet == report_.has_touched.end() ? -1 : static_cast<int>(unmet - report_.has_touched.begin());
    if (late && apart >= 0) fail(PhaseFault::kNotThere, finger_gap_m(model, pose, seen, apart), 0.0, apart);
    if (apart >= 0) return false;
    second_ = report_.grasps = true;
    step_since_s_ = now_s_;
  }
  const double rise = share_of(step_since_s_, now_s_, kRamp_s);
  report_.squeeze_N = std::max(kTouchShare, rise) * press_N_;
  int worst = -1;
  for (int k = 0; k < model.fingers(); ++k) {
    const Vector3d asked = asked_N.segment<3>(3 * k);
    const double off_N = (asked - seen.load[k].force_N).norm();
    if (off_N <= kPressed * asked.norm()) continue;
    worst = k;
    if (late) fail(PhaseFault::kNotPressing, off_N, asked.norm(), k);
  }
  return rise >= 1.0 && worst < 0;
}

bool TaskRun::insert(const Phase& phase, const Snapshot& seen, const Vector3d& against_N) {
  const double way_m = phase.by_m.norm();
  const double resists_N = way_m > kLeastWay_m ? against_N.dot(phase.by_m) / way_m : 0.0;
  if (resists_N > phase.most_N) fail(PhaseFault::kJammed, resists_N, phase.most_N);
  return arm_is_there(seen);
}

bool TaskRun::place(const Model& model, const Snapshot& seen, double load) {
  const Phase& phase = *this->phase(model.scene);
  const double full_N = weight_N(model.scene).norm();
  const bool late = now_s_ - report_.since_s > phase.within_s;
  if (!second_) {
    if (load > (1.0 - kSupported) * full_N) met_since_s_ = now_s_;
    if (now_s_ - met_since_s_ < kMet_s + lag_s(model.scene)) {
      const bool is_over = arm_is_there(seen) && now_s_ > seen.arm.begin_s + seen.arm.over_s + kSettle_s;
      if (late || is_over) fail(PhaseFault::kNothingUnder, full_N - load, full_N);
      return false;
    }
    second_ = true;
    step_since_s_ = now_s_;
    report_.integrates = false;
    report_.X_WT = seen.X_WO;  // Its support now bears it.
    stop_arm();
  }
  report_.weight_share = 1.0 - share_of(step_since_s_, now_s_, kRamp_s);
  if (late) fail(PhaseFault::kNotUnloaded, load, 0.0);
  return report_.weight_share <= 0.0 && std::abs(load) <= kLeft * full_N;
}

bool TaskRun::release(const Phase& phase, const Snapshot& seen) {
  if (!second_) {
    const double left = 1.0 - share_of(report_.since_s, now_s_, kRamp_s);
    report_.squeeze_N = left * press_N_;
    if (left > 0.0) return false;
    second_ = true;
    step_since_s_ = now_s_;
    report_.grasps = false;
    report_.speed_m_per_s = -phase.speed_m_per_s;
  }
  const int finger = first_loaded(seen);
  if (now_s_ - report_.since_s > phase.within_s)
    fail(PhaseFault::kNotOpen, finger >= 0 ? seen.load[finger].normal_N : 0.0, 0.0, finger);
  const bool is_open = now_s_ - step_since_s_ >= phase.open_m / phase.speed_m_per_s;
  if (is_open) report_.speed_m_per_s = 0.0;
  return is_open && finger < 0;
}

void TaskRun::send_arm(const Scene& scene, const Phase& phase) {
  arm_ = {arm_.number + 1, scene.object.X_WO.linear() * phase.by_m, phase.over_s};
}

void TaskRun::stop_arm() { arm_ = {arm_.number + 1, Vector3d::Zero(), 1.0}; }

bool TaskRun::arm_is_there(const Snapshot& seen) const {
  return seen.arm.order == arm_.number && now_s_ >= seen.arm.begin_s + seen.arm.over_s;
}

void TaskRun::fail(PhaseFault fault, double value, double bound, int finger) {
  if (report_.fault != PhaseFault::kNone) return;
  report_.fault = fault;
  report_.value = value;
  report_.bound = bound;
  report_.finger = finger;
}

}  // namespace thenar
