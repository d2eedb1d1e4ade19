// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

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

/// The finished rows of all processes of a plan, without those of other plans and lines cut by a killed process. It
/// knows where each stands, 16 bytes a row of the plan, and reads it when it is asked for.
class FinishedRows {
 public:
  /// Reads the journals once, in parts. Throws FileError.
  FinishedRows(const std::filesystem::path& folder, const SweepPlan& plan, const nlohmann::ordered_json& json);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool contains(std::size_t row) const { return places_[row].bytes > 0; }
  /// Returns nothing for a row that is missing, or whose line does not say what it should.
  [[nodiscard]] std::optional<SweepRow> read(std::size_t row) const;

 private:
  struct Place {
    std::uint32_t file = 0, bytes = 0;
    std::uint64_t begin = 0;
  };
  [[nodiscard]] bool read_journal(std::uint32_t file, const std::string& plan);

  std::vector<std::filesystem::path> files_;
  std::vector<Place> places_;
  std::size_t count_ = 0;
};

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

  /// Rows of all processes by outcome.
  using Outcomes = std::map<Outcome, std::size_t>;
  /// Ends the journal. The last process of this sweep to end writes rows.csv from the journals of all, in one pass, and
  /// returns what is in it. Throws FileError.
  std::optional<Outcomes> finish(const SweepPlan& plan);

 private:
  std::filesystem::path folder_, file_;
  nlohmann::ordered_json plan_;
  std::string line_begin_;  // After the row's number.
  int descriptor_ = -1;     ///< Locked while open, so that others see that this process lives.
};

}  // namespace thenar
