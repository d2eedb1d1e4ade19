// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace thenar {

/// Limits of a child process.
struct ChildLimits {
  std::size_t memory_bytes = std::size_t{4} << 30;  ///< Memory beyond that of this process.
  unsigned cpu_s = 120;
};

/// Runs work in a child process, a copy of this one, and returns its resulting bytes: for libraries that crash, loop or
/// exhaust memory on broken input. Nothing if the child did not finish or could not start.
/// Requires  Work that locks nothing that another thread of this process may hold.
[[nodiscard]] std::optional<std::string> in_child_process(const std::function<std::string()>& work,
                                                          const ChildLimits& limits = {});

/// A descriptor of this process that becomes one of another.
struct PassedDescriptor {
  int ours, its;
};

/// Starts a program, found as shells do, which signals of the terminal, such as Ctrl-C, do not reach. Its standard
/// streams that are not passed are /dev/null. Returns its number; -1 if it could not start.
[[nodiscard]] pid_t start_program(const std::vector<std::string>& command, const std::vector<PassedDescriptor>& passed);

/// Runs a program, found as shells do, whose standard input is `input`, and returns all that it writes to standard
/// output; what it writes to standard error is lost. Nothing if it could not start, or did not end with 0. Signals
/// that come meanwhile cut nothing off, and those of the terminal, such as Ctrl-C, do not reach it.
[[nodiscard]] std::optional<std::string> output_of(const std::vector<std::string>& command, const std::string& input);

}  // namespace thenar
