// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/loops/percentiles.h"
#include "engine/results/recording.h"

/// The measures of a run, described once: a row a measure. summary.json, the printed table, the columns of sweeps and
/// the page docs/reference/measures.md are made of these rows.
namespace thenar {

/// View of a run for the measures. Null members are not available.
struct RunView {
  const Model* model = nullptr;
  const Scene* scene = nullptr;
  const Recording* recording = nullptr;
  const Verdict* verdict = nullptr;
  const Ledger* ledger = nullptr;
  std::size_t item = 0;  ///< Index of the item, in a section that is a list.
};

/// Returns the view of a run, in memory that the model and the recording own.
[[nodiscard]] RunView view_of(const Model& model, const Recording& recording);

/// Nothing where a run has no such number; NaN where nothing was measured.
using MeasureValue = std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<double>,
                                  std::vector<std::string>, Percentiles>;

/// Runs that have a measure.
struct Runs {
  bool (*have)(const RunView&);
  std::string_view which;  ///< "of scenes with an environment"; empty: all.
};

/// Unit that an SI number is shown in: times the factor; as a whole number, which is nothing where none was measured.
struct Unit {
  std::string_view name = {};
  double factor = 1.0;
  bool whole = false;
};

struct RunMeasure {
  std::string_view key;  ///< Key in its section; a dot is an object within.
  const Unit& unit;
  MeasureValue (*si)(const RunView&);  ///< Value in SI units.
  std::string_view sentence;
  /// In the printed table: a line with this label, or without one the end of the line before; without both nothing.
  std::string_view label = {}, remark = {};
  int column = 0;  ///< Its place in rows.csv, from 1 on; 0: it has none. The prefix stands before its key there.
  std::string_view prefix = {};
  const Runs* runs = nullptr;  ///< Null: all that have the section.

  [[nodiscard]] bool is_in(const RunView& view) const { return runs == nullptr || runs->have(view); }
  [[nodiscard]] MeasureValue value(const RunView& view) const;  ///< Returns it in its unit.
  [[nodiscard]] std::string column_name() const { return std::string(prefix).append(key); }
};

/// Heading of a section in the printed table: those of a heading together.
enum class Heading : std::uint8_t { kRun, kGrasp, kTask, kEnvironment, kAccuracy, kTime, kSweepAlone };

/// Measures with the same object of summary.json around them: "grasp", "task.phases"; empty: the file's own. Several
/// sections may share one. A list has an object for each of its items.
struct MeasureSection {
  std::string_view key;
  Heading heading;
  const Runs* runs;
  std::span<const RunMeasure> measures;
  std::size_t (*items)(const RunView&) = nullptr;  ///< Number of items; null: no list.
};

/// Returns all sections, in the order of summary.json; those under kSweepAlone are not in it.
[[nodiscard]] std::span<const MeasureSection> measure_sections();

/// Returns the measures with a place in rows.csv, in that order.
[[nodiscard]] std::vector<const RunMeasure*> sweep_measures();

struct Measured {
  const RunMeasure* measure;
  MeasureValue value;
};

struct MeasuredSection {
  const MeasureSection* section;
  std::vector<std::vector<Measured>> items;  ///< One item if it is no list.
};

/// Returns the measures of what is available.
[[nodiscard]] std::vector<MeasuredSection> measure(const RunView& view);

}  // namespace thenar
