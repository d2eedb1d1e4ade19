#pragma once

#include "engine/grasp/model.h"

namespace thenar {

/// Moves the fingers of a model's start posture along the object's normals until the pulps, pressed in where they are,
/// carry the normal forces that the controller asks for at the first tick, or without control those that its torques
/// balance: then nothing but the weight's own share moves in the first ticks. The object stays where it is.
/// Returns the largest share of a finger's load that is then still missing or too much; 0 for rigid fingertips, which
/// begin at a distance of nothing.
double settle(Model& model);

}  // namespace thenar
