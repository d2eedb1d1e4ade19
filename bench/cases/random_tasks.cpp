// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/random_tasks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bench/cases/random.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// Between low and high, as often near one as near the other by ratio.
double by_ratio(Random& random, double low, double high) {
  return random.power_of_ten(std::log10(low), std::log10(high));
}

Phase& phase_of(Scene& scene, Phase::Kind kind) { return *std::ranges::find(scene.task.phases, kind, &Phase::kind); }

/// Tilts the hand against the world: gravity, the bodies and the object turn about the object's origin.
void tilt(Scene& scene, double angle_rad, double towards_rad) {
  const Vector3d axis = scene.object.X_WO.linear() * Vector3d(std::cos(towards_rad), std::sin(towards_rad), 0.0);
  const Eigen::AngleAxisd turn(angle_rad, axis);
  const Vector3d at_m = scene.object.X_WO.translation();
  const auto turned = [&](const Isometry3d& X) {
    return Isometry3d(Eigen::Translation3d(at_m) * turn * Eigen::Translation3d(-at_m) * X);
  };
  scene.gravity = turn * scene.gravity;
  scene.object.X_WO = turned(scene.object.X_WO);
  for (EnvironmentBody& body : scene.environment->bodies) body.X_WE = turned(body.X_WE);
}

/// Statics of a grip from two sides: normal force that bears the weight with the planned friction, on one side.
double needed_N(const Scene& scene) {
  return scene.object.mass_kg * scene.gravity.norm() / (2.0 * scene.control->grasp_friction);
}

/// Above it a pulp of 8 mm with 0.24 MPa has, by Hertz, a patch of half its radius: (4/3) E (R/2)^3 / R.
constexpr double kPulp_N = 2.56;

void vary_pick(Random& random, RandomTask& task) {
  constexpr std::array<const char*, 5> kKinds{"box", "cylinder", "ball", "superquadric", "ellipsoid"};
  Scene& scene = task.scene;
  const int kind = random.whole(0, 4);
  const double size_m = 50e-3 * random.uniform(0.94, 1.06);
  const Vector3d sizes_m = Vector3d(50e-3, size_m, 50e-3);  // It fits into the open hand, and stands on its table.
  if (kind == 0) scene.object.shape = BoxShape{sizes_m};
  if (kind == 1) scene.object.shape = CylinderShape{25e-3, 50e-3};
  if (kind == 2) scene.object.shape = SphereShape{25e-3};
  if (kind == 3) scene.object.shape = SuperquadricShape{sizes_m, {0.2, 0.2}};
  if (kind == 4) scene.object.shape = EllipsoidShape{sizes_m};
  scene.object.mass_kg = by_ratio(random, 0.02, 0.4);
  scene.object.translation_damping = by_ratio(random, 0.3, 5.0);
  const double ground = random.uniform(0.05, 1.0), friction = random.uniform(0.5, 1.0);
  for (EnvironmentBody& body : scene.environment->bodies) body.friction = ground;
  scene.contact.friction = friction;
  scene.control->grasp_friction = 0.7 * friction;
  scene.control->internal_force_N = random.uniform(1.0, 4.0);
  Phase& close = phase_of(scene, Phase::Kind::kClose);
  close.press_N = by_ratio(random, 0.1, 1.0);
  close.speed_m_per_s = by_ratio(random, 5e-3, 80e-3);
  Phase& lift = phase_of(scene, Phase::Kind::kLift);
  lift.over_s = by_ratio(random, 0.2, 1.5);
  const double angle = random.uniform(0.0, 3.0) * kDegree;
  tilt(scene, angle, random.uniform(0.0, 2.0 * std::numbers::pi));
  // What is round rolls on its table as soon as it is let go.
  const bool is_round = kind == 2 || kind == 4;
  task.goal_m = task.name == "grip_lift" ? Vector3d(0.0, 0.0, 0.0) : Vector3d(60e-3, 0.0, 0.0);
  task.is_possible = !is_round && needed_N(scene) < kPulp_N;
  task.variation = fmt::format(
      "{}, {:.0f} g, friction {:.2f} on {:.2f}, squeeze {:.2f} N, press {:.2f} N, lift in {:.2f} "
      "s, tilt {:.1f} degrees",
      kKinds[static_cast<std::size_t>(kind)], 1e3 * scene.object.mass_kg, friction, ground,
      scene.control->internal_force_N, close.press_N, lift.over_s, angle / kDegree);
}

