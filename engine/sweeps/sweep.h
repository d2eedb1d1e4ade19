// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/results/recording.h"
#include "engine/results/verdict.h"

namespace thenar {

/// A key of a scene and its values in turn, written as for --set.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

/// Reads `key=a:b:n`: n values from a to b, evenly; `key=a:b:n:log`: by equal ratios; `key=a,b,c`: these. Bounds carry
/// their unit, "0.1 mm:2 mm:5". Commas and colons within brackets or quotes belong to a value. Throws ConfigError.
[[nodiscard]] Variation read_variation(const std::string& text);

/// A scene with all combinations of its variations; the last key varies fastest.
struct SweepPlan {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  ///< Changes of all rows.
  std::vector<Variation> vary;

  [[nodiscard]] std::size_t rows() const;
  /// Returns the values of one row, one per key.
  [[nodiscard]] std::vector<std::string> values(std::size_t row) const;
  /// Returns the changes of one row: the overrides and its values.
  [[nodiscard]] std::vector<std::string> changes(std::size_t row) const;
};

/// Returns the files that the rows name: scenes, hands, scanned objects. Throws ConfigError and FileError.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const SweepPlan& plan);

/// Reads these files once for all rows, as long as a KeptFiles lives. Throws ConfigError and FileError.
void keep_files(const SweepPlan& plan);

/// Returns the scene of the first valid row. Throws ConfigError if a key varies twice, if there are more than a million
/// rows, and the error of the first row if no row is valid, as with a misspelt key.
[[nodiscard]] Scene first_scene(const SweepPlan& plan);

/// The result of one row: reproducible to the last bit, so without times.
struct SweepRow {
  Verdict verdict;
  nlohmann::ordered_json measures;  ///< Flat: name to number or null. Empty for a refused scene.
  std::string left_out = {};        ///< Parts that `model: auto` left out or not, and why; empty for another scene.
};

/// Returns the row of a completed run: measures of summary.json by their names there, and force_chatter.
[[nodiscard]] SweepRow sweep_row(const Model& model, const Recording& recording);

/// A function that runs a row; called on several threads at once.
using RunScene = std::function<SweepRow(const Model& model)>;

/// Runs the scene as `thenar run` does.
[[nodiscard]] SweepRow run_row(const Model& model);

/// Callbacks for a completed row, and for one without result, with the reason: in any order, but never concurrently.
struct SweepListener {
  std::function<void(std::size_t row, SweepRow result)> done;
  std::function<void(std::size_t row, const std::string& why)> failed;
};

/// Runs these rows, `jobs` at a time, each on one thread. A row with a refused scene is a result, too: kRefused, with
/// the reason. One that ran out of memory, or could not read a file, has no result: another run may have one. Other
/// exceptions of `run` or a listener end the sweep and are rethrown.
void run_sweep(const SweepPlan& plan, const std::vector<std::size_t>& rows, int jobs, const RunScene& run,
               const SweepListener& listener);

/// Writes rows as a table, in the plan's order, part by part: variations, outcome, reason, omissions by `model: auto`,
/// measures. A unit that all values of a key share is in the header; missing measures are empty. `row_of` has nothing
/// of a row that is missing.
void write_rows_csv(const SweepPlan& plan, const std::function<std::optional<SweepRow>(std::size_t row)>& row_of,
                    const std::function<void(std::string_view)>& write);

}  // namespace thenar
