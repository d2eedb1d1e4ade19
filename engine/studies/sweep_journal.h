#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/formats/files.h"
#include "engine/studies/sweep.h"

// A sweep's folder: plan.json says which sweep it is, journal-<rank>.jsonl holds the finished rows of each process, a
// line a row, and rows.csv is made of them. Several processes may share it, on one machine or on a common file system.

namespace thenar {

/// What makes a sweep the one that it is: scene, changes, what varies, how it is run, the files that a scene names
/// (name, size and checksum), and the build, on which the last bits depend.
[[nodiscard]] nlohmann::ordered_json plan_json(const SweepPlan& plan, const std::string& runner);

/// Makes the folder this sweep's, and is the only one to do so while the lock lives: until this process writes its
/// journal, no other sweep begins there. Throws ConfigError if it is another's, and leaves that as it is, or FileError.
[[nodiscard]] FileLock claim_sweep_folder(const std::filesystem::path& folder, const nlohmann::ordered_json& plan);

/// The finished rows of all processes of this plan; other rows are not this sweep's. A line that is torn, for its
/// process was killed, is no row.
[[nodiscard]] std::map<std::size_t, SweepRow> read_journals(const std::filesystem::path& folder,
                                                            const nlohmann::ordered_json& plan);

/// Where a process writes its rows as they end, each with the plan's checksum: what is added outlives the process,
/// however that ends.
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
    bool last = true;  ///< No other process of this sweep goes on.
  };
  /// Ends the journal, and writes rows.csv from those of all processes: so the last one to end writes all rows. Throws
  /// FileError.
  Merged finish(const SweepPlan& plan);

 private:
  std::filesystem::path folder_, file_;
  nlohmann::ordered_json plan_;
  int descriptor_ = -1;  ///< Locked as long as it is open, so that others see that this process lives.
};

}  // namespace thenar
