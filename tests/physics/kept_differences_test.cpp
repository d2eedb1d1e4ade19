// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/scenes.h"

namespace thenar::kept_differences_test {
namespace {

struct Case {
  const char* scene;
  std::vector<std::string> changes;
  double from_s;  ///< What comes before is not counted.
  double most;  ///< Of the sweeps that are taken without the differences of earlier ticks, where 1 would save nothing.
};

// What the sweeps of earlier ticks have shown of W saves sweeps, on the way and at rest, and is no part of a result:
// the object goes where it goes if each tick learns anew. Sweeps are 0.47, 0.57 and 0.59 of those without it.
// Residuals of 1e-7, of free motions of some 10 um a tick, leave 1e-12 m a tick, which hardly add up on a path that
// is controlled.
TEST(KeptDifferences, SaveSweepsAndMoveNothing) {
  const std::vector<Case> cases{{"box_grasp", {kCoarseBox}, 0.1, 0.65},
                                {"box_grasp", {kCoarseBox, "task={}"}, 0.5, 0.75},
                                {"capsule", {"object.points=6000"}, 0.1, 0.8}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.scene);
    Loop keeping(scene_of(one.scene, one.changes)), forgetting = keeping;
    int kept = 0, anew = 0;
    while (keeping.time_s() < one.from_s + 0.3) {
      const int with = keeping.tick().solve.sweeps;
      forgetting.memory.solver.list = -1;
      const int without = forgetting.tick().solve.sweeps;
      if (keeping.time_s() < one.from_s) continue;
      kept += with;
      anew += without;
    }
    EXPECT_LT(kept, one.most * anew) << kept << " of " << anew;
    EXPECT_LT((keeping.state.X_WO.translation() - forgetting.state.X_WO.translation()).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace thenar::kept_differences_test
