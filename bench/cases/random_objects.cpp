// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/random_objects.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "collision/blue_noise.h"
#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/models/object_surface.h"
#include "engine/models/scene_grasp.h"
#include "engine/models/surface_model.h"
#include "engine/results/scene_run.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double kLeast_m = 8e-3, kMost_m = 120e-3;
constexpr double kSample_m2 = 1.5e-6;  // Of surface for each sample.

double between(Uniform& uniform, double low, double high) { return low + (high - low) * uniform(); }

/// As many small ones as large ones.
double some_size_m(Uniform& uniform, double low = kLeast_m, double high = kMost_m) {
  return low * std::pow(high / low, uniform());
}

Vector3d some_direction(Uniform& uniform) {
  const double z = between(uniform, -1.0, 1.0), angle = between(uniform, 0.0, 2.0 * std::numbers::pi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

std::string in_mm(const Vector3d& size_m) {
  std::string text;
  for (int i = 0; i < 3; ++i) text += (i > 0 ? " x " : "") + std::to_string(std::lround(1e3 * size_m[i]));
  return text + " mm";
}

struct Sized {
  std::string name;
  Shape shape;
  Vector3d size_m;
};

Sized some_mug(Uniform& uniform) {
  Mug mug{between(uniform, 15e-3, 45e-3), between(uniform, 30e-3, 110e-3), between(uniform, 2e-3, 5e-3), {}};
  if (uniform() < 0.7) {
    const double most_m = 0.8 * std::min(mug.radius_m, 0.5 * mug.height_m);
    const double thickness_m = between(uniform, 0.25, 0.5) * most_m;
    mug.handle = MugHandle{most_m - 0.5 * thickness_m, thickness_m};
  }
  const Vector3d size_m(2.0 * mug.radius_m, 2.0 * mug.radius_m, mug.height_m);
  return {mug.handle ? "mug with a handle " : "mug ", mug, size_m};
}

Sized some_shape(std::uint32_t kind, Uniform& uniform) {
  const auto sizes = [&] {
    const double x = some_size_m(uniform), y = some_size_m(uniform), z = some_size_m(uniform);
    return Vector3d(x, y, z);
  };
  switch (kind) {
    case 0: {
      const double d_m = some_size_m(uniform);
      return {"sphere ", SphereShape{0.5 * d_m}, Vector3d::Constant(d_m)};
    }
    case 1: {
      const Vector3d size_m = sizes();
      return {"box ", BoxShape{size_m}, size_m};
    }
    case 2: {
      const double d_m = some_size_m(uniform), length_m = some_size_m(uniform);
      return {"cylinder ", CylinderShape{0.5 * d_m, length_m}, {d_m, d_m, length_m}};
    }
    case 3: {
      const Vector3d size_m = sizes();
      return {"ellipsoid ", EllipsoidShape{size_m}, size_m};
    }
    case 4: {
      const Vector3d size_m = sizes();
      const double e1 = between(uniform, 0.2, 1.5), e2 = between(uniform, 0.2, 1.5);
      return {"superquadric ", SuperquadricShape{size_m, {e1, e2}}, size_m};
    }
    case 5:
      return some_mug(uniform);
    default: {
      const double thick_m = between(uniform, 2e-3, 8e-3);
      const double x = some_size_m(uniform, 25e-3), y = some_size_m(uniform, 25e-3);
      return {"plate ", BoxShape{{x, y, thick_m}}, {x, y, thick_m}};
    }
  }
}

/// Whether in a second at rest with this friction no patch slides as a whole by more than 0.1 mm, as in trials.
bool holds(Model model, double friction) {
  constexpr double kMostSlide_m = 0.1e-3;
  model.scene.contact.friction = friction;
  model.scene.task = {};
  State state(model);
  Controller controller(model);
  Frame frame(model);
  ContactMemory memory(model);
  ContactScratch work(model);
  PerFinger<double> slid_m(model.fingers());
  for (int tick = 0; tick < std::lround(1.0 / model.scene.step_s); ++tick) {
    if (control_tick(model, state, controller, frame).grasp != GraspStatus::kOptimal) return false;
    const TickReport report = contact_tick(model, frame, memory, work, state);
    for (int k = 0; k < model.fingers(); ++k) {
      const PatchReport& patch = report.patch[k];
      if (patch.sliding_share > 0.99) slid_m[k] += patch.slip_m;
      if (slid_m[k] > kMostSlide_m || !(state.load[k].normal_N > 0.0)) return false;
    }
  }
  return true;
}

}  // namespace

RandomObject random_object(std::uint32_t seed) {
  constexpr std::uint32_t kKinds = 7;
  Uniform uniform(seed);
  const Sized sized = some_shape(seed % kKinds, uniform);
  RandomObject object{sized.name + in_mm(sized.size_m), sized.shape};
  const Vector3d& s = sized.size_m;
  const double area_m2 = 2.0 * (s.x() * s.y() + s.y() * s.z() + s.z() * s.x());
  object.points = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(area_m2 / kSample_m2), 3000, 30000);
  // As heavy as full ones of wood or plastic, as far as a hand that presses with 2 N can hold that.
  const double volume_m3 = 0.6 * s.x() * s.y() * s.z();
  object.mass_kg = std::clamp(between(uniform, 300.0, 1500.0) * volume_m3, 5e-3, 0.15);
  object.X_OS.linear() =
      Eigen::AngleAxisd(between(uniform, 0.0, std::numbers::pi), some_direction(uniform)).toRotationMatrix();
  object.X_OS.translation() = between(uniform, 0.0, 50e-3) * some_direction(uniform);
  return object;
}

