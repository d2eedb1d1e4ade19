// SPDX-License-Identifier: Apache-2.0
// Contacts that finding by points can miss: plates thinner than a pulp gives way, needles and rims finer than the
// spacing of control points, edges. One finger, the thumb, which nothing moves, against an object that moves as its
// damping lets it and does not turn.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "collision/fine_parts.h"
#include "collision/shapes.h"
#include "engine/formats/ply_file.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::hard_contacts_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Scene thumb_against(const Shape& shape, Index points) {
  Scene scene = scene_of("box_grasp", {"object.points=500"});
  scene.control.reset();
  scene.task = {};
  scene.torques = scene.hand.at_zero();
  scene.gravity.setZero();
  scene.joint_viscosity = 1e9;
  scene.object.shape = shape;
  scene.object.points = points;
  scene.object.rotation_damping = 1e9;
  return scene;
}

/// The thumb's pulp in the world: its centre, and its mean outward direction.
struct Thumb {
  explicit Thumb(const Scene& scene) : radius_m(scene.hand.fingertips[0].radius_m) {
    HandPose pose;
    forward_kinematics(scene.hand, scene.posture, pose);
    const Isometry3d& X_WF = pose.distal(scene.hand, 0);
    centre_m = X_WF * scene.hand.fingertips[0].centre_m;
    normal = X_WF.linear() * scene.hand.fingertips[0].normal;
  }
  double radius_m;
  Vector3d centre_m, normal;
};

/// Axes with this z and a random turn about it.
Matrix3d axes_with_z(const Vector3d& z, std::mt19937_64& random) {
  Matrix3d R;
  R.col(2) = z;
  R.col(0) = z.unitOrthogonal();
  R.col(1) = z.cross(R.col(0));
  return R * AngleAxisd(uniform(random, 0.0, 6.28), Vector3d::UnitZ()).toRotationMatrix();
}

/// A direction up to `most_rad` from that in which the thumb's pulp faces.
Vector3d facing(const Thumb& thumb, double most_rad, std::mt19937_64& random) {
  const Vector3d across = thumb.normal.cross(random_direction(random)).normalized();
  return AngleAxisd(uniform(random, 0.0, most_rad), across) * thumb.normal;
}

/// Poses the object so that the pulp's lowest point, along the axis z of A, is `gap_m` above the object's point p_O.
void place(const Thumb& thumb, const Matrix3d& A, const Matrix3d& R_AO, const Vector3d& p_O, double gap_m,
           Scene& scene) {
  Isometry3d& X_WO = scene.object.X_WO;
  X_WO.linear() = A * R_AO;
  X_WO.translation() = thumb.centre_m - (thumb.radius_m + gap_m) * A.col(2) - X_WO.linear() * p_O;
}

/// The object is pushed with `force_N`, and free it moves with `speed`.
void push(const Vector3d& direction, double force_N, double speed, Scene& scene) {
  scene.object.translation_damping = force_N / speed;
  scene.gravity = force_N / scene.object.mass_kg * direction;
}

/// How far the pulp's centre is above the object's origin, and what presses the thumb off, both along z of the object.
struct Pressed {
  double height_m, force_N;
};
Pressed pressed(const State& state, const Thumb& thumb) {
  return {(state.X_WO.inverse() * thumb.centre_m).z(), -(state.X_WO.linear().transpose() * state.load[0].force_N).z()};
}

// --- thin plates -----------------------------------------------------------------------------------------------------

/// The frames of a run.
struct Frames {
  double step_s, period_s, delay_s;
};

struct Met {
  double least_N = 1.0, last_N = 0.0;  ///< What presses the thumb off.
  double deepest_m = 0.0;
};

