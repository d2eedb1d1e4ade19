// SPDX-License-Identifier: Apache-2.0
#include "engine/insertion/insertion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kBrief_s = 5e-3;   // A contact state that ends sooner is chatter of another.
constexpr double kStill = 0.1;      // A peg slower than this share of the hole's speed stands still
constexpr double kStill_s = 20e-3;  // if that lasts so long.

/// The pose of the object relative to the hole, in the plane.
struct PegView {
  PegView(const PegScene& peg, const EnvironmentBody& hole, const Instant& now, const Isometry3d& X_WO) : X_PW() {
    X_PW = (pose(hole, now) * Isometry3d(peg.R_EP)).inverse();
    const Isometry3d X_PO = X_PW * X_WO;
    end_m = X_PO * Vector3d(0.0, 0.0, 0.5 * peg.end * peg.length_m);
    axis = -peg.end * X_PO.linear().col(2);
    tilt_rad = std::atan2(axis[0], axis[2]);
  }
  Isometry3d X_PW;
  Vector3d end_m, axis;
  double tilt_rad = 0.0;
};

/// Returns the contact state of these forces.
PegTouch touch_of(const PegScene& peg, const std::vector<EnvironmentForce>& forces, double depth_m) {
  constexpr double kFlat = 0.9, kSloping = 0.35;  // Components of normals along the hole; a tilted peg tilts them.
  std::vector<Vector3d> walls;
  bool chamfer = false, flat = false;
  for (const EnvironmentForce& force : forces) {
    if (force.body != static_cast<int>(peg.body)) continue;
    flat = flat || force.n_E[2] > kFlat;
    chamfer = chamfer || (force.n_E[2] <= kFlat && force.n_E[2] > kSloping);
    if (force.n_E[2] <= kSloping) walls.push_back(force.n_E);
  }
  if (flat) return depth_m > 0.5 * peg.hole_depth_m ? PegTouch::kBottom : PegTouch::kPlate;
  if (chamfer) return PegTouch::kChamfer;
  if (walls.empty()) return PegTouch::kFree;
  const auto opposite = [&](const Vector3d& n) { return n.head<2>().dot(walls.front().head<2>()) < 0.0; };
  if (std::ranges::any_of(walls, opposite)) return PegTouch::kTwoPoints;
  return walls.size() > 1 ? PegTouch::kLine : PegTouch::kOnePoint;
}

/// A watcher of each tick of a run.
class PegWatch : public Watcher {
 public:
  PegWatch(const Scene& scene, const PegScene& peg, std::vector<PegTick>& ticks)
      : scene_(scene), peg_(peg), hole_(scene.environment->bodies[peg.body]), ticks_(ticks) {}

  bool see_tick(const Tick& tick) override {
    const double step_s = scene_.step_s, time_s = static_cast<double>(tick.after.tick) * step_s;
    const Instant now = instant(tick.after.arm, time_s), before = instant(tick.after.arm, time_s - step_s);
    const PegView view(peg_, hole_, now, tick.after.X_WO);
    const EnvironmentReport& report = tick.contact.environment;
    const std::vector<EnvironmentForce>& forces = tick.run->state.environment_forces;
    PegTick seen;
    seen.time_s = time_s;
    seen.depth_m = -view.end_m[2];
    seen.tilt_rad = view.tilt_rad;
    seen.touch = touch_of(peg_, forces, seen.depth_m);
    const Matrix3d R_PW = view.X_PW.linear();
    const Matrix3d R_PE = peg_.R_EP.transpose();
    Vector3d f = Vector3d::Zero(), m = Vector3d::Zero();
    for (const EnvironmentForce& force : forces) {
      if (force.body != static_cast<int>(peg_.body)) continue;
      const Vector3d by_hand_N = -(R_PE * force.f_E);
      seen.normal_N += force.n_E.dot(force.f_E);
      f += by_hand_N;
      m += (R_PE * force.p_E - view.end_m).cross(by_hand_N);
    }
    seen.push_N = -f[2];
    seen.aside_N = f[0];
    seen.across_N = f[1];
    seen.moment_Nm = m[1];
    seen.wedged = report.wedged;
    const Vector3d hole_m = pose(hole_, now).translation(), before_m = pose(hole_, before).translation();
    seen.coming_m_per_s = (R_PW * (hole_m - before_m))[2] / step_s;
    seen.going_m_per_s = ticks_.empty() ? 0.0 : (seen.depth_m - ticks_.back().depth_m) / step_s;
    ticks_.push_back(seen);
    return true;
  }

