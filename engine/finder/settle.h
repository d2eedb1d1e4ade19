// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/grasp/model.h"

namespace thenar {

/// Finds the equilibrium of fingers and object at the start, so that the first tick is like the hundredth: moves the
/// fingers along the object's normals, and their pulps tangentially without the joints (`Model::start`), until the
/// pulps carry the forces commanded at the first tick, or without control those that balance the torques. The object
/// does not move. Returns the largest remaining force error in some direction as a share of a finger's normal force: 0
/// for rigid fingertips, which begin at zero distance, and 1 if the controller finds no forces.
double settle(Model& model);

}  // namespace thenar
