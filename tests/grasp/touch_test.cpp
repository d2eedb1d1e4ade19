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

/// The thumb under a normal load, dragged along a face in a direction of it by a force that grows from nothing to the
/// whole of what friction can carry.
std::vector<Felt> drag(double normal_N, double mu, double direction_rad, const Vector3d& normal_F = Vector3d::Zero()) {
  Scene scene = pressed_thumb(0.0, {-normal_N, 0.0, 0.0}, 1.0, normal_F);
  scene.contact.friction = mu;
  scene.contact.max_per_finger = 150;
  scene.contact.tolerance = 1e-9;
  const Eigen::Matrix3d axes = scene.object.X_WO.linear();
  Loop loop(std::move(scene));
  loop.run(0.3);  // It settles.
  constexpr int kTicks = 1000;
  std::vector<Felt> all;
  for (int i = 1; i <= kTicks; ++i) {
    TickInput input;
    const Vector3d along = std::cos(direction_rad) * axes.col(1) + std::sin(direction_rad) * axes.col(2);
    input.wrench.head<3>() = mu * normal_N * i / kTicks * along;
    const TickReport report = loop.tick(input);
    const FingerLoad& load = loop.state.load[0];
    const double n_N = load.force_N.dot(load.normal);
    Felt felt{.eta = (load.force_N - n_N * load.normal).norm() / (mu * n_N), .touch = {}};
    TouchNoise none;
    felt.touch = felt_touch(loop.model, loop.frame, loop.work.kinematics, 0, loop.work.patches.of_finger(0), load,
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

// Cattaneo and Mindlin: of a Hertz patch under a growing pull a disc of (1 - eta)^(1/3) of its radius sticks. Twelve
// orientations: how the control points lie in one patch of thirty to eighty is chance. Pressure at the rim ends within
// a point, not at a line: some 0.07 more than the law sticks with the fewest. Counting points tells eta to 0.14.
TEST(Touch, StickFallsAsCattaneoAndMindlinSay) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  constexpr int kOrientations = 12;
  const std::vector<double> etas = {0.2, 0.35, 0.5, 0.65, 0.8};
  for (const double normal_N : {1.34, 4.0}) {
    std::mt19937_64 random(kSeed);
    double error = 0.0, square = 0.0;
    for (int i = 0; i < kOrientations; ++i) {
      const auto all = drag(normal_N, 0.8, uniform(random, 0.0, std::numbers::pi), random_direction(random));
      for (std::size_t j = 0; j < etas.size(); ++j) {
        const auto at = std::ranges::find_if(all, [&](const Felt& felt) { return felt.eta >= etas[j]; });
        ASSERT_NE(at, all.end());
        error +=
            (at->touch.stick - std::pow(1.0 - at->eta, 2.0 / 3.0)) / (kOrientations * static_cast<double>(etas.size()));
        square += std::pow(1.0 - std::pow(at->touch.stick, 1.5) - at->eta, 2) /
                  static_cast<double>(kOrientations * etas.size());
      }
    }
    EXPECT_LE(error, 0.08) << normal_N << " N";
    EXPECT_GE(error, -0.06) << normal_N << " N";
    EXPECT_LE(std::sqrt(square), 0.14) << normal_N << " N";
  }
}

// The rim slips long before the patch does, and what is felt there is the friction of the whole, which no part of the
// measure is told: points that move are found by their motion alone, too.
TEST(Touch, FrictionIsFeltBeforeThePatchSlides) {
  for (const double mu : {0.3, 0.5, 0.8, 1.0}) {
    const auto all = drag(1.34, mu, 0.4);
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

// The same seed feels the same, and the noise of a sum is that of its parts: f_n,i with 5 % each, independent.
TEST(Touch, NoiseIsThatOfTheSeed) {
  Scene scene = scene_of("box_load", {kCoarseBox, "control.touch.noise=5 %"});
  std::vector<double> first;
  for (const std::uint32_t seed : {1U, 1U, 2U}) {
    scene.control->touch->seed = seed;
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
  Loop loop(scene_of("box_load", {kCoarseBox, "control.touch.noise=5 %"}));
  loop.run(0.05);
  const AllocationCounter counter;
  for (int i = 0; i < 100; ++i) loop.tick();
  EXPECT_EQ(counter.count(), 0);
}

// A scene that does not name it has none, and the same results without what it does not change.
TEST(Touch, IsThereOnlyWhereItIsNamed) {
  Loop plain(scene_of("box_grasp", {kCoarseBox}));
  Loop feeling(scene_of("box_grasp", {kCoarseBox, "control.touch={}"}));
  plain.run(0.1);
  feeling.run(0.1);
  EXPECT_EQ(plain.state.touch.size(), 0U);
  EXPECT_EQ(feeling.state.touch.size(), 3U);
  EXPECT_EQ(plain.state.q, feeling.state.q);
  EXPECT_EQ(plain.state.X_WO.matrix(), feeling.state.X_WO.matrix());
}

}  // namespace
}  // namespace thenar::touch_test