 private:
  const Scene& scene_;
  const PegScene& peg_;
  const EnvironmentBody& hole_;
  std::vector<PegTick>& ticks_;
};

std::vector<PegPhase> phases_of(const std::vector<PegTick>& ticks, double step_s) {
  std::vector<PegPhase> all;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (!all.empty() && all.back().touch == ticks[i].touch) {
      all.back().end = i + 1;
    } else {
      all.push_back({ticks[i].touch, i, i + 1});
    }
  }
  std::vector<PegPhase> merged;
  for (const PegPhase& phase : all) {
    const bool brief = static_cast<double>(phase.end - phase.begin) * step_s < kBrief_s;
    if (!merged.empty() && (brief || merged.back().touch == phase.touch)) {
      merged.back().end = phase.end;
    } else {
      merged.push_back(phase);
    }
  }
  return merged;
}

/// Returns the tick from which on the peg stands still in a moving hole, if any.
std::optional<std::size_t> last_stop(const InsertionStudy& study, double step_s) {
  const auto enough = static_cast<std::size_t>(std::lround(kStill_s / step_s));
  std::size_t still = 0, stop = 0;
  for (std::size_t i = 0; i < study.ticks.size(); ++i) {
    const PegTick& tick = study.ticks[i];
    if (!tick.comes()) continue;
    const bool stands = tick.going_m_per_s < kStill * tick.coming_m_per_s && tick.touch != PegTouch::kFree &&
                        tick.touch != PegTouch::kBottom;
    if (stands && still == 0) stop = i;
    still = stands ? still + 1 : 0;
  }
  return still >= enough ? std::optional(stop) : std::nullopt;
}

PegEnd end_of(const InsertionStudy& study) {
  constexpr double kShort = 0.8;  // Share of the depth for a rigid hand that any compliant hand reaches.
  const double chamfer_m = study.peg.shape.chamfer_m, last_m = study.ticks.empty() ? 0.0 : study.ticks.back().depth_m;
  // A wedged peg that is turned free continues.
  const bool ends = study.stopped || study.verdict.outcome == Outcome::kLost || last_m < kShort * study.asked_m;
  if (study.wedged && ends) return PegEnd::kWedged;
  if (study.stopped && study.ticks[*study.stopped].depth_m > chamfer_m) return PegEnd::kJammed;
  if (study.verdict.outcome == Outcome::kLost) return PegEnd::kLost;
  return last_m > chamfer_m && !study.stopped ? PegEnd::kIn : PegEnd::kOutside;
}

/// Returns the depth for a rigid hand; NaN if a task decides it during the run.
double asked_m(const Scene& scene, const PegScene& peg) {
  if (!scene.task.phases.empty()) return std::numeric_limits<double>::quiet_NaN();
  return -PegView(peg, scene.environment->bodies[peg.body], scene.duration_s, scene.object.X_WO).end_m[2];
}

/// Returns the controller as a spring; nothing if it is none.
std::optional<PegSpring> spring_of(const Scene& scene, const PegScene& peg) {
  if (!scene.control) return std::nullopt;
  const ControlSettings& control = *scene.control;
  const TaskSettings& task = scene.task;
  const bool moves = task.translate || task.rotate || task.push || task.arm || task.spring || !task.phases.empty();
  if (control.position.i != 0.0 || control.rotation.i != 0.0 || control.drive || moves) return std::nullopt;
  const Vector3d centre_m = control.centre_m.value_or(Vector3d::Zero());
  constexpr double kOnAxis_m = 1e-4;
  if (centre_m.head<2>().norm() > kOnAxis_m) return std::nullopt;
  return PegSpring{control.position.p, control.rotation.p, 0.5 * peg.length_m - peg.end * centre_m[2]};
}

