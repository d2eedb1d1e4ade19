// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "engine/finder/found_grasp.h"

namespace thenar {

/// A measure of a found grasp, described once. The table of `thenar grasp` and its legend, the window's message and its
/// cards, Python's properties, and the tables of the reference are made of these rows.
struct GraspMeasure {
  std::string_view name = {}, unit = {};  ///< In messages and Python. Unit: empty for a plain number.
  /// In tables, times the factor and with so many digits after the point. Measures that are shown by the same name
  /// share a column: a grasp shows the first of them that it has. Empty: no table shows it.
  std::string_view shown = {}, shown_unit = {};
  double factor = 1.0;
  int digits = 2;
  std::string_view sentence = {};
  double (*value)(const FoundGrasp&) = nullptr;
  bool (*has)(const FoundGrasp&) = nullptr;  ///< Null: every grasp has it.

  [[nodiscard]] bool is_of(const FoundGrasp& grasp) const { return has == nullptr || has(grasp); }
  [[nodiscard]] double shown_value(const FoundGrasp& grasp) const { return factor * value(grasp); }
};

/// Returns all of them, in the order of a table.
[[nodiscard]] std::span<const GraspMeasure> grasp_measures();

/// Returns the measure of this name. Throws std::out_of_range if there is none.
[[nodiscard]] const GraspMeasure& grasp_measure(std::string_view name);

/// Returns the normal force of a finger on the object, against the weight [N].
[[nodiscard]] double press_N(const FoundGrasp& grasp, const FingerPlace& place);

}  // namespace thenar
