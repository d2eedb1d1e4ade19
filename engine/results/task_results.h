// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/control/task_run.h"
#include "engine/environment/environment_contacts.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Forces of the told bodies on the object: see EnvironmentReport.
using BodyForces = Eigen::Matrix<double, 3, kToldBodies>;

/// Returns in words which body resists what it is pushed against, with its force: "'wall' resists with 5.6 N"; of
/// several the one that bears most of their sum. Without a body that touches the object: "something resists".
[[nodiscard]] std::string resistance_in_words(const Scene& scene, const BodyForces& body_N);

/// Returns what the running phase of the scene's task lacks: "phase 5, move: 'wall' resists with 5.6 N after 40 of 60
/// mm". `body_N` are the bodies' forces then.
[[nodiscard]] std::string in_words(const Scene& scene, const TaskReport& task, const BodyForces& body_N);

}  // namespace thenar
