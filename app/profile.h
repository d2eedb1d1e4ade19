#pragma once

#include "app/options.h"
#include "engine/grasp/model.h"

/// Where the scene is to run at the control rate that this machine keeps: measures it, sets it and, unless quiet, says
/// so on stderr.
void choose_control_rate(const Options& options, thenar::Model& model);

/// `thenar profile`: runs a scene on two threads and tells the times of its loops beside their accuracy. Its exit code.
[[nodiscard]] int profile(const Options& options);
