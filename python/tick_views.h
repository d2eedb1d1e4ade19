// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/grasp/state.h"
#include "engine/results/tick_fields.h"
#include "python/arrays.h"

/// The fields of a tick in Python.
namespace thenar::python {

/// A tick as its fields see it. Refers to its arguments; owns a chosen stiffness.
class SeenTick {
 public:
  /// `state`: after the tick.
  SeenTick(const Model& model, const TickRecord& tick, const Snapshot& state, const Eigen::VectorXd& asked_N);
  SeenTick(const SeenTick&) = delete;
  SeenTick& operator=(const SeenTick&) = delete;

  [[nodiscard]] const TickView& view() const { return view_; }
  /// Returns the numbers of a field that the scene has.
  [[nodiscard]] std::vector<double> numbers(const TickField& field);
  /// Returns the value in Python: a number; an array of the tick's own memory, which `owner` keeps alive, where numbers
  /// lie there; else a copy. Without an owner all are copies. A field that the scene does not have gives an array of no
  /// rows; a stiffness None.
  [[nodiscard]] py::object value(const TickField& field, py::handle owner = {});

 private:
  /// Makes a chosen stiffness, if the field is one.
  void prepare(const TickField& field);

  const Snapshot& state_;
  TickView view_;
  std::optional<ShownStiffness> stiffness_;
};

/// Returns the shape of one sample of a field with `numbers` numbers; empty: a number.
[[nodiscard]] std::vector<py::ssize_t> shape_of(const TickField& field, std::size_t numbers);

/// Returns the dtype of a contact, a structure of `bytes` bytes with a ShownContact at `first`; before it, where first
/// is not 0, time_s.
[[nodiscard]] py::dtype contact_dtype(std::size_t first, std::size_t bytes);

/// Returns the field's text in help().
[[nodiscard]] std::string docstring(const TickField& field);

}  // namespace thenar::python
