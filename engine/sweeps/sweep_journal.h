#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/formats/files.h"
#include "engine/sweeps/sweep.h"

// A sweep's folder: plan.json identifies the sweep, journal-<rank>.jsonl holds the finished rows of each process, a
// line per row, and rows.csv is made of them. Several processes may share it, on one machine or file system.

namespace thenar {

/// Returns the identity of a sweep: scene, changes, variations, runner, the files that a scene names (name, size and
/// checksum), and the build, on which the last bits depend.
[[nodiscard]] nlohmann::ordered_json plan_json(const SweepPlan& plan, const std::string& runner);

/// Claims the folder for this sweep, exclusively while the lock lives: until this process writes its journal, no other
/// sweep begins there. Throws ConfigError, changing nothing, if it is another's, or FileError.
[[nodiscard]] FileLock claim_sweep_folder(const std::filesystem::path& folder, const nlohmann::ordered_json& plan);

/// Reads the finished rows of all processes of this plan. Skips rows of other plans, and lines cut by a killed process.
[[nodiscard]] std::map<std::size_t, SweepRow> read_journals(const std::filesystem::path& folder,
                                                            const nlohmann::ordered_json& plan);

/// The journal of a process's rows, each with the plan's checksum: added rows outlive the process, however it ends.
class SweepJournal {
 public:
  /// Throws ConfigError if a living process writes the journal of this rank or the folder is another plan's, or
  /// FileError.
  SweepJournal(const std::filesystem::path& folder, int rank, nlohmann::ordered_json plan);
  ~SweepJournal();
  SweepJournal(const SweepJournal&) = delete;
  SweepJournal& operator=(const SweepJournal&) = delete;

  /// Throws FileError.
  void add(std::size_t row, const SweepRow& result);

  struct Merged {
    std::map<std::size_t, SweepRow> rows;
    bool last = true;  ///< True if no other process of this sweep is running.
  };
  /// Ends the journal, and writes rows.csv from those of all processes: the last one to end writes all rows. Throws
  /// FileError.
  Merged finish(const SweepPlan& plan);

 private:
  std::filesystem::path folder_, file_;
  nlohmann::ordered_json plan_;
  int descriptor_ = -1;  ///< Locked while open, so that others see that this process lives.
};

}  // namespace thenar
