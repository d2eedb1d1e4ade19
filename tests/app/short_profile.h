#pragma once

#include <string>

#include "tests/support/program.h"

namespace thenar::short_profiles {

/// A short profile of the least scene, as a user without real-time rights has it.
inline Outcome short_profile(const std::string& arguments, const std::string& before = "") {
  return thenar_program("profile " + config("minimal.yaml") +
                            " --contact-rate 1kHz --control-rate 200Hz --duration 0.4s --no-realtime " + arguments,
                        before);
}

}  // namespace thenar::short_profiles