/// The thumb meets a plate at 0.5 m/s, 0.5 to 12 mm off, tilted by up to 20 degrees, and presses with 2 N. Where on the
/// plate: near its middle, or at this x.
Met meet(Model model, double thickness_m, const Frames& frames, std::uint64_t seed, std::optional<double> at_x_m = {}) {
  std::mt19937_64 random(seed);
  Scene& scene = model.scene;
  scene.step_s = frames.step_s;
  scene.control_period_s = frames.period_s;
  scene.control_delay_s = frames.delay_s;
  const Thumb thumb(scene);
  const Matrix3d A = axes_with_z(-facing(thumb, 0.35, random), random);
  double x_m = uniform(random, -5e-3, 5e-3), y_m = uniform(random, -5e-3, 5e-3);
  x_m = at_x_m.value_or(x_m);
  place(thumb, A, Matrix3d::Identity(), {x_m, y_m, 0.5 * thickness_m}, uniform(random, 0.5e-3, 12e-3), scene);
  push(A.col(2), 2.0, 0.5, scene);
  GraspRun loops(model, LockstepSettings{});
  if (frames.delay_s == 0.0) loops.memory.policy = {};  // one loop
  Met met;
  while (static_cast<double>(loops.state.tick) * frames.step_s < 0.15) {
    loops.tick();
    const Pressed now = pressed(loops.state, thumb);
    met.least_N = std::min(met.least_N, now.force_N);
    met.deepest_m = std::max(met.deepest_m, thumb.radius_m + 0.5 * thickness_m - now.height_m);
    met.last_N = now.force_N;
  }
  return met;
}

/// Pressed in by 1.6 mm, several times the plate's half thickness, all points that touch are nearer to its back.
void expect_met(const Model& model, double thickness_m, const Frames& frames, std::uint64_t seed) {
  SCOPED_TRACE(testing::Message() << "plate " << thickness_m << ", step " << frames.step_s << ", period "
                                  << frames.period_s << ", delay " << frames.delay_s << ", seed " << seed);
  const Met met = meet(model, thickness_m, frames, seed);
  EXPECT_GE(met.least_N, -1e-6) << "pulled in";
  // At rest the pulp carries the push. Hertz: 1.63 mm deep; the control points make it up to a tenth more or less, and
  // a hasty first touch, which the relaxation of 2 ms stiffens, no more.
  const double depth_m = std::pow(2.0 / (4.0 / 3.0 * 0.24e6 * std::sqrt(Thumb(model.scene).radius_m)), 2.0 / 3.0);
  EXPECT_NEAR(met.last_N, 2.0, 1e-4);
  EXPECT_NEAR(met.deepest_m, depth_m, 0.15 * depth_m);
}

class ThinPlate : public testing::TestWithParam<double> {};

TEST_P(ThinPlate, IsNeverTunnelled) {
  const double thickness_m = GetParam();
  const Model model = build_model(thumb_against(BoxShape{{30e-3, 30e-3, thickness_m}}, 3500));
  std::uint64_t seed = 1;
  for (const double period_s : {1e-3, 2e-3, 5e-3, 10e-3, 20e-3}) {
    expect_met(model, thickness_m, {period_s, period_s, 0.0}, seed++);
    expect_met(model, thickness_m, {1e-3, period_s, period_s}, seed++);
  }
}
INSTANTIATE_TEST_SUITE_P(Thickness, ThinPlate, testing::Values(1e-3, 0.5e-3));

// --- a constant force ------------------------------------------------------------------------------------------------

