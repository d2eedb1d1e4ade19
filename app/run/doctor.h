// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>

namespace thenar::app {

/// Says in plain words what this machine can keep: what scheduling it grants and how to get what it refuses, what may
/// hold a contact thread up, how late such a thread wakes, and so at which rate one may run. Takes five seconds, in
/// which it measures at each rate. `core`: the contact thread's; -1: the last.
void doctor(std::ostream& out, int core = -1);

}  // namespace thenar::app
