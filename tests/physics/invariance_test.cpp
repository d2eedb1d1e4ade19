// SPDX-License-Identifier: Apache-2.0
// Nothing depends on where the world's axes are, on left and right, or on the units that lengths, forces and times
// are in.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>

#include "bench/cases/pads.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::invariance_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// --- What a run leaves ----------------------------------------------------------------------------------------------

/// In object axes, or against the object's pose at the start.
struct Outcome {
  Isometry3d X_OO = Isometry3d::Identity();  ///< How the object has moved, in its axes at the start.
  JointVector q;
  Eigen::Array3d slip_m = Eigen::Array3d::Zero(),
                 spin_rad = Eigen::Array3d::Zero();  ///< A finger each, summed over ticks.
  Eigen::Array3d margin;                             ///< At the end.
  Eigen::Matrix3d force_N, centre_m;                 ///< A column a finger, at the end.
};

Outcome run(Model model, double duration_s) {
  // The solver stops where forces err by less than what is tested for.
  model.scene.contact.tolerance = 1e-13;
  model.scene.contact.max_sweeps = 2000;
  Loop loop(std::move(model));
  Outcome outcome;
  while (static_cast<double>(loop.state.tick) * loop.model.scene.step_s < duration_s) {
    const TickReport tick = loop.tick();
    for (int k = 0; k < kFingers; ++k) {
      outcome.slip_m[k] += tick.patch[k].slip_m;
      outcome.spin_rad[k] += std::abs(tick.patch[k].spin_rad);
      outcome.margin[k] = tick.patch[k].margin;
    }
  }
  const State& state = loop.state;
  outcome.X_OO = loop.model.scene.object.X_WO.inverse() * state.X_WO;
  outcome.q = state.q;
  for (int k = 0; k < kFingers; ++k) {
    outcome.force_N.col(k) = state.X_WO.linear().transpose() * state.load[k].force_N;
    outcome.centre_m.col(k) = state.X_WO.inverse() * state.load[k].centre_m;
  }
  return outcome;
}

/// How far two outcomes are apart, over the second's size, by quantity; a turn [rad] and slides [m].
std::map<std::string, double> differences(const Outcome& a, const Outcome& b) {
  const auto relative = [](const auto& x, const auto& y) { return (x - y).matrix().norm() / y.matrix().norm(); };
  return {{"motion", relative(a.X_OO.translation(), b.X_OO.translation())},
          {"turn", (a.X_OO.linear() - b.X_OO.linear()).norm()},
          {"joints", (a.q - b.q).norm()},
          {"slip", relative(a.slip_m, b.slip_m)},
          {"spin", relative(a.spin_rad, b.spin_rad)},
          {"margin", relative(a.margin, b.margin)},
          {"force", relative(a.force_N, b.force_N)},
          {"pressure centre", relative(a.centre_m, b.centre_m)}};
}

/// To 1e-9; slip and spin are sums of sizes, in which the rounding of places adds up, too: 150 ticks of 4e-16 m, for
/// places up to 2 m off, are 6e-14 m, and over the 1 mm that a patch measures 6e-11 rad, of some 0.1 mm and 0.01 rad.
void expect_same(const Outcome& a, const Outcome& b) {
  for (const auto& [what, difference] : differences(a, b)) {
    EXPECT_LE(difference, what == "slip" || what == "spin" ? 1e-8 : 1e-9) << what;
  }
}

/// A ball whose weight is eccentric: its pads slip and turn until they hold it.
Pads eccentric_ball() {
  Pads pads = pads_round(SphereShape{25e-3}, 25e-3);
  pads.friction = 0.4;
  pads.centre_of_mass_m = {8e-3, 3e-3, -2e-3};
  return pads;
}

constexpr double kRun_s = 0.15;

// --- Rotation and translation ---------------------------------------------------------------------------------------

/// The scene with hand, object and gravity moved by X.
Scene moved(Scene scene, const Isometry3d& X) {
  for (Joint& joint : scene.hand.joints) {
    joint.axis = X.linear() * joint.axis;
    joint.origin_m = X * joint.origin_m;
  }
  for (Segment& segment : scene.hand.segments) segment.X_WS_0 = X * segment.X_WS_0;
  scene.object.X_WO = X * scene.object.X_WO;
  scene.gravity = X.linear() * scene.gravity;
  return scene;
}

// A metre away, places are rounded to 1e-16 m, a 1e-12th of a pulp's depth; 1e-9 leaves 3 digits for what a run
// makes of it.
TEST(Invariance, RotationAndTranslationChangeNothing) {
  std::mt19937_64 random(1);
  Isometry3d X = Isometry3d::Identity();
  X.linear() = random_rotation(random);
  X.translation() = random_direction(random);
  Scene soft = scene_of(eccentric_ball());
  soft.object.compliance = PulpMaterial{1e6, 0.5, 5e-3};
  for (const Scene& scene : {scene_of(eccentric_ball()), soft, scene_of("mug", {"object.points=12000"}),
                             scene_of("box_grasp", {kCoarseBox})}) {
    SCOPED_TRACE(scene.name);
    expect_same(run(build_model(moved(scene, X)), kRun_s), run(build_model(scene), kRun_s));
  }
}

// --- Mirroring ------------------------------------------------------------------------------------------------------

const Matrix3d kMirror = Vector3d(-1.0, 1.0, 1.0).asDiagonal();

Isometry3d mirrored(const Isometry3d& X) {
  Isometry3d image = X;
  image.linear() = kMirror * X.linear() * kMirror;
  image.translation() = kMirror * X.translation();
  return image;
}

