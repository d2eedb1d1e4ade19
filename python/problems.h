// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

namespace thenar::python {

/// Binds the three small problems as functions of arrays: thenar.solve.
void bind_problems(pybind11::module_& module);

}  // namespace thenar::python
