#include "engine/studies/object_stiffness.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "engine/scenes/build_model.h"
#include "engine/studies/stiffness_probe.h"
#include "tests/studies/cocontraction.h"

namespace thenar::object_stiffness_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Held {
  const char* scene;
  double at_s, translation_N_per_m, rotation_Nm_per_rad;
};

class ObjectStiffness : public ::testing::TestWithParam<Held> {};

// Probes go through contact solves, friction and the frames of every control period, and share with the prediction the
// muscles' and the pulps' laws alone. Grips that no contact slides in: where some do, they hold one of two opposite
// probes more than the other.
TEST_P(ObjectStiffness, IsAsMeasured) {
  const Held& held = GetParam();
  GraspAt grasp(build_model(stiff_scene(held.scene)), held.at_s, Acting::kMuscles);
  ASSERT_TRUE(stiffen(grasp.run, held.translation_N_per_m, held.rotation_Nm_per_rad));
  const PredictedStiffness predicted = predict_stiffness(grasp.run);
  ASSERT_TRUE(predicted.is_stable());
  ASSERT_EQ(predicted.sliding, 0);
  const auto measured = probe_stiffness(grasp, predicted, {});
  ASSERT_TRUE(measured.has_value() && measured->is_finite);
  EXPECT_LE(measured->moving, 1e-3);
  EXPECT_LT(compliance_error(measured->C_O, predicted.K_O.inverse()), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ObjectStiffness,
                         ::testing::Values(Held{"box_grasp", 0.38, 30.0, 0.02}, Held{"box_grasp", 0.38, 120.0, 0.06},
                                           Held{"box_push", 0.45, 60.0, 0.03}, Held{"capsule", 0.38, 60.0, 0.02}),
                         [](const auto& one) { return std::string(one.param.scene) + std::to_string(one.index); });

// Random squeezes, moves of the object and muscles that pull against one another, which hold the object or do not.
TEST(GraspModes, ComeBackOrTurnAwayAsFastAsPredicted) {
  constexpr int kCases = 40, kPerPosture = 5;
  std::mt19937_64 random(7);
  const auto number = [&](double low, double high) { return std::to_string(uniform(random, low, high)); };
  const ProbeSettings settings{.most_s = 0.5};
  std::optional<Model> model;
  int cases = 0, away = 0, right_sign = 0, right_sign_sticking = 0, sticking = 0, close = 0;
  while (cases < kCases) {
    Scene scene = stiff_scene(
        "box_grasp",
        {"control.grasp.internal_force=" + number(0.8, 3.0) + " N",
         "task.translate={by: [" + number(-15.0, 15.0) + " mm, " + number(-15.0, 15.0) + " mm, " + number(-15.0, 15.0) +
             " mm], from: 0.05 s, over: 0.4 s}",
         "task.rotate={about: [0.3, -0.5, 0.8], by: " + number(-10.0, 10.0) + " deg, from: 0.05 s, over: 0.4 s}"});
    model = model ? build_model(std::move(scene), *model) : build_model(std::move(scene));
    const GraspAt posture(*model, 1.6, Acting::kMuscles);
    const PredictedStiffness before = predict_stiffness(posture.run);
    if (before.contacts == 0 || before.effort.share > 1.0) continue;  // The law has not held it there.
    for (int i = 0; i < kPerPosture; ++i) {
      GraspAt grasp(posture.model, 0.0, Acting::kMuscles);
      grasp.run.go_on_as(posture.run);
      if (!cocontract(grasp.run, uniform(random, 0.0, 40.0), random)) continue;
      const PredictedStiffness predicted = predict_stiffness(grasp.run);
      const double rate = predicted.slowest().rate_per_s;
      const double measured = measure_rate(grasp, predicted.slowest(), settings);
      ++cases;
      away += rate < 0.0 ? 1 : 0;
      const bool is_right = (rate < 0.0) == (measured < 0.0);
      right_sign += is_right ? 1 : 0;
      if (predicted.sliding > 0) continue;
      ++sticking;
      right_sign_sticking += is_right ? 1 : 0;
      close += std::abs(measured - rate) <= 0.1 * std::abs(rate) + 0.02 ? 1 : 0;
    }
  }
  // Contacts that slide stick again where the object comes back, and slide on where it does not.
  EXPECT_GE(right_sign, 0.75 * cases);
  EXPECT_GE(right_sign_sticking, 0.95 * sticking);
  EXPECT_GE(close, 0.9 * sticking);
  EXPECT_GT(away, cases / 4) << "and of both kinds";
  EXPECT_LT(away, cases - cases / 10);
  EXPECT_GE(sticking, 5);
}

// Springs at a point c, turned somehow, are decoupled there; seen from the origin they are not.
TEST(CentredStiffness, FindsThePointOfSpringsThatMeetThere) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d R = random_rotation(random), Q = random_rotation(random);
    const Vector3d k(50.0, 200.0, 700.0), turning(0.02, 0.1, 0.3), c = 0.03 * random_direction(random);
    Matrix6d at_c = Matrix6d::Zero();
    at_c.topLeftCorner<3, 3>() = R * k.asDiagonal() * R.transpose();
    at_c.bottomRightCorner<3, 3>() = Q * turning.asDiagonal() * Q.transpose();
    const CentredStiffness found = centred(about(at_c, -c));
    ASSERT_TRUE(found.has_centre);
    EXPECT_LT((found.centre_m - c).norm(), 1e-12);
    EXPECT_LT((found.translation_N_per_m - k).norm(), 1e-10);
    EXPECT_LT((found.rotation_Nm_per_rad - turning).norm(), 1e-12);
  }
}

// While the law goes on, its gain pulls besides what muscles and pulps do by themselves.
TEST(ObjectStiffness, OfTheLawIsMoreThanThatOfTheMuscles) {
  const Model model = build_model(stiff_scene("box_grasp"));
  const StiffnessStudy study = study_stiffness(model, 0.38, Acting::kControl, ProbeSettings{});
  ASSERT_TRUE(study.measured.has_value() && study.measured->is_finite);
  EXPECT_FALSE(study.slowest_per_s.has_value());
  for (int i = 0; i < 3; ++i) EXPECT_GT(1.0 / study.measured->C_O(i, i), 300.0) << "control.position.p";
}

}  // namespace
}  // namespace thenar::object_stiffness_test
