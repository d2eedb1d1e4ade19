#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

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

}  // namespace thenar
