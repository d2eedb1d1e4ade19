// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

namespace thenar::python {

/// Binds the content of a recording as arrays: thenar.Recording.
void bind_recordings(pybind11::module_& module);

}  // namespace thenar::python