Scene scene_with(Scene scene, const RandomObject& object) {
  scene.name = object.name;
  scene.object.shape = object.shape;
  scene.object.points = object.points;
  scene.object.mass_kg = object.mass_kg;
  const auto* const mug = std::get_if<Mug>(&object.shape);
  scene.object.centre_of_mass_m = object.X_OS * (mug != nullptr ? centroid_m(*mug) : Vector3d(Vector3d::Zero()));
  scene.object.X_WO.setIdentity();
  scene.task = {};
  scene.grasp = GraspWish{};
  return scene;
}

ImplicitSurface surface_of(const Scene& scene, const RandomObject& object) {
  std::vector<std::string> notes;
  const ImplicitSurface made = make_object_surface(scene, notes);
  PointCloud cloud = made.cloud();
  cloud.points_m = (object.X_OS.linear() * cloud.points_m).colwise() + object.X_OS.translation();
  cloud.normals = object.X_OS.linear() * cloud.normals;
  ImplicitSurface surface(cloud, made.support_m());
  double radius_m = 0.0;
  for (const Fingertip& tip : scene.hand.fingertips) radius_m = std::max(radius_m, tip.radius_m);
  surface.allow_error(scene.contact.distance_error_m, kTrustPerRadius * radius_m + scene.contact.band_m);
  return surface;
}

Model model_with(const Scene& scene, const ImplicitSurface& surface, const FoundGrasp& grasp) {
  Scene taken = scene;
  take_grasp(grasp, taken);
  return surface_model(taken, surface);
}

HoldTrial carry_and_push(Model model, const Vector3d& way_W, std::uint32_t seed) {
  constexpr double kFirst_s = 0.02;
  Uniform uniform(seed);
  Scene& scene = model.scene;
  const Eigen::Matrix3d R_OW = scene.object.X_WO.linear().transpose();
  scene.task.translate = Move{R_OW * way_W, 20e-3, 0.3, 0.8};
  scene.task.push = Push{.force_N = 0.5 * some_direction(uniform), .from_s = 1.3, .over_s = 0.3};
  scene.task.push->at_m = scene.object.centre_of_mass_m;
  scene.duration_s = 1.8;
  HoldTrial trial;
  State state(model);
  const Recording run = run_scene(model, state);
  trial.verdict = run.verdict;
  for (const TickRecord& tick : run.ticks) {
    if (tick.is_from(kFirst_s)) break;
    trial.first_move_m = std::max(trial.first_move_m, tick.position_m.norm());
    for (std::size_t k = 0; k < tick.force.size(); ++k) {
      const double wanted_N = tick.force_desired[k].normal_N;
      const double share = std::abs(tick.force[k].normal_N - wanted_N) / std::max(wanted_N, 1e-3);
      trial.first_load = std::max(trial.first_load, share);
    }
  }
  return trial;
}

double least_friction(const Model& model, double low, double high) {
  while (high > 1.01 * low) {
    const double middle = std::sqrt(low * high);
    (holds(model, middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace thenar
