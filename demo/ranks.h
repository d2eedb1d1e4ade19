#pragma once

#include <functional>
#include <optional>

/// Which of how many processes this one is.
struct Ranks {
  int rank = 0, ranks = 1;
};

/// Meets the other processes of the same mpirun; without mpirun there are none, and no MPI either. Rank 0 calls `prepare`,
/// then all call `enter`, then all go on: from here on no process needs another, so that one that dies stops nobody. If a
/// process throws, it goes on throwing, and the others get nothing. Throws ConfigError under an mpirun if this build
/// has no MPI.
[[nodiscard]] std::optional<Ranks> meet_ranks(const std::function<void()>& prepare,
                                              const std::function<void(const Ranks& me)>& enter);
