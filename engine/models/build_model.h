// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/model.h"
#include "engine/models/object_surface.h"

namespace thenar {

/// Makes a scene ready to run: its object's surface, its fingertips with their level of detail, and how many contacts a
/// frame must hold. Nothing after it reads files. `begins` is told each stage of it.
/// Throws ConfigError or FileError where the object's points make no surface, a place in it lies outside, or its
/// environment leaves it no room.
[[nodiscard]] Model build_model(Scene scene, const StartWatch& begins = {});

/// The same model, sooner: of a known one it takes the object's surface and the fingertips where the scene has the
/// same.
[[nodiscard]] Model build_model(Scene scene, Model known);

}  // namespace thenar