/// Hand, object and gravity in a mirror across x; bodies' frames stay right-handed, and have their x the other way. The
/// samples of surfaces are what the image's own frames give.
Scene mirrored(Scene scene) {
  for (Joint& joint : scene.hand.joints) {
    joint.axis = kMirror * joint.axis;  // Of a slide.
    joint.origin_m = kMirror * joint.origin_m;
  }
  for (Segment& segment : scene.hand.segments) segment.X_WS_0 = mirrored(segment.X_WS_0);
  for (Fingertip& tip : scene.hand.fingertips) {
    tip.centre_m = kMirror * tip.centre_m;
    tip.normal = kMirror * tip.normal;
  }
  scene.object.X_WO = mirrored(scene.object.X_WO);
  scene.object.centre_of_mass_m = kMirror * scene.object.centre_of_mass_m;
  scene.gravity = kMirror * scene.gravity;
  return scene;
}

/// The model in a mirror, with the images of its samples.
Model mirrored(const Model& model) {
  Model image = build_model(mirrored(model.scene), model);
  PointCloud cloud = model.object.cloud();
  cloud.points_m = kMirror * cloud.points_m;
  cloud.normals = kMirror * cloud.normals;
  image.object = ImplicitSurface(cloud, model.object.support_m());
  image.pulps = model.pulps;
  for (Pulp& pulp : image.pulps) {
    pulp.surface.points_m = kMirror * pulp.surface.points_m;
    pulp.surface.normals = kMirror * pulp.surface.normals;
    pulp.centre_m = kMirror * pulp.centre_m;
    pulp.control_points_m = kMirror * pulp.control_points_m;
    pulp.control_normals = pulp.control_normals * kMirror;
  }
  return image;
}

/// What the mirror shows of an outcome: an image of its image, it is the outcome.
Outcome mirrored(Outcome outcome) {
  outcome.X_OO = mirrored(outcome.X_OO);
  outcome.force_N = kMirror * outcome.force_N;
  outcome.centre_m = kMirror * outcome.centre_m;
  return outcome;
}

// With images of all samples, an image's run is the image of the run, to rounding. With samples of its own it differs
// by what samples do.
TEST(Invariance, MirroringChangesNothingButTheSamples) {
  Scene scene = scene_of(eccentric_ball());
  scene.contact.distance_error_m = 0.0;  // axes of patches have no image
  const Model model = build_model(scene);
  const Outcome original = run(model, kRun_s);
  expect_same(mirrored(run(mirrored(model), kRun_s)), original);
  auto of_samples = differences(mirrored(run(build_model(mirrored(model.scene)), kRun_s)), original);
  for (const auto& [what, difference] : of_samples) RecordProperty(what, std::to_string(difference));
  EXPECT_GE(of_samples["force"], 1e-9);
  EXPECT_LE(of_samples["force"], 0.1);
  EXPECT_LE(of_samples["pressure centre"], 0.1);
}

// --- Scaling --------------------------------------------------------------------------------------------------------

/// Lengths, forces and times as so many of the scene's.
struct Scales {
  double length, force, time;
};

/// A scene of pads on a sphere, with the same numbers in other units: its dimensionless numbers stay.
Scene scaled(Scene scene, const Scales& by) {
  const double moment = by.force * by.length, pressure = by.force / (by.length * by.length);
  const auto scale_material = [&](PulpMaterial& material) {
    material.reduced_modulus_Pa *= pressure;
    material.relaxation_s *= by.time;
  };
  scene.step_s *= by.time;
  scene.control_period_s *= by.time;
  for (Joint& joint : scene.hand.joints) {
    joint.origin_m *= by.length;
    joint.lower_rad *= by.length;  // Of a slide, in metres.
    joint.upper_rad *= by.length;
  }
  for (Segment& segment : scene.hand.segments) segment.X_WS_0.translation() *= by.length;
  for (Fingertip& tip : scene.hand.fingertips) {
    tip.centre_m *= by.length;
    tip.radius_m *= by.length;
    *tip.joint_viscosity *= by.force / by.length * by.time;
  }
  for (Slide& slide : scene.slides) slide.force_N *= by.force;
  scale_material(scene.fingertips->material);
  std::get<SphereShape>(scene.object.shape).radius_m *= by.length;
  scene.object.mass_kg *= by.force;  // In the same gravity.
  scene.object.X_WO.translation() *= by.length;
  scene.object.centre_of_mass_m *= by.length;
  scene.object.translation_damping *= by.force / by.length * by.time;
  scene.object.rotation_damping *= moment * by.time;
  if (scene.object.compliance) scale_material(*scene.object.compliance);
  scene.contact.band_m *= by.length;
  return scene;
}

/// Of the scene in those units.
Outcome scaled(Outcome outcome, const Scales& by) {
  outcome.X_OO.translation() *= by.length;
  outcome.q *= by.length;
  outcome.slip_m *= by.length;
  outcome.force_N *= by.force;
  outcome.centre_m *= by.length;
  return outcome;
}

TEST(Invariance, ScalingChangesNothing) {
  const Scene scene = scene_of(eccentric_ball());
  const Outcome original = run(build_model(scene), kRun_s);
  for (const Scales& by :
       {Scales{3.7, 1.0, 1.0}, Scales{1.0, 0.21, 1.0}, Scales{1.0, 1.0, 5.3}, Scales{0.6, 7.0, 0.3}}) {
    SCOPED_TRACE(std::to_string(by.length) + " " + std::to_string(by.force) + " " + std::to_string(by.time));
    expect_same(run(build_model(scaled(scene, by)), kRun_s * by.time), scaled(original, by));
  }
}

}  // namespace
}  // namespace thenar::invariance_test