// Nothing flickers: a pad under a constant load keeps its contacts, and what it carries, from half a second on.
TEST(Hold, ContactsAndForceStayUnderAConstantLoad) {
  Scene scene = pressed_thumb(1e-3, {-1.0, 0.0, 0.0}, 1.0);
  scene.step_s = 1e-3;
  scene.control_period_s = 5e-3;
  Loop loop(std::move(scene));
  loop.run(0.5);
  const auto points = [&] {
    std::vector<Index> ids;
    for (const FrameContact& contact : loop.frame.contacts) ids.push_back(contact.control_point);
    return ids;
  };
  const std::vector<Index> first = points();
  double sum_N = 0.0, squares = 0.0;
  int ticks = 0;
  for (; loop.state.tick < 10'000; ++ticks) {
    loop.tick();
    ASSERT_EQ(points(), first) << loop.state.tick;
    const double off_N = loop.state.load[0].normal_N - 1.0;
    sum_N += off_N;
    squares += off_N * off_N;
  }
  const double mean_N = sum_N / ticks;
  EXPECT_NEAR(mean_N, 0.0, 1e-3);
  EXPECT_LE(std::sqrt(std::max(0.0, squares / ticks - mean_N * mean_N)), 1e-3);
}

// --- edges -----------------------------------------------------------------------------------------------------------

struct Slid {
  double grip_N = 0.0;   ///< Before the edge comes.
  double least_N = 1.0;  ///< What presses the thumb off.
  double last_N = 1.0;
  double step_N = 0.0;  ///< The largest in a tick, from when the pulp has relaxed on.
};

/// The object is moved under the thumb at 20 mm/s, whatever the contact: 1 mm deep, from 5 mm before p_O to 9 mm past
/// it, with R_AO its axes: z up to the thumb, x along the way.
Slid slide(const Model& clamped, const Matrix3d& R_AO, const Vector3d& p_O, const Vector3d& way_A, std::uint64_t seed) {
  Model model = clamped;
  Scene& scene = model.scene;
  std::mt19937_64 random(seed);
  const Thumb thumb(scene);
  const Matrix3d A = axes_with_z(-facing(thumb, 0.2, random), random);
  scene.step_s = scene.control_period_s = 1e-3;
  place(thumb, A, R_AO, p_O, -1e-3, scene);
  scene.object.X_WO.translation() += 5e-3 * (A * way_A);
  push(-(A * way_A), 20e3, 20e-3, scene);
  GraspRun loops(model, LockstepSettings{});
  Slid slid;
  Vector3d before_N = Vector3d::Zero();
  while (loops.state.tick < 700) {
    loops.tick();
    const Vector3d force_N = A.transpose() * loops.state.load[0].force_N;
    if (loops.state.tick == 30) slid.grip_N = force_N.norm();  // the pulp has relaxed
    if (loops.state.tick > 30) slid.step_N = std::max(slid.step_N, (force_N - before_N).norm());
    before_N = force_N;
    slid.last_N = -force_N.z();
    slid.least_N = std::min(slid.least_N, slid.last_N);
  }
  return slid;
}

// Off a face over its edge, on a box and on plates: the thumb is never pulled in, and comes free. A control point
// carries up to a tenth of the grip, and the last ones go within a few ticks: the force moves by no more than that, and
// a half.
TEST(Edge, APadSlidesOffWithoutAPull) {
  for (const double thickness_m : {10e-3, 1e-3, 0.5e-3}) {
    const Vector3d size_m(24e-3, 24e-3, thickness_m);
    Scene scene = thumb_against(BoxShape{size_m}, 5000);
    scene.contact.friction = 0.0;
    const Model model = build_model(std::move(scene));
    for (const std::uint64_t seed : {1u, 2u}) {
      SCOPED_TRACE(testing::Message() << "thickness " << thickness_m << ", seed " << seed);
      const Slid slid = slide(model, Matrix3d::Identity(), {12e-3, 2e-3, 0.5 * thickness_m}, Vector3d::UnitX(), seed);
      EXPECT_GT(slid.grip_N, 0.5);
      EXPECT_GE(slid.least_N, -1e-9);
      EXPECT_EQ(slid.last_N, 0.0);
      EXPECT_LT(slid.step_N, 0.15 * slid.grip_N);
    }
  }
}

