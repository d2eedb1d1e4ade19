// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/patches.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::patches_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kStep_s = 1e-3, kMu = 0.8;

/// A flat patch, z its normal; forces are normal alone until they are set.
struct Patch {
  std::vector<PatchPoint> points;
  FingerLoad load;

  void add(const Vector3d& at, double normal_N) {
    const Vector3d zero = Vector3d::Zero();
    points.push_back({0, zero, zero, zero, at, {0.0, 0.0, normal_N}, normal_N, 0.0, zero});
  }
  /// Takes places from the pressure centre.
  void centre() {
    Vector3d centre = Vector3d::Zero();
    double normal_N = 0.0;
    for (const PatchPoint& point : points) {
      centre += point.normal_N * point.r_W;
      normal_N += point.normal_N;
    }
    for (PatchPoint& point : points) point.r_W -= centre / normal_N;
    load.normal_N = normal_N;
    load.normal = Vector3d::UnitZ();
  }
  /// Full friction against a slide with the instantaneous centre `pole`.
  void slide_about(const Vector3d& pole) {
    for (PatchPoint& point : points) {
      const Vector3d way = Vector3d::UnitZ().cross(point.r_W - pole);
      const Vector3d friction = kMu * point.normal_N * way.stableNormalized();
      point.f_W = friction + point.normal_N * Vector3d::UnitZ();
    }
    sum_forces();
  }
  void sum_forces() {
    load.force_N.setZero();
    for (const PatchPoint& point : points) load.force_N += point.f_W;
  }
  [[nodiscard]] PatchReport report(double mu = kMu) {
    for (PatchPoint& point : points) point.friction_N = point.f_W.head<2>().norm();
    return patch_report(points, load, mu, kStep_s);
  }
};

/// Points of equal force F / n under Hertz's pressure on a disc of radius a, spread as a sunflower's seeds are.
Patch hertz_patch(int n, double a_m, double force_N) {
  Patch patch;
  for (int i = 0; i < n; ++i) {
    // Inside of r lies the share 1 - (1 - r^2 / a^2)^1.5 of the force.
    const double share = (i + 0.5) / n, r = a_m * std::sqrt(1.0 - std::pow(1.0 - share, 2.0 / 3.0));
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    patch.add({r * std::cos(angle), r * std::sin(angle), 0.0}, force_N / n);
  }
  patch.centre();
  return patch;
}

Patch random_patch(std::mt19937_64& random) {
  Patch patch;
  for (int i = 0; i < 12; ++i) {
    patch.add({uniform(random, -3e-3, 3e-3), uniform(random, -3e-3, 3e-3), 0.0}, uniform(random, 0.01, 0.3));
  }
  patch.centre();
  return patch;
}

// A patch that moves as a rigid plate: its slip is the way of the pressure centre, its spin the plate's turn about the
// normal, whatever the pressure; the dent of an object that gives way evenly is that way. Rounding of 12 terms, divided
// by places of millimetres.
TEST(PatchReport, SlipAndSpinOfARigidPlateAreItsWayAndTurn) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    Patch patch = random_patch(random);
    const Vector3d way(uniform(random, -1e-5, 1e-5), uniform(random, -1e-5, 1e-5), 0.0);
    const double turn = uniform(random, -1e-3, 1e-3);
    const Vector3d dent(1e-4, 2e-4, 5e-4);
    for (PatchPoint& point : patch.points) {
      point.d_W = way + turn * Vector3d::UnitZ().cross(point.r_W);
      point.u_end_O = dent;
    }
    patch.sum_forces();
    const PatchReport report = patch.report();
    EXPECT_LE((report.slip_W - way).norm(), 1e-18);
    EXPECT_NEAR(report.slip_m, way.norm(), 1e-18);
    EXPECT_NEAR(report.spin_rad, turn, 1e-15);
    EXPECT_LE((report.dent_O - dent).norm(), 1e-18);
  }
}

// The turn is the one that leaves the least sum of f_n |d - v - w n x r|^2: a little more or less leaves more.
TEST(PatchReport, SpinIsTheLeastSquaresTurn) {
  std::mt19937_64 random(2);
  Patch patch = random_patch(random);
  Vector3d slip = Vector3d::Zero();
  for (PatchPoint& point : patch.points) {
    point.d_W = Vector3d(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), 0.0) * 1e-5;
    slip += point.normal_N / patch.load.normal_N * point.d_W;
  }
  patch.sum_forces();
  const double spin = patch.report().spin_rad;
  const auto left = [&](double turn) {
    double sum = 0.0;
    for (const PatchPoint& p : patch.points) {
      sum += p.normal_N * (p.d_W - slip - turn * Vector3d::UnitZ().cross(p.r_W)).squaredNorm();
    }
    return sum;
  };
  EXPECT_GT(std::abs(spin), 1e-4);
  EXPECT_LT(left(spin), left(1.01 * spin));
  EXPECT_LT(left(spin), left(0.99 * spin));
}

