#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace thenar {

/// What a child process may take.
struct ChildLimits {
  std::size_t memory_bytes = std::size_t{4} << 30;  ///< Beyond what this process has.
  unsigned cpu_s = 120;
};

/// Does work in a child process, which is a copy of this one, and returns the bytes that it gives: for libraries that
/// crash, loop or take all memory on broken input. Nothing if the child did not come to its end, or there is none.
/// Requires  Work that locks nothing that another thread of this process may hold.
[[nodiscard]] std::optional<std::string> in_child_process(const std::function<std::string()>& work,
                                                          const ChildLimits& limits = {});

}  // namespace thenar