std::vector<PegForce> theory_of(const Scene& scene, const PegScene& peg) {
  const auto spring = spring_of(scene, peg);
  if (!spring) return {};
  constexpr int kPoses = 1500;
  std::vector<PegPose> wanted;
  for (int i = 0; i <= kPoses; ++i) {
    const double time_s = scene.duration_s * i / kPoses;
    const PegView view(peg, scene.environment->bodies[peg.body], time_s, scene.object.X_WO);
    wanted.push_back({view.end_m[0], view.end_m[2], view.tilt_rad});
  }
  return peg_theory(peg.shape, *spring, wanted);
}

PegTouch touch_of(const PegForce& force) {
  if (force.points == 0) return PegTouch::kFree;
  if (force.on_chamfer) return PegTouch::kChamfer;
  return force.points == 1 ? PegTouch::kOnePoint : PegTouch::kTwoPoints;
}

/// Returns F_z of the theory at a depth, between two of its poses with this contact state; NaN if there are none.
double push_at(const std::vector<PegForce>& theory, PegTouch touch, double depth_m) {
  const auto after = std::ranges::lower_bound(theory, depth_m, {}, &PegForce::depth_m);
  if (after == theory.begin() || after == theory.end()) return std::numeric_limits<double>::quiet_NaN();
  const PegForce &low = *(after - 1), &high = *after;
  // With another contact state the peg slips by itself.
  if (touch_of(low) != touch || touch_of(high) != touch) return std::numeric_limits<double>::quiet_NaN();
  const double share = (depth_m - low.depth_m) / (high.depth_m - low.depth_m);
  return low.push_N + share * (high.push_N - low.push_N);
}

}  // namespace

const char* to_string(PegTouch touch) {
  switch (touch) {
    case PegTouch::kFree:
      return "free";
    case PegTouch::kPlate:
      return "plate";
    case PegTouch::kChamfer:
      return "chamfer";
    case PegTouch::kOnePoint:
      return "one point";
    case PegTouch::kTwoPoints:
      return "two points";
    case PegTouch::kLine:
      return "line";
    case PegTouch::kBottom:
      break;
  }
  return "bottom";
}

const char* in_words(PegTouch touch) {
  switch (touch) {
    case PegTouch::kFree:
      return "the peg touches nothing";
    case PegTouch::kPlate:
      return "the peg's end is on the plate, or on the rim of the mouth";
    case PegTouch::kChamfer:
      return "the chamfer moves the peg's end aside";
    case PegTouch::kOnePoint:
      return "one side of the hole touches the peg";
    case PegTouch::kTwoPoints:
      return "the mouth holds the peg on one side, the wall its end on the other";
    case PegTouch::kLine:
      return "the peg lies along one side of the hole";
    case PegTouch::kBottom:
      break;
  }
  return "the peg stands on the bottom";
}

const char* to_string(PegEnd end) {
  switch (end) {
    case PegEnd::kIn:
      return "in";
    case PegEnd::kOutside:
      return "outside";
    case PegEnd::kWedged:
      return "wedged";
    case PegEnd::kJammed:
      return "jammed";
    case PegEnd::kLost:
      break;
  }
  return "lost";
}

