// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

namespace thenar::python {

/// Binds the finder: thenar.grasp().
void bind_grasps(pybind11::module_& module);

}  // namespace thenar::python