// Half of the force on points that slide, a quarter on points that rest on their cones, a quarter on ones that stick
// but for a creep.
TEST(PatchReport, TellsPointsThatSlideFromThoseThatCreep) {
  Patch patch;
  for (int i = 0; i < 4; ++i) patch.add({1e-3 * i, 0.0, 0.0}, 0.1);
  patch.centre();
  const double limit_N = kMu * 0.1;
  for (int i : {0, 1, 2}) patch.points[i].f_W.x() = limit_N;
  patch.points[3].f_W.x() = 0.99 * limit_N;
  for (int i : {0, 1}) patch.points[i].d_W.x() = 1e-5;
  patch.points[2].d_W.x() = 0.5 * kMoves_m_per_s * kStep_s;
  patch.points[3].d_W.y() = 3e-7;
  patch.sum_forces();
  const PatchReport report = patch.report();
  EXPECT_NEAR(report.sliding_share, 0.5, 1e-15);
  EXPECT_NEAR(report.creep_m_per_s, 3e-4, 1e-18);
}

TEST(PatchMargin, IsZeroWhereThePatchSlidesOrTurnsAsAWhole) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    Patch patch = random_patch(random);
    patch.slide_about({1e6, 0.0, 0.0});
    EXPECT_NEAR(patch.report().margin, 0.0, 1e-8);
  }
  // A turn about the centre leaves no resultant where the pressure has an axis.
  Patch hertz = hertz_patch(4000, 2e-3, 1.0);
  hertz.slide_about(Vector3d::Zero());
  EXPECT_NEAR(hertz.report().margin, 0.0, 1e-5);
}

TEST(PatchMargin, OfAPointIsThatOfItsFrictionCone) {
  Patch patch;
  patch.add(Vector3d(1.0, 2.0, 3.0), 0.5);
  patch.centre();
  patch.points[0].f_W.x() = 0.3;
  patch.sum_forces();
  const PatchReport report = patch.report();
  EXPECT_DOUBLE_EQ(report.margin, 1.0 - 0.3 / (kMu * 0.5));
  EXPECT_EQ(report.moment_Nm, 0.0);
  EXPECT_EQ(report.moment_limit_Nm, 0.0);
  EXPECT_TRUE(std::isnan(patch.report(0.0).margin));
  EXPECT_TRUE(std::isnan(patch_report({}, FingerLoad{}, kMu, kStep_s).margin));
}

// The most torsion that Hertz's pressure carries is 3 pi / 16 mu F a: half of it leaves half of the margin. A disc of n
// points errs by 1 / n of its force at the rim.
TEST(PatchMargin, TorsionOfAHertzPatchIsMeasuredByItsLimit) {
  const double a_m = 2e-3, force_N = 1.5;
  Patch patch = hertz_patch(4000, a_m, force_N);
  const double most_Nm = 3.0 * std::numbers::pi / 16.0 * kMu * force_N * a_m;
  // A torsion alone: forces around the centre, of one size.
  double lever_m = 0.0;
  for (const PatchPoint& point : patch.points) lever_m += point.r_W.norm();
  for (PatchPoint& point : patch.points) {
    point.f_W += 0.5 * most_Nm / lever_m * Vector3d::UnitZ().cross(point.r_W).normalized();
  }
  patch.sum_forces();
  const PatchReport report = patch.report();
  EXPECT_NEAR(report.moment_Nm, 0.5 * most_Nm, 1e-3 * most_Nm);
  EXPECT_NEAR(report.moment_limit_Nm, most_Nm, 1e-3 * most_Nm);
  EXPECT_NEAR(report.margin, 0.5, 1e-3);
}

// Between pull and torsion the ellipsoid is held against the exact limit surface: full friction at every point of a
// patch that slides about a pole, for poles from the centre to far away. There the margin should be 0.
TEST(PatchMargin, EllipsoidAgainstTheExactLimitSurfaceOfAHertzPatch) {
  Patch patch = hertz_patch(4000, 1.0, 1.0);
  double least = 1.0, most = -1.0;
  for (double pole = 1e-3; pole < 1e3; pole *= 1.05) {
    patch.slide_about({pole, 0.0, 0.0});
    const double margin = patch.report().margin;
    least = std::min(least, margin);
    most = std::max(most, margin);
  }
  // The exact surface lies inside the ellipsoid, by 6 % of the load at most: a margin of 0.06 may be none.
  EXPECT_GE(least, -1e-5);
  EXPECT_LE(most, 0.065);
  EXPECT_GE(most, 0.055);
}

/// The motion of a tick by states alone: where the finger's points were against the object's before and after it.
struct Motion {
  std::array<Vector3d, kFingers> slip_O;
  std::array<double, kFingers> spin_rad{};
};