PegScene peg_scene(const Scene& scene, const std::string& file) {
  const auto refuse = [&](const std::string& why) -> ConfigError { return ConfigError({{file, "", why}}); };
  const auto* cylinder = std::get_if<CylinderShape>(&scene.object.shape);
  if (cylinder == nullptr) throw refuse("its object is no peg: object.shape has to be a cylinder");
  const std::vector<EnvironmentBody> none;
  const std::vector<EnvironmentBody>& bodies = scene.environment ? scene.environment->bodies : none;
  const auto hole = std::ranges::find_if(
      bodies, [](const EnvironmentBody& body) { return std::holds_alternative<HoleShape>(body.shape); });
  if (hole == bodies.end()) throw refuse("there is no hole for its peg: name one in environment.bodies");
  const HoleShape& shape = std::get<HoleShape>(hole->shape);
  if (!(shape.radius_m > cylinder->radius_m)) throw refuse("its peg is not thinner than '" + hole->name + "'");
  PegScene peg;
  peg.body = static_cast<std::size_t>(hole - bodies.begin());
  peg.shape = {cylinder->radius_m, shape.radius_m, shape.chamfer_m, hole->friction};
  peg.hole_depth_m = shape.depth_m;
  peg.length_m = cylinder->length_m;
  const Isometry3d X_EO = pose(*hole, 0.0).inverse() * scene.object.X_WO;
  peg.end = X_EO.linear()(2, 2) > 0.0 ? -1.0 : 1.0;
  const Vector3d up = -peg.end * X_EO.linear().col(2), end_m = X_EO * Vector3d(0.0, 0.0, 0.5 * peg.end * peg.length_m);
  constexpr double kTilted = 1e-4, kAside_m = 1e-6;  // Less has no direction.
  Vector3d x(up[0], up[1], 0.0);
  if (x.norm() < kTilted) x = Vector3d(end_m[0], end_m[1], 0.0);
  if (x.norm() < kAside_m) x = Vector3d::UnitX();
  x.normalize();
  peg.R_EP << x, Vector3d::UnitZ().cross(x), Vector3d::UnitZ();
  peg.tilt_rad = std::atan2(x.dot(up), up[2]);
  peg.aside_m = x.dot(end_m);
  return peg;
}

double InsertionStudy::deepest_m() const {
  double depth_m = 0.0;
  for (const PegTick& tick : ticks) depth_m = std::max(depth_m, tick.depth_m);
  return depth_m;
}

double InsertionStudy::off_theory(PegTouch touch) const {
  double off_N = 0.0, most_N = 0.0;
  for (const PegPhase& phase : phases) {
    if (phase.touch != touch) continue;
    for (std::size_t i = phase.begin; i < phase.end; ++i) {
      const double push_N = push_at(theory, touch, ticks[i].depth_m);
      if (std::isnan(push_N)) continue;
      off_N = std::max(off_N, std::abs(ticks[i].push_N - push_N));
      most_N = std::max(most_N, push_N);
    }
  }
  return most_N > 0.0 ? off_N / most_N : std::numeric_limits<double>::quiet_NaN();
}

std::optional<JammingPoint> jamming_point(const PegScene& peg, const PegTick& tick) {
  const double l_m = tick.depth_m - peg.shape.chamfer_m, mu = peg.shape.friction, r_m = peg.shape.radius_m;
  if (!(l_m > 0.0 && mu > 0.0 && tick.push_N > 0.0)) return std::nullopt;
  JammingPoint at{l_m / (2.0 * r_m * mu), tick.aside_N / tick.push_N, tick.moment_Nm / (r_m * tick.push_N)};
  const double off_axis = std::abs(at.moment - mu * (1.0 + at.lambda) * at.across);
  at.margin = std::min((at.lambda - off_axis) / (1.0 + at.lambda), 1.0 - mu * std::abs(at.across));
  return at;
}

InsertionStudy study_insertion(const Model& model, const PegScene& peg, RunSettings settings) {
  InsertionStudy study;
  study.peg = peg;
  PegWatch watch(model.scene, peg, study.ticks);
  settings.watchers.push_back(&watch);
  State state(model);
  study.verdict = run_scene(model, state, settings).verdict;
  const auto first = [&](auto is) -> std::optional<std::size_t> {
    const auto found = std::ranges::find_if(study.ticks, is);
    if (found == study.ticks.end()) return std::nullopt;
    return static_cast<std::size_t>(found - study.ticks.begin());
  };
  study.phases = phases_of(study.ticks, model.scene.step_s);
  study.two_points = first([](const PegTick& tick) { return tick.touch == PegTouch::kTwoPoints; });
  study.wedged = first([](const PegTick& tick) { return tick.wedged; });
  study.stopped = last_stop(study, model.scene.step_s);
  study.asked_m = asked_m(model.scene, peg);
  study.end = end_of(study);
  study.theory = theory_of(model.scene, peg);
  return study;
}

}  // namespace thenar
