#pragma once

#include <pybind11/pybind11.h>

#include "engine/grasp/control_period.h"

namespace thenar::python {

/// The laws of a caller, as keyword arguments have them: `wrench`, `forces`, `torques`, `muscles`, each None or a
/// function of a Period. They take the interpreter's lock, on whatever thread they are called.
[[nodiscard]] OwnControl own_control(pybind11::object wrench, pybind11::object forces, pybind11::object torques,
                                     pybind11::object muscles);

void bind_laws(pybind11::module_& module);

}  // namespace thenar::python