// A half of the pulp over an edge, or less: what an old frame's cells do not touch yet they touch before the next one.
// Late frames let the pulp in by a fifth more at first, as they do on a face.
TEST(Edge, IsMetAtSpeed) {
  for (const double thickness_m : {10e-3, 1e-3}) {
    const Model model = build_model(thumb_against(BoxShape{{30e-3, 30e-3, thickness_m}}, 3500));
    for (const double x_m : {13e-3, 14e-3, 14.8e-3, 15e-3}) {
      const Met prompt = meet(model, thickness_m, {1e-3, 1e-3, 0.0}, 1, x_m);
      for (const double period_s : {10e-3, 20e-3}) {
        SCOPED_TRACE(testing::Message() << "plate " << thickness_m << ", at " << x_m << ", period " << period_s);
        const Met late = meet(model, thickness_m, {1e-3, period_s, period_s}, 1, x_m);
        EXPECT_GE(late.least_N, -1e-6);
        EXPECT_LT(late.deepest_m, 1.3 * prompt.deepest_m);
        EXPECT_NEAR(late.last_N, 2.0, 0.02);
      }
    }
  }
}

// On an edge of 90 degrees that looks at the thumb, and along it, to where it ends under the pulp: it is carried all
// the way. Four control points carry it 1 mm deep, of which the one that comes off the end takes its share with it: a
// quarter.
TEST(Edge, CarriesAPadOnIt) {
  const Model model = build_model(thumb_against(BoxShape{{24e-3, 24e-3, 10e-3}}, 5000));
  Matrix3d R_AO;  // columns: the object's axes; its edge between +x and +z is up
  R_AO.col(0) = Vector3d(-1.0, 0.0, 1.0).normalized();
  R_AO.col(2) = Vector3d(1.0, 0.0, 1.0).normalized();
  R_AO.col(1) = R_AO.col(2).cross(R_AO.col(0));
  for (const std::uint64_t seed : {1u, 2u}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Slid slid = slide(model, R_AO, {12e-3, -2e-3, 5e-3}, Vector3d::UnitY(), seed);
    EXPECT_GT(slid.least_N, 0.1 * slid.grip_N);
    EXPECT_LT(slid.step_N, 0.25 * slid.grip_N);
  }
}

// --- finer than control points
// -----------------------------------------------------------------------------------------

/// As a model has it.
PointCloud in_tree_order(const PointCloud& cloud) { return ImplicitSurface(cloud).cloud(); }

/// A needle along z with a round tip at the origin.
PointCloud needle(double radius_m, double length_m, double spacing_m) {
  std::vector<Vector3d> points, normals;
  const auto ring = [&](double z_m, double r_m, const Vector3d& tilt) {
    const auto count = std::max<Index>(1, std::lround(2.0 * std::numbers::pi * r_m / spacing_m));
    for (Index i = 0; i < count; ++i) {
      const double angle = 2.0 * std::numbers::pi *
                           (static_cast<double>(i) + 0.5 * static_cast<double>(points.size() % 2)) /
                           static_cast<double>(count);
      const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
      points.emplace_back(r_m * out + z_m * Vector3d::UnitZ());
      normals.emplace_back((tilt.x() * out + tilt.z() * Vector3d::UnitZ()).normalized());
    }
  };
  const auto rings = std::lround(0.5 * std::numbers::pi * radius_m / spacing_m);
  for (long i = 0; i < rings; ++i) {
    const double polar = 0.5 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(rings);
    ring(radius_m * (std::cos(polar) - 1.0), radius_m * std::sin(polar), {std::sin(polar), 0.0, std::cos(polar)});
  }
  for (double z_m = -radius_m; z_m > -length_m; z_m -= spacing_m) ring(z_m, radius_m, Vector3d::UnitX());
  PointCloud cloud{Eigen::Matrix3Xd(3, points.size()), Eigen::Matrix3Xd(3, points.size())};
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.points_m.col(static_cast<Index>(i)) = points[i];
    cloud.normals.col(static_cast<Index>(i)) = normals[i];
  }
  return cloud;
}

