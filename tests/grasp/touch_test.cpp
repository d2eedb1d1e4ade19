// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/touch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engine/grasp/contact_tick.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace thenar::touch_test {
namespace {

using Eigen::Vector3d;

/// What the thumb feels at one share eta = |T| / (mu N) of what friction can carry.
struct Felt {
  double eta = 0.0;
  Touch touch;
  double moving_share = 0.0;     ///< Of the loaded area: on points that moved along the face in the tick.
  double moving_friction = 0.0;  ///< Their |f_t| over f_n, all together: no cone is asked.
};

/// The thumb under a normal load on a face, at rest.
struct PressedThumb {
  PressedThumb(double normal_N, double mu, const Vector3d& normal_F, Eigen::Index points)
      : loop(scene(normal_N, mu, normal_F, points)) {
    loop.run(0.3);
  }
  /// A direction of the face, world.
  [[nodiscard]] Vector3d along(double direction_rad) const {
    const Eigen::Matrix3d& axes = loop.model.scene.object.X_WO.linear();
    return std::cos(direction_rad) * axes.col(1) + std::sin(direction_rad) * axes.col(2);
  }
  Loop loop;

 private:
  static Scene scene(double normal_N, double mu, const Vector3d& normal_F, Eigen::Index points) {
    Scene scene = pressed_thumb(0.0, {-normal_N, 0.0, 0.0}, 1.0, normal_F);
    scene.contact.friction = mu;
    scene.fingertips->leaves = points;
    scene.contact.max_per_finger = points / 2;
    scene.contact.tolerance = 1e-9;
    return scene;
  }
};

/// The thumb under a normal load, dragged along a face in a direction of it by a force that grows from nothing to the
/// whole of what friction can carry.
std::vector<Felt> drag(double normal_N, double mu, double direction_rad, const Vector3d& normal_F = Vector3d::Zero(),
                       Eigen::Index points = 320) {
  PressedThumb thumb(normal_N, mu, normal_F, points);
  Loop& loop = thumb.loop;
  constexpr int kTicks = 1000;
  std::vector<Felt> all;
  for (int i = 1; i <= kTicks; ++i) {
    TickInput input;
    input.wrench.head<3>() = mu * normal_N * i / kTicks * thumb.along(direction_rad);
    const TickReport report = loop.tick(input);
    const FingerLoad& load = loop.state.load[0];
    const double n_N = load.force_N.dot(load.normal);
    Felt felt{.eta = (load.force_N - n_N * load.normal).norm() / (mu * n_N), .touch = {}};
    TouchNoise none;
    felt.touch = felt_touch(loop.model, loop.frame, loop.work.kinematics, loop.work.patches.of_finger(0), load,
                            report.patch[0], mu, none);
    double area = 0.0, moving = 0.0, friction_N = 0.0, pressed_N = 0.0;
    for (const PatchPoint& point : loop.work.patches.of_finger(0)) {
      const double a = loop.model.pulps[0].area_m2[loop.frame.contacts[point.contact].control_point];
      area += a;
      // Sticking points move by what the solve leaves; those that slip, by what the face does: here some 1e-8 m.
      if (point.d_W.norm() < 1e-10) continue;
      moving += a;
      friction_N += std::sqrt(std::max(0.0, point.f_W.squaredNorm() - point.normal_N * point.normal_N));
      pressed_N += point.normal_N;
    }
    felt.moving_share = moving / area;
    felt.moving_friction = pressed_N > 0.0 ? friction_N / pressed_N : 0.0;
    all.push_back(felt);
  }
  return all;
}

/// Over some orientations, and over eta from 0.2 to 0.8.
struct StickError {
  double mean = 0.0;    ///< Of stick, against Cattaneo and Mindlin.
  double of_eta = 0.0;  ///< Root mean square, where eta is told by counting what sticks.
};
StickError stick_error(double normal_N, Eigen::Index points, int orientations, std::mt19937_64& random) {
  const std::vector<double> etas = {0.2, 0.35, 0.5, 0.65, 0.8};
  const double all_of = orientations * static_cast<double>(etas.size());
  StickError error;
  for (int i = 0; i < orientations; ++i) {
    const double direction_rad = uniform(random, 0.0, std::numbers::pi);
    const auto all = drag(normal_N, 0.8, direction_rad, random_direction(random), points);
    for (const double eta : etas) {
      const auto at = std::ranges::find_if(all, [&](const Felt& felt) { return felt.eta >= eta; });
      if (at == all.end()) return {1.0, 1.0};
      error.mean += (at->touch.stick - std::pow(1.0 - at->eta, 2.0 / 3.0)) / all_of;
      error.of_eta += std::pow(1.0 - std::pow(at->touch.stick, 1.5) - at->eta, 2) / all_of;
    }
  }
  error.of_eta = std::sqrt(error.of_eta);
  return error;
}

// Cattaneo and Mindlin: of a Hertz patch under a growing pull a disc of (1 - eta)^(1/3) of its radius sticks. How the
// control points lie in one patch is chance, so there are many orientations. Pressure at the rim ends within a point,
// not at a line: with the fewest points, thirteen or so under 1.34 N, up to 0.07 more sticks than the law says.
TEST(Touch, StickFallsAsCattaneoAndMindlinSay) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  struct Row {
    int points;
    double normal_N;
    int orientations;
    double mean, of_eta;  // Allowed.
  };
  for (const Row& row : {Row{320, 1.34, 12, 0.08, 0.14}, Row{320, 4.0, 12, 0.06, 0.14}, Row{640, 1.34, 12, 0.06, 0.10},
                         Row{1280, 1.34, 4, 0.06, 0.06}}) {
    std::mt19937_64 random(kSeed);
    const StickError error = stick_error(row.normal_N, row.points, row.orientations, random);
    EXPECT_LE(std::abs(error.mean), row.mean) << row.points << " points, " << row.normal_N << " N";
    EXPECT_LE(error.of_eta, row.of_eta) << row.points << " points, " << row.normal_N << " N";
  }
}

