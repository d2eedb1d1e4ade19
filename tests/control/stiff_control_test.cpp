// SPDX-License-Identifier: Apache-2.0
#include "engine/control/stiff_control.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tests/support/scenes.h"

namespace thenar::stiff_control_test {
namespace {

using Eigen::Vector3d;

// What a scene asks for may change while it runs, by hand. The next period then has the forces of a controller that
// never knew of anything else: the least are unique. The solver leaves 1e-9 of the effort f'f / 2, hence 5e-5 of f.
TEST(StiffnessControl, HeedsAnotherChoiceInTheNextPeriod) {
  for (const auto& [along, about] : {std::pair{50.0, 0.02}, {100.0, 0.08}, {200.0, 0.0}}) {
    Loop loop(scene_of("box_stiff", {kCoarseBox}));
    loop.run(0.9);  // While the grip builds up it asks for less.
    const Eigen::VectorXd before_N = loop.controller.f_muscle;
    Loop fresh(loop);
    for (Loop* one : {&loop, &fresh}) {
      ObjectStiffness& asked = *one->model.scene.control->muscles->object_stiffness;
      asked.translation_N_per_m.setConstant(along);
      asked.rotation_Nm_per_rad.setConstant(about);
    }
    fresh.controller.stiffness.emplace(fresh.model);
    loop.tick();
    fresh.tick();
    const StiffnessReport& found = loop.report.stiffness;
    ASSERT_TRUE(found.is_chosen && !found.is_infeasible && found.share == 1.0) << along;
    const Eigen::VectorXd f_N = loop.controller.f_muscle;
    EXPECT_LT((f_N - fresh.controller.f_muscle).norm(), 5e-5 * f_N.norm());
    EXPECT_GT((f_N - before_N).norm(), 0.01 * before_N.norm());
    // On an arm of 25 mm, so that rows of moments count like those of forces.
    const Eigen::DiagonalMatrix<double, 6> arm(1.0, 1.0, 1.0, 40.0, 40.0, 40.0);
    Vector6d asked;
    asked << Vector3d::Constant(along), Vector3d::Constant(about);
    const Matrix6d more = arm * (found.K_O - Matrix6d(asked.asDiagonal())) * arm;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(more).eigenvalues()[0], -1e-4 * along);
  }
}

}  // namespace
}  // namespace thenar::stiff_control_test
