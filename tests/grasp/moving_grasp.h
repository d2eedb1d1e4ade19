// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace thenar::moving_grasp {

/// The box grasp, carried sideways from the start on so that everything moves.
class MovingGrasp : public testing::Test {
 protected:
  MovingGrasp() : loop(scene_of("box_grasp", {kCoarseBox, "task.translate.from=0 s", "task.translate.over=100 ms"})) {}
  Loop loop;
  const Model& model = loop.model;
};

}  // namespace thenar::moving_grasp
