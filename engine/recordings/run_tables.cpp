// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/run_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/npz_file.h"
#include "engine/formats/text.h"
#include "engine/results/tick_fields.h"

namespace thenar {

using Eigen::Index;

namespace {

/// A row a contact of every tick. The arrays are made one after the other: all of a minute take a GB.
void add_contact_blocks(const std::vector<ContactBlock>& blocks, NpzArchive& archive) {
  if (blocks.empty()) return;
  std::size_t n = 0;
  for (const ContactBlock& block : blocks) n += block.rows.size();
  const auto add = [&]<class Number>(const char* name, std::size_t width, Number, const auto& numbers_of) {
    std::vector<Number> numbers;
    numbers.reserve(width * n);
    for (const ContactBlock& block : blocks) {
      for (std::size_t i = 0; i < block.rows.size(); ++i) {
        const auto row = numbers_of(block, i);
        numbers.insert(numbers.end(), row.begin(), row.end());
      }
    }
    archive.add<Number>(name, width == 1 ? std::vector{n} : std::vector{n, width}, numbers);
  };
  add("tick_contact_time_s", 1, double{}, [](const ContactBlock& block, std::size_t i) {
    return std::array{block.time_s + static_cast<double>(i / block.contacts) * block.step_s};
  });
  using Short = std::uint16_t;
  add("tick_contact_finger", 1, Short{}, [](const auto& block, auto i) { return std::array{block.rows[i].finger}; });
  add("tick_contact_control_point", 1, Short{},
      [](const auto& block, auto i) { return std::array{block.rows[i].control_point}; });
  add("tick_contact_force_N", 3, 0.0F, [](const auto& block, auto i) { return std::span(block.rows[i].force_N); });
  add("tick_contact_slip_m", 2, 0.0F, [](const auto& block, auto i) { return std::span(block.rows[i].slip_m); });
  add("tick_contact_point_m", 3, 0.0F, [](const auto& block, auto i) { return std::span(block.rows[i].point_m); });
  add("tick_contact_normal", 3, 0.0F, [](const auto& block, auto i) { return std::span(block.rows[i].normal); });
  add("tick_contact_tangent", 3, 0.0F, [](const auto& block, auto i) { return std::span(block.rows[i].tangent); });
}

void add_columns(const std::string& prefix, const Eigen::Map<const RowMatrix>& rows, const std::vector<Field>& fields,
                 NpzArchive& archive) {
  for (const Field& field : fields) {
    const RowMatrix columns = columns_of(rows, field);
    const auto n = static_cast<std::size_t>(rows.rows());
    const std::vector<std::size_t> shape =
        field.count == 1 ? std::vector{n} : std::vector{n, static_cast<std::size_t>(field.count)};
    archive.add<double>(prefix + field.name, shape, {columns.data(), static_cast<std::size_t>(columns.size())});
  }
}

/// Names as they may stand in a line of columns.
std::vector<std::string> columns_of(const std::vector<std::string>& names, const char* unnamed, Index count) {
  std::vector<std::string> columns;
  for (Index i = 0; i < count; ++i) {
    std::string name = i < std::ssize(names) ? names[i] : fmt::format("{}_{}", unnamed, i + 1);
    std::ranges::replace_if(
        name, [](char c) { return static_cast<unsigned char>(c) <= ' '; }, '_');
    columns.push_back(std::move(name));
  }
  return columns;
}

}  // namespace

std::string run_csv(const RecordedRun& run) {
  const std::vector<SignalColumn> columns = signal_columns(run.fields, run.names);
  std::string csv, line;
  for (const SignalColumn& column : columns) csv += (csv.empty() ? "" : ",") + csv_cell(column.name);
  csv += '\n';
  const auto states = run.states();
  for (Index row = 0; row < states.rows(); ++row) {
    line.clear();
    for (const SignalColumn& column : columns) {
      // The fewest digits that read back the same.
      fmt::format_to(std::back_inserter(line), "{}{}", line.empty() ? "" : ",",
                     column.factor * states(row, static_cast<Index>(column.at)));
    }
    csv.append(line).push_back('\n');
  }
  return csv;
}

std::string run_npz(const RecordedRun& run, const std::filesystem::path& file) {
  std::set<std::string> names;
  for (const Field& field : run.contact_fields) names.insert("contact_" + field.name);
  for (const Field& field : run.fields) {
    // Those of states may be any words.
    const bool is_own = field.name.starts_with("tick_contact_") || field.name.ends_with("_names");
    if (names.contains(field.name) || (is_own && tick_field(field.name) == nullptr)) {
      throw FileError(file, fmt::format("would have two arrays of the name '{}'", field.name));
    }
  }
  NpzArchive archive;
  add_columns("", run.states(), run.fields, archive);
  add_columns("contact_", run.contacts(), run.contact_fields, archive);
  add_contact_blocks(run.contact_blocks, archive);
  archive.add_names("finger_names", run.names.fingers);
  archive.add_names("joint_names", run.names.joints);
  archive.add_names("muscle_names", run.names.muscles);
  std::optional<std::string> bytes = archive.finish();
  if (!bytes) throw FileError(file, "would be larger than 4 GB, which an archive of arrays cannot be");
  return *std::move(bytes);
}

std::string run_sto(const RecordedRun& run, const std::filesystem::path& file) {
  const RowMatrix times_s = run.field("time_s"), q_m = run.field("q_m"), pulls_N = run.field("muscles_N");
  const RowMatrix forces_N = pulls_N.cols() > 0 ? pulls_N : run.field(kUnstretched);
  const RowMatrix q = q_m.cols() > 0 ? q_m : run.field("q_rad");
  if (times_s.cols() != 1 || q.cols() + forces_N.cols() == 0) {
    throw FileError(file, "has nothing to hold: neither joint angles nor muscle forces were recorded");
  }
  std::string rows, names;
  for (const auto& columns :
       {columns_of(run.names.joints, "joint", q.cols()), columns_of(run.names.muscles, "muscle", forces_N.cols())}) {
    for (const std::string& name : columns) names += "\t" + name;
  }
  int kept = 0;
  double last_s = -1.0;
  for (Index row = 0; row < times_s.rows(); ++row) {
    if (times_s(row, 0) <= last_s) continue;
    last_s = times_s(row, 0);
    ++kept;
    fmt::format_to(std::back_inserter(rows), "{}", last_s);
    for (const RowMatrix* part : {&q, &forces_N}) {
      for (const double number : part->row(row)) fmt::format_to(std::back_inserter(rows), "\t{}", number);
    }
    rows += '\n';
  }
  const std::string name = printable(run.name);
  return fmt::format(
      "{}\nversion=1\nnRows={}\nnColumns={}\ninDegrees=no\n\nUnits are S.I. units: seconds, radians for joint angles, "
      "metres for slides, Newtons for muscle forces.\n\nendheader\ntime{}\n{}",
      name.empty() ? "thenar" : name, kept, 1 + q.cols() + forces_N.cols(), names, rows);
}

}  // namespace thenar
