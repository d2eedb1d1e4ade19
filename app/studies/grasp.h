// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Finds grasps for an object or a scene, prints them by rank, and writes each as a scene with its picture. Returns the
/// exit code.
[[nodiscard]] int grasp(const Options& options);

/// Writes a commented scene in which a grasp of an object's file is to be found. Returns the exit code.
[[nodiscard]] int new_scene(const Options& options);

}  // namespace thenar::app
