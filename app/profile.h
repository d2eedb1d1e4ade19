#pragma once

#include <functional>

#include "app/options.h"
#include "engine/grasp/model.h"

namespace thenar::app {

/// The model of the command line. `claim` is called once its scene is known to be good, and before `model: auto` runs
/// it. Where the scene is to run at the control rate that this machine keeps, measures it, sets it and, unless quiet,
/// says so on stderr.
[[nodiscard]] Model ready_model(const Options& options, const std::function<void()>& claim);

/// `thenar profile`: runs a scene on two threads and tells the times of its loops beside their accuracy. Its exit code.
[[nodiscard]] int profile(const Options& options);

}  // namespace thenar::app
