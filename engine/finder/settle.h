#pragma once

#include "engine/grasp/model.h"

namespace thenar {

/// Finds how the fingers of a model hold its object at the start, so that the first tick is like the hundredth: moves
/// them along the object's normals, and their pulps across without the joints (`Model::start`), until the pulps carry
/// what the controller asks for at the first tick, or without control what its torques balance. The object stays where
/// it is. Returns the largest share of a finger's normal force that is then still missing or too much in some
/// direction: 0 for rigid fingertips, which begin at a distance of nothing, and 1 if the controller finds no forces.
double settle(Model& model);

}  // namespace thenar
