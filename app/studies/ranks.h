// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace thenar::app {

/// Rank of this process and number of processes.
struct Ranks {
  int rank = 0, ranks = 1;
};

/// Tasks that rank 0 finds.
using Tasks = std::vector<std::size_t>;

/// Meets the other processes of the same mpirun; without mpirun there are none, and no MPI either. Rank 0 calls
/// `prepare`, then all call `enter` with what that returned, then all go on: from here on no process needs another, so
/// that one that dies stops nobody. If a process throws, it goes on throwing, and the others get nothing. Throws
/// ConfigError under an mpirun if this build has no MPI.
[[nodiscard]] std::optional<Ranks> meet_ranks(const std::function<Tasks()>& prepare,
                                              const std::function<void(const Ranks& me, const Tasks& tasks)>& enter);

}  // namespace thenar::app