// A needle of 0.5 mm fits between control points, 1.8 mm apart, everywhere. Wherever it meets the pulp it is caught,
// and pressed in as Hertz has a ball of its tip's radius: 0.2 N = 4/3 E* sqrt(R) d^1.5 with 1/R = 1/r + 1/R_pulp.
TEST(Needle, IsCaughtBetweenControlPoints) {
  const auto file = scratch() / "needle.ply";
  save_ply(file, needle(0.25e-3, 12e-3, 0.08e-3), PlyFormat::kBinaryLittleEndian);
  Model model = build_model(thumb_against(CloudShape{file}, 0));
  ASSERT_GT(model.fine_m.cols(), 20);
  const Thumb thumb(model.scene);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const Matrix3d A = axes_with_z(-facing(thumb, 1.0, random), random);
    place(thumb, A, Matrix3d::Identity(), Vector3d::Zero(), 1e-3, model.scene);
    push(A.col(2), 0.2, 50e-3, model.scene);
    model.scene.step_s = 1e-3;
    model.scene.control_period_s = 5e-3;
    Loop loop(model.scene);
    loop.run(0.15);
    const Pressed now = pressed(loop.state, thumb);
    EXPECT_NEAR(now.force_N, 0.2, 2e-3);
    const double round_m = 1.0 / (1.0 / 0.25e-3 + 1.0 / thumb.radius_m);
    const double hertz_m =
        std::pow(0.75 * 0.2 / (model.pulps[0].material.reduced_modulus_Pa * std::sqrt(round_m)), 2.0 / 3.0);
    EXPECT_NEAR((thumb.radius_m - now.height_m) / hertz_m, 1.0, 0.05) << "the tip's depth";
  }
}

// What has faces wider than the spacing of control points, edges and corners included, has no fine parts, at any
// density: nothing is looked for.
TEST(FineParts, AreNoneOnBoxesAndSpheres) {
  constexpr double kControls_m = 1.8e-3;
  for (const Index points : {1500, 6000, 20'000}) {
    SCOPED_TRACE(points);
    EXPECT_EQ(fine_parts(in_tree_order(sample_box({50e-3, 50e-3, 50e-3}, points)), kControls_m).size(), 0);
    EXPECT_EQ(fine_parts(in_tree_order(sample_sphere(20e-3, points)), kControls_m).size(), 0);
  }
}

// Of a plate it is the rim.
TEST(FineParts, AreTheRimOfAThinPlate) {
  const Vector3d half_m(15e-3, 15e-3, 0.25e-3);
  const PointCloud plate = in_tree_order(sample_box(2.0 * half_m, 6000));
  const std::vector<Index> fine = fine_parts(plate, 1.8e-3);
  EXPECT_GT(fine.size(), 40);
  for (const Index i : fine) {
    const Vector3d s_m = plate.points_m.col(i);
    EXPECT_GT((s_m.cwiseAbs() - half_m).head<2>().maxCoeff(), -1e-9) << s_m.transpose();
  }
}

// Whatever the spacing of control points is to that of samples, fine are only samples near the rim.
TEST(FineParts, AreNeverTheMiddleOfAThinPlate) {
  const Eigen::Vector3d size_m(60e-3, 1e-3, 60e-3);
  const PointCloud plate = sample_box(size_m, 20000);
  for (const double spacing_m : {1e-3, 1.5e-3, 2e-3, 3e-3, 5e-3, 8e-3}) {
    for (const Index i : fine_parts(plate, spacing_m)) {
      const Vector3d s_m = plate.points_m.col(i);
      const double to_rim_m = 0.5 * size_m.x() - std::max(std::abs(s_m.x()), std::abs(s_m.z()));
      ASSERT_LT(to_rim_m, spacing_m) << "spacing " << spacing_m;
    }
  }
}

}  // namespace
}  // namespace thenar::hard_contacts_test
