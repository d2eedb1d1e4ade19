// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tests/support/program.h"

namespace thenar::short_runs {

/// A short run of the least scene on two threads, as a user without real-time rights has it.
inline ProgramResult short_run(const std::string& arguments, const std::string& before = "") {
  return thenar_program("run " + config("minimal.yaml") +
                            " --realtime --contact-rate 1kHz --control-rate 200Hz --time 0.4 --no-realtime " +
                            arguments,
                        before);
}

}  // namespace thenar::short_runs
