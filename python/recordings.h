#pragma once

#include <pybind11/pybind11.h>

namespace thenar::python {

/// What a recording holds, as arrays: thenar.Recording.
void bind_recordings(pybind11::module_& module);

}  // namespace thenar::python