Motion motion_of(const Loop& loop, const State& before) {
  const Hand& hand = loop.model.scene.hand;
  HandPose pose_before, pose;
  forward_kinematics(hand, before.q, pose_before);
  forward_kinematics(hand, loop.state.q, pose);
  Motion motion;
  motion.slip_O.fill(Vector3d::Zero());
  for (int k = 0; k < kFingers; ++k) {
    Eigen::MatrixXd A(0, 4);
    std::vector<Vector3d> r, d;
    std::vector<double> f;
    Vector3d centre = Vector3d::Zero(), normal = Vector3d::Zero();
    for (Index i = loop.frame.begin[k]; i < loop.frame.begin[k + 1]; ++i) {
      const double f_n = loop.state.forces[i].f_C[0];
      if (f_n <= 0.0) continue;
      const FrameContact& contact = loop.frame.contacts[i];
      const auto on_object = [&](const HandPose& at, const State& state) -> Vector3d {
        return state.X_WO.inverse() * (at.distal(hand, k) * (contact.p_F - displacement(state, contact)));
      };
      const Vector3d n_O = before.X_WO.linear().transpose() * loop.work.kinematics.E_W[i].col(0);
      const Vector3d x = on_object(pose_before, before), way = on_object(pose, loop.state) - x;
      r.push_back(x);
      d.emplace_back(way - way.dot(n_O) * n_O);
      f.push_back(f_n);
      centre += f_n * x;
      normal += f_n * n_O;
    }
    if (f.empty()) continue;
    double F = 0.0, turn = 0.0, inertia = 0.0;
    Vector3d slip = Vector3d::Zero();
    for (std::size_t i = 0; i < f.size(); ++i) {
      F += f[i];
      slip += f[i] * d[i];
    }
    slip /= F;
    normal.normalize();
    for (std::size_t i = 0; i < f.size(); ++i) {
      const Vector3d across = normal.cross(r[i] - centre / F);
      turn += f[i] * across.dot(d[i]);
      inertia += f[i] * across.squaredNorm();
    }
    motion.slip_O[k] = slip;
    if (inertia > 0.0) motion.spin_rad[k] = turn / inertia;
  }
  return motion;
}

// What the tick reports is the motion between the states around it. Places differ by the gap at the tick's start, which
// is next to nothing once the grip is there: 1e-6 of the turn covers it.
TEST(ContactTick, ReportsTheSlipAndSpinThatTheStatesShow) {
  Loop loop(scene_of("box_grasp", {kCoarseBox, "task.translate.from=0 s", "task.translate.over=100 ms"}));
  double most_m = 0.0;
  for (int tick = 0; tick < 100; ++tick) {
    SCOPED_TRACE(tick);
    const State before = loop.state;
    const TickReport report = loop.tick();
    const Motion motion = motion_of(loop, before);
    for (int k = 0; k < kFingers; ++k) {
      const Vector3d slip_O = before.X_WO.linear().transpose() * report.patch[k].slip_W;
      EXPECT_LE((slip_O - motion.slip_O[k]).norm(), 2e-15);
      EXPECT_EQ(report.patch[k].slip_m, report.patch[k].slip_W.norm());
      EXPECT_NEAR(report.patch[k].spin_rad, motion.spin_rad[k], 1e-12 + 1e-2 * std::abs(motion.spin_rad[k]));
      most_m = std::max(most_m, slip_O.norm());
    }
  }
  EXPECT_GT(most_m, 1e-9);
}

// A box that is pulled along under the thumb with more than friction holds: the sum of the patch's slips is the box's
// way, all of the patch slides, and nothing is left of the margin. 20 mm of box leave 5 mm to go before the patch meets
// an edge.
TEST(ContactTick, SlipOfAFingerThatSlidesIsTheWayOfTheObject) {
  Scene scene = pressed_thumb(0.5e-3, {-0.5, 0.6, 0.0}, 20.0);
  scene.step_s = scene.control_period_s = 1e-3;
  Loop loop(std::move(scene));
  loop.run(0.15);  // The pulp has settled: what it gives way no longer changes.
  const Eigen::Isometry3d start = loop.state.X_WO;
  double slip_m = 0.0;
  for (int tick = 0; tick < 100; ++tick) {
    const TickReport report = loop.tick();
    slip_m += report.patch[0].slip_m;
    EXPECT_GT(report.patch[0].sliding_share, 0.999);
    EXPECT_NEAR(report.patch[0].margin, 0.0, 1e-3);
  }
  const double way_m = std::abs((start.inverse() * loop.state.X_WO.translation()).y());
  EXPECT_GT(way_m, 0.5e-3);
  EXPECT_NEAR(slip_m, way_m, 1e-3 * way_m);
}

}  // namespace
}  // namespace thenar::patches_test
