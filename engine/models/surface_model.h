// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/model.h"

namespace thenar {

/// The model of a scene that asks for no grasp, on its object's surface: what build_model() does once it has both.
/// `known`, if there is one, has had this surface, with the edges that were found there; it lends its fingertips where
/// the scene has the same.
/// Throws ConfigError where a place in the object lies outside.
[[nodiscard]] Model surface_model(Scene scene, ImplicitSurface surface, Model* known = nullptr);

/// Gives the fingertips another kernel and level of detail (set_level). Requires deformable ones.
void set_fingertips(Model& model, PulpKernel kernel, int level);

}  // namespace thenar
