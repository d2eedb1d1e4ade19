// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "engine/control/control_period.h"
#include "engine/grasp/scene.h"

namespace thenar::python {

/// Returns the laws of a caller from keyword arguments: `wrench`, `forces`, `torques`, `muscles`, each None or a
/// function of a Period. They take the interpreter's lock, on whatever thread they are called.
/// Raises ValueError where the scene would never ask for one of them.
[[nodiscard]] OwnControl own_control(const Scene& scene, pybind11::object wrench, pybind11::object forces,
                                     pybind11::object torques, pybind11::object muscles);

void bind_laws(pybind11::module_& module);

}  // namespace thenar::python
