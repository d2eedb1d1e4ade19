// SPDX-License-Identifier: Apache-2.0
#include "app/studies/ranks.h"

#include <cstdlib>
#include <exception>

#include "engine/scenes/config.h"

#ifdef THENAR_MPI
#include <mpi.h>
#endif

namespace thenar::app {

namespace {

/// Open MPI, MPICH and Intel's, and Slurm's srun say so in the environment.
bool is_under_mpi() {
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"}) {
    if (std::getenv(variable) != nullptr) return true;
  }
  return false;
}

#ifdef THENAR_MPI

/// Between MPI_Init and MPI_Finalize: after that a process may die without the others.
struct Meeting {
  Ranks me;
  std::exception_ptr fault;

  Meeting() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm_rank(MPI_COMM_WORLD, &me.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &me.ranks);
  }
  ~Meeting() { MPI_Finalize(); }
  Meeting(const Meeting&) = delete;
  Meeting& operator=(const Meeting&) = delete;

  /// Does the work, and waits until all have done theirs. Whether all could.
  bool together(const std::function<void()>& work) {
    try {
      work();
    } catch (...) {
      fault = std::current_exception();
    }
    int failed = fault ? 1 : 0, any_failed = 0;
    MPI_Allreduce(&failed, &any_failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    return any_failed == 0;
  }

  /// Rank 0's tasks for all, as their bytes.
  void share(Tasks& tasks) const {
    std::size_t count = tasks.size();
    MPI_Bcast(&count, sizeof(count), MPI_BYTE, 0, MPI_COMM_WORLD);
    tasks.resize(count);
    MPI_Bcast(tasks.data(), static_cast<int>(count * sizeof(std::size_t)), MPI_BYTE, 0, MPI_COMM_WORLD);
  }
};

#endif

}  // namespace

std::optional<Ranks> meet_ranks(const std::function<Tasks()>& prepare,
                                const std::function<void(const Ranks& me, const Tasks& tasks)>& enter) {
  if (!is_under_mpi()) {
    enter({}, prepare());
    return Ranks{};
  }
#ifdef THENAR_MPI
  Ranks me;
  std::exception_ptr fault;
  bool all_well = false;
  {
    Meeting meeting;
    me = meeting.me;
    Tasks tasks;
    all_well = meeting.together([&] {
      if (me.rank == 0) tasks = prepare();
    });
    if (all_well) {
      meeting.share(tasks);
      all_well = meeting.together([&] { enter(me, tasks); });
    }
    fault = meeting.fault;
  }
  if (fault) std::rethrow_exception(fault);
  return all_well ? std::optional(me) : std::nullopt;
#else
  throw ConfigError({{"mpirun", "", "this program was built without MPI: install libopenmpi-dev, and build anew"}});
#endif
}

}  // namespace thenar::app
