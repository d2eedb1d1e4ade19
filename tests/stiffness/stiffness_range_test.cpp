// SPDX-License-Identifier: Apache-2.0
#include "engine/stiffness/stiffness_range.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>

#include "engine/models/build_model.h"
#include "engine/results/grasp_monitor.h"
#include "engine/stiffness/stiffness_report.h"
#include "tests/support/scenes.h"

namespace thenar::stiffness_range_test {
namespace {

constexpr double kTranslation_N_per_m = 150.0, kRotation_Nm_per_rad = 0.08;

/// The box, for so much of a stiffness.
Model box(double multiple, const std::vector<std::string>& more = {}) {
  const auto all = [&](double value, const std::string& unit) {
    const std::string one = std::to_string(multiple * value) + " " + unit;
    return "[" + one + ", " + one + ", " + one + "]";
  };
  std::vector<std::string> changes = {
      kCoarseBox, "time.duration=0.9 s",
      "control.muscles={stiffness: 23.4, object_stiffness: {translation: " + all(kTranslation_N_per_m, "N/m") +
          ", rotation: " + all(kRotation_Nm_per_rad, "N*m/rad") + "}}"};
  changes.insert(changes.end(), more.begin(), more.end());
  return build_model(scene_of("box_grasp", changes));
}

StiffnessRange range_of(const Model& model) {
  auto range = settled_stiffness_range(model);
  EXPECT_TRUE(range.has_value());
  return range.value_or(StiffnessRange{});
}

/// What a run finds of a stiffness that it is asked for; what it lacked at first, it asks for again bit by bit.
struct Asked {
  int lacking = 0;     ///< Control periods without forces for it, after the grasp has settled,
  double share = 0.0;  ///< what is had at the end,
  std::uint64_t at_limit = 0;
};

Asked ask(double multiple) {
  const Model model = box(multiple, {"task={}", "time.duration=2.6 s"});
  GraspRun run(model);
  Asked asked;
  while (run.time_s() < model.scene.duration_s - 1e-9) {
    run.tick();
    if (run.time_s() < 0.5) continue;
    const StiffnessReport& report = run.report.stiffness;
    asked.lacking += report.is_infeasible ? 1 : 0;
    asked.share = report.share;
    asked.at_limit |= report.at_limit;
  }
  return asked;
}

// A run can have what the range says, and no more. The grasp goes on settling after the range was taken, by which the
// forces on its contacts, and so all stiffness, change by a percent or two: 3 % are left for that.
TEST(StiffnessRange, IsWhatARunCanHave) {
  const StiffnessRange range = range_of(box(1.0));
  ASSERT_TRUE(range.asks && range.scene.most);
  const double most = range.scene.most->asked;
  const Asked within = ask(0.97 * most), beyond = ask(1.1 * most);
  EXPECT_EQ(within.lacking, 0);
  EXPECT_EQ(within.share, 1.0);
  EXPECT_GT(beyond.lacking, 0);
  EXPECT_NE(beyond.at_limit & range.scene.beyond.at_limit, 0U);
}

// What is named is what ends it: with these muscles stronger there is more, with all others stronger there is not, for
// the optimum stays one. The end is known to a millionth, and a muscle that is less than nearly at its limit is not
// named: a thousandth is left for those.
TEST(StiffnessRange, EndsByTheMusclesThatItNames) {
  const Model model = box(1.0);
  GraspRun run(model);
  while (run.time_s() < 0.3 - 1e-9) run.tick();
  const StiffGrasp grasp(run);
  for (const Matrix6d& K : {grasp.wanted(1.0, 0.0), grasp.wanted(0.0, 1.0), grasp.K_scene}) {
    const StiffEnd end = stiff_end(grasp, K);
    ASSERT_TRUE(end.most && end.beyond.is_infeasible);
    ASSERT_NE(end.beyond.at_limit, 0U);
    const auto with_stronger = [&](bool named) {
      StiffGrasp stronger = grasp;
      for (Eigen::Index m = 0; m < stronger.problem.limit.size(); ++m) {
        if (((end.beyond.at_limit >> m & 1) != 0) == named) stronger.problem.limit[m] *= 1.2;
      }
      return stiff_end(stronger, K).most.value_or(StiffForces{}).asked;
    };
    EXPECT_GT(with_stronger(true), 1.01 * end.most->asked);
    EXPECT_NEAR(with_stronger(false), end.most->asked, 1e-3 * end.most->asked);
  }
}

// Least effort over a convex set is convex in how far the set has shrunk, and rises; and all that is asked for is had.
// An optimum is exact to 1e-9, so its effort to 1e-6.
TEST(StiffnessRange, FrontIsConvexAndRises) {
  const Model model = box(1.0);
  const StiffnessRange range = range_of(model);
  ASSERT_GE(range.front.size(), 15U);
  ASSERT_TRUE(range.least);
  EXPECT_LT(range.least->effort_N(), range.front.front().effort_N());
  const double rounding_N = 1e-6 * range.front.back().effort_N();
  for (std::size_t i = 1; i < range.front.size(); ++i) {
    EXPECT_GE(range.front[i].effort_N(), range.front[i - 1].effort_N() - rounding_N);
    if (i + 1 == range.front.size()) break;
    const double before = range.front[i].asked - range.front[i - 1].asked;
    const double after = range.front[i + 1].asked - range.front[i].asked;
    const double share = before / (before + after);
    EXPECT_LE(range.front[i].effort_N(),
              (1.0 - share) * range.front[i - 1].effort_N() + share * range.front[i + 1].effort_N() + rounding_N);
  }
}

// At the very end forces are a matter of the grasp's last digits: the end is told, and the forces of 0.99 of it.
TEST(StiffnessRange, ForcesAreToldShortOfTheEnd) {
  const StiffnessRange range = range_of(box(1.0));
  for (const StiffEnd* end : {&range.translation, &range.rotation, &range.scene}) {
    ASSERT_TRUE(end->most && end->near);
    EXPECT_NEAR(end->near->asked, 0.99 * end->most->asked, 1e-9 * end->most->asked);
    EXPECT_LT(end->near->effort_N(), end->most->effort_N());
  }
  EXPECT_EQ(range.front.back().asked, range.scene.near->asked);
}

// What lacks of a scene's wish has no other muscles in its way than the end of the range.
TEST(StiffnessRange, LackNamesMusclesThatAreAtTheEnd) {
  const Model model = box(9.0);
  const StiffnessRange range = range_of(model);
  ASSERT_TRUE(range.lack.is_infeasible && range.scene.most);
  EXPECT_NE(range.lack.at_limit, 0U);
  for (Eigen::Index m = 0; m < range.scene.most->forces_N.size(); ++m) {
    if ((range.lack.at_limit >> m & 1) == 0) continue;
    EXPECT_GE(range.scene.most->forces_N[m], 0.99 * model.scene.hand.muscles[m].max_force_N);
  }
}

TEST(StiffnessRange, ForcesHaveWhatTheyAreAskedFor) {
  const Model model = box(1.0);
  GraspRun run(model);
  while (run.time_s() < 0.3 - 1e-9) run.tick();
  const StiffGrasp grasp(run);
  const Eigen::VectorXd tau = grasp.problem.tau;
  EXPECT_LT((grasp.problem.H * run.state.muscle_N - tau).norm(), 1e-9 * tau.norm());
  Vector6d scale;
  scale << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(1.0 / 0.025);
  for (const double multiple : {0.0, 0.5, 1.0, 1.5}) {
    const auto found = stiff_forces(grasp, grasp.K_scene, multiple);
    if (!found) continue;
    EXPECT_LT((grasp.problem.H * found->forces_N - tau).norm(), 1e-7 * tau.norm());
    ASSERT_TRUE(found->K_object);
    const Matrix6d rest = scale.asDiagonal() * (*found->K_object - multiple * grasp.K_scene) * scale.asDiagonal();
    EXPECT_GE(rest.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-6 * kTranslation_N_per_m) << multiple;
  }
}

TEST(StiffnessRange, IsToldInWords) {
  const Model model = box(9.0);
  const StiffnessRange range = range_of(model);
  ASSERT_TRUE(range.scene.most);
  EXPECT_LT(range.scene.most->asked, 1.0);
  const auto lines = range_lines(model.scene.hand, range);
  EXPECT_NE(lines.front().find("turns away by itself"), std::string::npos) << lines.front();
  EXPECT_NE(lines.back().find("the scene asks for more than there is: "), std::string::npos) << lines.back();
  EXPECT_NE(lines.back().find(" of the object lacks "), std::string::npos) << lines.back();
  EXPECT_NE(lines.back().find("at their limit: "), std::string::npos) << lines.back();
  EXPECT_EQ(range_json(model.scene.hand, range).at("front").size(), range.front.size());
}

TEST(StiffnessRange, IsOfScenesWhoseMusclesHaveStiffness) {
  EXPECT_FALSE(settled_stiffness_range(build_model(scene_of("box_grasp", {kCoarseBox}))).has_value());
  const Model soft = build_model(scene_of("box_grasp", {kCoarseBox, "control.muscles={stiffness: 23.4}"}));
  const StiffnessRange range = range_of(soft);
  EXPECT_FALSE(range.asks);
  EXPECT_TRUE(range.translation.most && range.rotation.most);
}

}  // namespace
}  // namespace thenar::stiffness_range_test
