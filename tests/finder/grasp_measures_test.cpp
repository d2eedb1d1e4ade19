// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/grasp_measures.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace thenar::grasp_measures_test {
namespace {

using Eigen::Vector3d;

/// Two fingers that press from both sides of an object with 2 N and 3 N. It is turned by half a turn: its normals turn
/// with it, and forces are in world axes.
FoundGrasp pinch() {
  FoundGrasp grasp;
  grasp.X_WO.linear() = Vector3d(-1.0, -1.0, 1.0).asDiagonal();
  grasp.places = PerFinger<FingerPlace>(2);
  for (int k = 0; k < 2; ++k) {
    const Vector3d outward_W = (k == 0 ? 1.0 : -1.0) * Vector3d::UnitX();
    grasp.places[k].normal_O = -outward_W;
    grasp.places[k].force_W = -(2.0 + k) * outward_W + Vector3d::UnitZ();
    grasp.places[k].patch = 0.5 + 0.25 * k;
  }
  return grasp;
}

TEST(GraspMeasures, HaveNamesOfTheirOwnAndSentences) {
  std::set<std::string_view> names;
  for (const GraspMeasure& measure : grasp_measures()) {
    EXPECT_TRUE(names.insert(measure.name).second) << measure.name;
    EXPECT_TRUE(measure.sentence.ends_with('.')) << measure.name;
    EXPECT_NE(measure.value, nullptr) << measure.name;
    EXPECT_EQ(&grasp_measure(measure.name), &measure);
  }
  EXPECT_THROW((void)grasp_measure("epsilon"), std::out_of_range);
}

// The least of the fingers counts. All numbers are multiples of 1/4: nothing rounds.
TEST(GraspMeasures, AreThoseOfTheWorstFinger) {
  const FoundGrasp grasp = pinch();
  EXPECT_EQ(grasp_measure("press_N").value(grasp), 2.0);
  EXPECT_EQ(grasp_measure("patch").value(grasp), 0.5);
}

// Of two measures that share a column, tables show the first one that a grasp has.
TEST(GraspMeasures, ShowTheEffortOfMusclesOrOfJoints) {
  FoundGrasp grasp = pinch();
  grasp.torque_Nm = 0.25;
  EXPECT_FALSE(grasp_measure("muscle_share").is_of(grasp));
  EXPECT_TRUE(grasp_measure("torque_Nm").is_of(grasp));
  EXPECT_EQ(grasp_measure("muscle_share").shown, grasp_measure("torque_Nm").shown);
  grasp.muscle_share = 0.5;
  EXPECT_TRUE(grasp_measure("muscle_share").is_of(grasp));
  EXPECT_EQ(grasp_measure("muscle_share").shown_value(grasp), 50.0);
}

}  // namespace
}  // namespace thenar::grasp_measures_test
