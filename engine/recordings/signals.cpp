// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/signals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <iterator>
#include <span>

#include "engine/formats/text.h"
#include "engine/recordings/signal_columns.h"
#include "engine/results/tick_fields.h"

namespace thenar {

using Eigen::Index;

namespace {

/// Which fields signals.csv has, and its columns; their `at` is in the fields' numbers, one after the other.
struct Layout {
  std::vector<const TickField*> fields;
  std::vector<SignalColumn> columns;
};

TickView view_at(const Model& model, const Recording& recording, std::size_t i) {
  const auto column = [i](const Eigen::MatrixXd& all) -> std::span<const double> {
    if (all.rows() == 0) return {};
    return {all.col(static_cast<Index>(i)).data(), static_cast<std::size_t>(all.rows())};
  };
  return view_of(model, recording.ticks[i], column(recording.muscle_forces_N), column(recording.muscles_asked_N));
}

bool is_of_fingers(const std::pair<const TickField*, Field>& field) { return field.first->of == Of::kFinger; }

Layout layout_of(const Model& model) {
  const TickRecord blank(model.scene.hand);
  const std::vector<double> muscle_N(model.scene.has_muscles() ? model.scene.hand.muscles.size() : 0);
  const TickView view = view_of(model, blank, muscle_N, muscle_N);
  const SignalNames names = signal_names(model);
  Layout layout;
  std::vector<double> numbers;
  for (int block = 0; block < static_cast<int>(Block::kNone); ++block) {
    std::vector<std::pair<const TickField*, Field>> fields;
    for (const TickField& field : tick_fields()) {
      if (field.block != static_cast<Block>(block) || !field.is_in(model)) continue;
      const std::size_t begin = numbers.size();
      add_numbers(field, view, numbers);
      layout.fields.push_back(&field);
      fields.emplace_back(&field,
                          Field{std::string(field.name), std::string(field.unit), begin, numbers.size() - begin});
    }
    const bool by_finger = std::ranges::all_of(fields, is_of_fingers);
    for (int k = 0; by_finger && k < model.fingers(); ++k) {
      for (const auto& [known, field] : fields) layout.columns.push_back(signal_column(field, k, names));
    }
    for (const auto& [known, field] : fields) {
      for (std::size_t i = 0; !by_finger && i < field.count; ++i) {
        layout.columns.push_back(signal_column(field, i, names));
      }
    }
  }
  return layout;
}

/// Calls sink(tick, column, number) row by row.
template <class Sink>
void for_each_number(const Model& model, const Recording& recording, const Layout& layout, Sink&& sink) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
    numbers.clear();
    const TickView view = view_at(model, recording, i);
    for (const TickField* field : layout.fields) add_numbers(*field, view, numbers);
    assert(numbers.size() == layout.columns.size());
    for (std::size_t c = 0; c < layout.columns.size(); ++c) {
      const SignalColumn& column = layout.columns[c];
      sink(i, c, column.factor * numbers[column.at]);
    }
  }
}

}  // namespace

SignalTable signal_table(const Model& model, const Recording& recording) {
  const Layout layout = layout_of(model);
  SignalTable table;
  for (const SignalColumn& column : layout.columns) table.names.push_back(column.name);
  table.numbers.resize(std::ssize(recording.ticks), std::ssize(table.names));
  for_each_number(model, recording, layout, [&](std::size_t i, std::size_t c, double number) {
    table.numbers(static_cast<Index>(i), static_cast<Index>(c)) = number;
  });
  return table;
}

std::string signals_csv(const Model& model, const Recording& recording) {
  const Layout layout = layout_of(model);
  std::string csv;
  for (const SignalColumn& column : layout.columns) csv += (csv.empty() ? "" : ",") + csv_cell(column.name);
  for_each_number(model, recording, layout, [&](std::size_t, std::size_t c, double number) {
    fmt::format_to(std::back_inserter(csv), "{}{:.9g}", c == 0 ? '\n' : ',', number);
  });
  return csv + "\n";
}

}  // namespace thenar
