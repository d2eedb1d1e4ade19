#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"
#include "engine/results/recording.h"
#include "engine/results/verdict.h"

namespace thenar {

/// A key of a scene and the values that it takes in turn, as --set would write them.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

/// `key=a:b:n`: n values from a to b, evenly; `key=a:b:n:log`: by equal ratios; `key=a,b,c`: these. Bounds carry their
/// unit, "0.1 mm:2 mm:5". Commas and colons within brackets or quotes belong to a value. Throws ConfigError.
[[nodiscard]] Variation read_variation(const std::string& text);

/// A scene with all combinations of what varies; the last key turns fastest.
struct SweepPlan {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  ///< Of all rows.
  std::vector<Variation> vary;

  [[nodiscard]] std::size_t rows() const;
  /// The values of one row, one a key.
  [[nodiscard]] std::vector<std::string> values(std::size_t row) const;
  /// The changes of one row: the overrides and its values.
  [[nodiscard]] std::vector<std::string> changes(std::size_t row) const;
};

/// The files that the rows name: scenes, hands, scanned objects. Throws ConfigError and FileError.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const SweepPlan& plan);

/// Reads these files once for all rows, as long as a KeptFiles lives. Throws ConfigError and FileError.
void keep_files(const SweepPlan& plan);

/// The scene of the first row that is one. Throws ConfigError if a key varies twice, if there are more than a million
/// rows, and what is wrong with the first row if no row is a scene, as where a key is misspelt.
[[nodiscard]] Scene first_scene(const SweepPlan& plan);

/// What became of one row: the same for the same scene, to the last bit, whoever runs it; so no times.
struct SweepRow {
  Verdict verdict;
  nlohmann::ordered_json measures;  ///< Flat: name to number or null. Of a refused scene nothing.
  std::string left_out = {};        ///< What `model: auto` left out or not, and why; empty for another scene.
};

/// The row of a run that has ended: measures of summary.json by their names there, and force_chatter.
[[nodiscard]] SweepRow sweep_row(const Model& model, const Recording& recording);

/// How a row is run; called on several threads at once.
using RunScene = std::function<SweepRow(const Model& model)>;

/// The scene as it is run by `thenar run`.
[[nodiscard]] SweepRow run_row(const Model& model);

/// Who is informed of a row that has ended, and of one that has no result, and why: in any order, but never twice at
/// once.
struct SweepListener {
  std::function<void(std::size_t row, SweepRow result)> done;
  std::function<void(std::size_t row, const std::string& why)> failed;
};

/// Runs these rows, `jobs` at a time, each on one thread. A row whose scene is refused is a row, too: kRefused, and
/// why. One that found no memory, or could not read a file, has no result: another run may have one. What `run` or a
/// listener throws otherwise ends the sweep and is thrown.
void run_sweep(const SweepPlan& plan, const std::vector<std::size_t>& rows, int jobs, const RunScene& run,
               const SweepListener& listener);

/// Rows as a table, in the plan's order: what varies, outcome, reason, what `model: auto` left out, measures. A unit
/// that all values of a key share is in the header; what was not measured is empty.
[[nodiscard]] std::string rows_csv(const SweepPlan& plan, const std::map<std::size_t, SweepRow>& rows);

}  // namespace thenar
