// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/untuned_grasps.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <string>

#include "engine/models/build_model.h"
#include "engine/stiffness/stiffness_probe.h"
#include "tests/support/scenes.h"

namespace thenar::untuned_grasps_test {
namespace {

constexpr double kBar = 0.02;

/// The largest relative difference of stiffnesses along and about the axes, with all other motions held.
double held_error(const MeasuredStiffness& measured, const PredictedStiffness& predicted) {
  return (measured.K_O.diagonal().array() / predicted.K_O.diagonal().array() - 1.0).abs().maxCoeff();
}

// A box that is still being pushed when excitations stop goes on by 0.15 mm. Muscles are then lengthened, by which
// their tension, and what it turns with the joints, changes: without that, the compliances of the prediction are off by
// 4 %, and without the way to rest by 8 %. Probes are runs of the simulation and know neither.
TEST(UntunedGrasps, ABoxThatIsPushedIsAsStiffAsPredicted) {
  const Model model = build_model(scene_of("box_stiff", {kCoarseBox}));
  const StiffnessStudy study = study_stiffness(model, model.scene.duration_s, Acting::kMuscles, ProbeSettings{});
  ASSERT_TRUE(study.rest && study.rest->reached && study.measured);
  EXPECT_GT(study.rest->moved_m, 0.1e-3) << "it was at rest before";
  EXPECT_GT(study.rest->changed, kBar) << "and as stiff";
  EXPECT_LT(compliance_error(study.measured->C_O, study.predicted.K_O.inverse()), kBar);
  EXPECT_LT(held_error(*study.measured, study.predicted), kBar);
}

class Untuned : public ::testing::TestWithParam<std::uint64_t> {};

// Found grasps of a cylinder and an ellipsoid, for stiffnesses at random, that no contact slides in.
TEST_P(Untuned, GraspIsAsStiffAsPredicted) {
  UntunedGrasp grasp = untuned_grasp(GetParam(), 160);
  const Model model = build_model(std::move(grasp.scene));
  GraspAt at(model, 0.6, Acting::kMuscles);
  EXPECT_TRUE(let_rest(at, {}).reached) << grasp.name;
  const PredictedStiffness predicted = predict_stiffness(at.run);
  const auto measured = probe_stiffness(at, predicted, {});
  ASSERT_TRUE(measured.has_value()) << grasp.name;
  EXPECT_EQ(predicted.near_sliding, 0) << grasp.name;
  EXPECT_LT(compliance_error(measured->C_O, predicted.K_O.inverse()), kBar) << grasp.name;
  EXPECT_LT(held_error(*measured, predicted), kBar) << grasp.name;
}

INSTANTIATE_TEST_SUITE_P(Seeds, Untuned, ::testing::Values(1, 18));

// A contact that slides sticks under a push one way and slips under its opposite; each is predicted by itself. Two more
// have less than a hundredth of their friction left, so the prediction says that it may be off by more than a percent.
TEST(UntunedGrasps, WithAContactThatSlidesIsAsStiffAsPredicted) {
  UntunedGrasp grasp = untuned_grasp(3, 160);
  const Model model = build_model(std::move(grasp.scene));
  GraspAt at(model, 0.6, Acting::kMuscles);
  ASSERT_TRUE(let_rest(at, {}).reached);
  const PredictedStiffness predicted = predict_stiffness(at.run);
  const auto measured = probe_stiffness(at, predicted, {});
  ASSERT_TRUE(measured.has_value());
  EXPECT_GT(predicted.sliding, 0);
  EXPECT_GT(predicted.near_sliding, predicted.sliding);
  EXPECT_GT(predicted.uncertain, 0.01);
  EXPECT_LT(compliance_error(measured->C_O, predicted.K_O.inverse()), kBar);
  EXPECT_LT(held_error(*measured, predicted), kBar);
}

}  // namespace
}  // namespace thenar::untuned_grasps_test
