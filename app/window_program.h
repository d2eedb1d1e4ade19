#pragma once

namespace thenar::app {

/// Becomes the program of the live window, `thenar-window` beside this one, with the same arguments. Returns only if
/// there is none: it says how to get it, and returns the exit code.
[[nodiscard]] int run_window_program(char** argv);

}  // namespace thenar::app
