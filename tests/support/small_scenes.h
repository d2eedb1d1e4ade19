// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/models/build_model.h"
#include "engine/scenes/config.h"
#include "tests/support/scenes.h"

namespace thenar::small_scenes {

inline Scene scene_with_shape(const std::string& shape) {
  return scene_of("minimal", {"object.shape={" + shape + "}", "object.points=2000"});
}

/// The one message about these changes, with its key; empty if the scene is read and its model made.
inline std::string fault_with(const std::vector<std::string>& changes) {
  try {
    (void)build_model(scene_of("minimal", changes));
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    return error.diagnostics()[0].key + ": " + error.diagnostics()[0].message;
  }
  return "";
}

}  // namespace thenar::small_scenes