// The rim slips long before the patch does, and what is felt there is the friction of the whole, which no part of the
// measure is told: points that move are found by their motion alone, too.
TEST(Touch, FrictionIsFeltBeforeThePatchSlides) {
  for (const double mu : {0.3, 0.5, 0.8, 1.0}) {
    const auto all = drag(1.34, mu, 0.4);
    // It slides as a whole when all that friction can carry is asked for, not before.
    const auto slides = std::ranges::find_if(all, [](const Felt& felt) { return felt.touch.stick == 0.0; });
    EXPECT_GE(static_cast<double>(slides - all.begin()), 0.99 * static_cast<double>(all.size())) << mu;
    EXPECT_GT(all.back().eta, 0.99) << mu;
    const auto first = std::ranges::find_if(all, [](const Felt& felt) { return felt.touch.stick < 1.0; });
    ASSERT_NE(first, all.end());
    EXPECT_LE(first->eta, 0.2) << mu;
    for (auto felt = first; felt != all.end(); ++felt) {
      if (felt->touch.stick == 1.0) continue;  // A point that comes into the patch may make it wait for the next one.
      EXPECT_NEAR(felt->touch.friction, mu, 0.01 * mu) << "eta " << felt->eta;
    }
    // Half-way, by motion: the friction within 1 %, and the share within what a few points on the verge make of it.
    const auto half = std::ranges::find_if(all, [](const Felt& felt) { return felt.eta >= 0.6; });
    EXPECT_NEAR(half->moving_friction, mu, 0.01 * mu);
    EXPECT_NEAR(half->moving_share, 1.0 - half->touch.stick, 0.1);
  }
}

/// Displacement over the pull along `direction_rad` of the thumb's face, as the pull goes to `most_N`, back to
/// -most_N, and up to most_N again, each in kLeg ticks.
constexpr int kLeg = 800;
struct Pulled {
  double pull_N = 0.0, at_m = 0.0;
};
std::vector<Pulled> to_and_fro(double normal_N, double mu, double most_N, double direction_rad,
                               const Vector3d& normal_F, Eigen::Index points) {
  PressedThumb thumb(normal_N, mu, normal_F, points);
  const Vector3d along = thumb.along(direction_rad);
  const Vector3d from_m = thumb.loop.state.X_WO.translation();
  std::vector<Pulled> all;
  for (int i = 1; i <= 3 * kLeg; ++i) {
    const double turn = static_cast<double>(i) / kLeg;  // 1 at most_N, 2 at -most_N, 3 at most_N
    TickInput input;
    input.wrench.head<3>() = most_N * (turn <= 1.0 ? turn : turn <= 2.0 ? 3.0 - 2.0 * turn : 2.0 * turn - 5.0) * along;
    thumb.loop.tick(input);
    all.push_back(
        {-thumb.loop.state.load[0].force_N.dot(along), (thumb.loop.state.X_WO.translation() - from_m).dot(along)});
  }
  return all;
}

/// That of the pull between two of them.
double work_J(const std::vector<Pulled>& all, int from, int to) {
  double work = 0.0;
  Pulled before = from > 0 ? all[from - 1] : Pulled();
  for (int i = from; i < to; ++i) {
    work += 0.5 * (before.pull_N + all[i].pull_N) * (all[i].at_m - before.at_m);
    before = all[i];
  }
  return work;
}