void vary_peg(Random& random, RandomTask& task) {
  Scene& scene = task.scene;
  scene.object.mass_kg = by_ratio(random, 0.02, 0.2);
  const double ground = random.uniform(0.05, 0.6);
  for (EnvironmentBody& body : scene.environment->bodies) body.friction = ground;
  scene.control->internal_force_N = random.uniform(0.7, 3.0);
  const double off_m = random.uniform(0.0, 1.2e-3), towards = random.uniform(0.0, 2.0 * std::numbers::pi);
  phase_of(scene, Phase::Kind::kMove).by_m = {off_m * std::cos(towards), 40e-3 + off_m * std::sin(towards), 0.0};
  phase_of(scene, Phase::Kind::kClose).speed_m_per_s = by_ratio(random, 5e-3, 60e-3);
  Phase& insert = phase_of(scene, Phase::Kind::kInsert);
  insert.over_s = random.uniform(0.7, 3.0);
  insert.most_N = random.uniform(3.0, 10.0);
  insert.position->p = random.uniform(150.0, 600.0);
  const double angle = random.uniform(0.0, 2.0) * kDegree;
  tilt(scene, angle, random.uniform(0.0, 2.0 * std::numbers::pi));
  const auto& hole = std::get<HoleShape>(scene.environment->bodies.front().shape);
  const auto& peg = std::get<CylinderShape>(scene.object.shape);
  const double takes_m = hole.chamfer_m + hole.radius_m - peg.radius_m;
  // The chamfer of 45 degrees is slid down against friction by the side force p off: below what jams.
  const double resists_N = insert.position->p * off_m * (1.0 + ground) / (1.0 - ground);
  task.goal_m = {0.0, 40e-3, -hole.depth_m};
  task.is_possible = off_m < 0.95 * takes_m && resists_N < insert.most_N && needed_N(scene) < kPulp_N;
  task.variation = fmt::format(
      "peg, {:.0f} g, friction {:.2f}, {:.2f} mm aside at {:.0f} degrees, p {:.0f} N/m, squeeze "
      "{:.2f} N, in {:.2f} s, tilt {:.1f} degrees",
      1e3 * scene.object.mass_kg, ground, 1e3 * off_m, towards / kDegree, insert.position->p,
      scene.control->internal_force_N, insert.over_s, angle / kDegree);
}

/// Poses against the environment.
Isometry3d against_environment(const Scene& scene, const TickRecord& tick) {
  Isometry3d X = tick.X_WO;
  X.translation() += scene.object.X_WO.linear() * tick.arm_m;
  return X;
}

}  // namespace

RandomTask random_task(std::uint32_t seed, double delay_s) {
  constexpr std::array<const char*, 3> kNames{"grip_lift", "pick_and_place", "peg_assembly"};
  Random random(seed);
  RandomTask task;
  task.name = kNames[seed % 3];
  task.scene = load_scene(std::filesystem::path(THENAR_CONFIGS) / (task.name + ".yaml"),
                          {"object.points=9000", "fingertips.leaves=160", "control.muscles=false"});
  Scene& scene = task.scene;
  if (random.chance(1.0 / 3.0)) scene.step_s = 0.5e-3;
  if (delay_s > 0.0) scene.control_period_s = scene.control_delay_s = delay_s;
  (task.name == "peg_assembly" ? vary_peg : vary_pick)(random, task);
  scene.duration_s = task.name == "grip_lift" ? 8.0 : 13.0;
  task.variation += fmt::format(", step {:g} ms", 1e3 * scene.step_s);
  return task;
}

TaskLook look_at_end(const RandomTask& task, const Recording& recording) {
  TaskLook look;
  if (recording.ticks.empty()) return look;
  const Scene& scene = task.scene;
  const TickRecord& last = recording.ticks.back();
  const Isometry3d X = against_environment(scene, last), &X_start = scene.object.X_WO;
  const bool is_peg = task.name == "peg_assembly";
  Isometry3d X_from = X_start;  // Where it is taken: on its way there the fingers push it, and slopes roll it.
  for (const TickRecord& tick : recording.ticks) {
    const int loading = task.name == "grip_lift" ? 1 : 2;  // The number of the phase that takes it.
    if (!is_peg && tick.phase <= loading) X_from = against_environment(scene, tick);
  }
  look.off_m = (X.translation() - X_from.translation() - X_start.linear() * task.goal_m).norm();
  look.is_in_place = look.off_m < (is_peg ? 0.5e-3 : 3e-3);
  look.is_upright = turn_rad(scene.object.shape, X_from.linear(), X.linear()) < 5.0 * kDegree;
  look.is_at_rest = true;
  for (const TickRecord& tick : recording.ticks) {
    if (!tick.is_from(last.time_s - 0.2)) continue;
    const double moved_m = (against_environment(scene, tick).translation() - X.translation()).norm();
    look.is_at_rest = look.is_at_rest && moved_m < 0.2e-3;
  }
  look.is_free = std::ranges::all_of(last.load, [](const FingerLoad& load) { return load.normal_N == 0.0; });
  return look;
}

Recording run_task(const RandomTask& task) {
  const Model model = build_model(task.scene);
  State state(model);
  RunSettings settings;
  if (task.scene.control_delay_s > 0.0) settings.lockstep = LockstepSettings{};
  settings.shows = false;
  return run_scene(model, state, settings);
}

}  // namespace thenar
