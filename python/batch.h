// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

namespace thenar::python {

/// Binds many runs at once, and whole runs: rollout, sweep, run.
void bind_batch(pybind11::module_& module);

}  // namespace thenar::python