/// The work of a swing between -share and share of a limit [Mindlin & Deresiewicz 1953], for the scene's pulp: 8 mm,
/// E* = 0.24 MPa, nu = 0.5, on a rigid face.
double mindlin_swing_J(double normal_N, double limit_N, double share) {
  constexpr double kRadius_m = 8e-3, kReduced_Pa = 0.24e6, kPoisson = 0.5;
  const double patch_m = std::cbrt(0.75 * normal_N * kRadius_m / kReduced_Pa);
  const double shear_Pa = 0.5 * kReduced_Pa * (1.0 - kPoisson);
  const double whole_m = 1.5 * limit_N * (2.0 - kPoisson) / (8.0 * shear_Pa * patch_m);  // From rest to sliding.
  const double left = 1.0 - share, at = 1.0 - std::pow(left, 2.0 / 3.0);
  const double pull = at - 0.4 * (1.0 - std::pow(left, 5.0 / 3.0));
  return limit_N * whole_m * (8.0 * pull - 4.0 * share * at);
}

// Masing's rule, which Mindlin and Deresiewicz found for this contact: the way back is the way there at twice the
// size, and so is the way up again, which ends where it began. So the first pull tells how much work a swing takes;
// what it is by their law, some 200 points in the patch tell to a tenth, as chance has it.
TEST(Touch, SwingsTakeTheWorkThatMindlinAndDeresiewiczSay) {
  constexpr unsigned kSeed = 22;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  constexpr double kNormal_N = 1.34, kFriction = 0.8, kLimit_N = kFriction * kNormal_N;
  for (const int points : {320, 1280}) {
    for (const double share : {0.5, 0.8}) {
      const auto all = to_and_fro(kNormal_N, kFriction, share * kLimit_N, uniform(random, 0.0, std::numbers::pi),
                                  random_direction(random), points);
      const Pulled top = all[kLeg - 1], again = all.back();
      const double pull_J = work_J(all, 0, kLeg), swing_J = work_J(all, kLeg, 3 * kLeg);
      // Twice the pull's curve each way.
      const double masing_J = 8.0 * pull_J - 4.0 * top.pull_N * top.at_m;
      EXPECT_NEAR(swing_J / masing_J, 1.0, 0.05) << points << " points, " << share;
      EXPECT_NEAR(again.at_m, top.at_m, 0.02 * top.at_m) << points << " points, " << share;
      const double law_J = mindlin_swing_J(kNormal_N, kLimit_N, share);
      if (points == 1280) {
        EXPECT_NEAR(swing_J / law_J, 1.0, 0.1) << share;
      }
    }
  }
}

// The same seed feels the same, and the noise of a sum is that of its parts: f_n,i with 5 % each, independent.
TEST(Touch, NoiseIsThatOfTheSeed) {
  Scene scene = scene_of("box_load", {kCoarseBox, "fingertips.touch.noise=5 %"});
  std::vector<double> first;
  for (const std::uint32_t seed : {1U, 1U, 2U}) {
    scene.fingertips->touch->seed = seed;
    Loop loop(scene);
    loop.run(0.3);
    std::vector<double> felt;
    double mean = 0.0, square = 0.0, expected = 0.0;
    constexpr int kTicks = 400;
    for (int i = 0; i < kTicks; ++i) {
      loop.tick();
      felt.push_back(loop.state.touch[0].normal_N);
      const FingerLoad& load = loop.state.load[0];
      const double off = felt.back() - load.force_N.dot(load.normal);
      mean += off / kTicks;
      square += off * off / kTicks;
      double squares = 0.0;
      for (const PatchPoint& point : loop.work.patches.of_finger(0)) squares += point.normal_N * point.normal_N;
      expected += 0.05 * 0.05 * squares / kTicks;
    }
    // Of 400 independent numbers: the mean within four of its standard errors, the variance within 30 %.
    EXPECT_LE(std::abs(mean), 4.0 * std::sqrt(expected / kTicks));
    EXPECT_NEAR(square / expected, 1.0, 0.3);
    if (first.empty()) first = felt;
    EXPECT_EQ(felt == first, seed == 1U);
  }
}

// The contact tick takes nothing from the heap, with noise or without.
TEST(Touch, AllocatesNothing) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  Loop loop(scene_of("box_load", {kCoarseBox, "fingertips.touch.noise=5 %"}));
  loop.run(0.05);
  const AllocationCounter counter;
  for (int i = 0; i < 100; ++i) loop.tick();
  EXPECT_EQ(counter.count(), 0);
}

// A scene that does not name it has none, and the same results without what it does not change.
TEST(Touch, IsThereOnlyWhereItIsNamed) {
  Loop plain(scene_of("box_grasp", {kCoarseBox}));
  Loop feeling(scene_of("box_grasp", {kCoarseBox, "fingertips.touch={}"}));
  plain.run(0.1);
  feeling.run(0.1);
  EXPECT_EQ(plain.state.touch.size(), 0U);
  EXPECT_EQ(feeling.state.touch.size(), 3U);
  EXPECT_EQ(plain.state.q, feeling.state.q);
  EXPECT_EQ(plain.state.X_WO.matrix(), feeling.state.X_WO.matrix());
}

}  // namespace
}  // namespace thenar::touch_test
