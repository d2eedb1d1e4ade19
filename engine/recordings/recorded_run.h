// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/formats/contact_block.h"
#include "engine/formats/mcap_reader.h"
#include "engine/recordings/signal_columns.h"
#include "engine/recordings/state_message.h"

namespace thenar {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Contents of a recording in numbers. All is SI, world axes, as docs/reference/window.md has the fields.
struct RecordedRun {
  std::string name;     ///< Name of the scene.
  SignalNames names;    ///< Names of fingers, joints and muscles, in the order of the numbers of a field.
  McapReading reading;  ///< Says if the file was whole.

  std::vector<std::string> recorded;  ///< Names of all fields that the file has of a state.
  std::vector<Field> fields;          ///< Fields of a row of `numbers`: columns begin .. begin + count.
  std::vector<double> numbers;        ///< A row a state: states().

  std::vector<Field> contact_fields;    ///< Those of `contact_numbers`: "time_s", then as in a state message.
  std::vector<double> contact_numbers;  ///< A row for each contact of each state: contacts().

  std::vector<ContactBlock> contact_blocks;  ///< Every contact in every tick, where that was recorded.

  [[nodiscard]] Eigen::Map<const RowMatrix> states() const { return rows(numbers, fields); }
  [[nodiscard]] Eigen::Map<const RowMatrix> contacts() const { return rows(contact_numbers, contact_fields); }
  /// Returns the states' columns of a field: rows x count; none if it was not recorded.
  [[nodiscard]] RowMatrix field(const std::string& of) const;
  /// Returns the times of the states [s]. They go back where the simulation was set back.
  [[nodiscard]] Eigen::VectorXd times_s() const { return field("time_s"); }

 private:
  static Eigen::Map<const RowMatrix> rows(const std::vector<double>& numbers, const std::vector<Field>& fields);
};

/// Returns a field's columns of rows, also where there are none.
[[nodiscard]] RowMatrix columns_of(const Eigen::Map<const RowMatrix>& rows, const Field& field);

/// Wanted part of a recording; the rest takes no memory.
struct WantedOfRun {
  std::function<bool(const Field&)> field = {};  ///< Fields wanted; empty: all.
  bool contacts = true;                          ///< Contacts of the states and of ticks.
};

/// Reads a recording, also one that was cut off, or made by versions before. Where it goes on with a scene whose states
/// have a field in another size, as with other fingertips, that field is NaN from there on. The file is untrusted:
/// memory is in proportion to what it unpacks to, see read_mcap(), and names of fields are words, those of fingers,
/// joints, muscles and bodies printable. Throws FileError if it is no recording, has no scene, or one that cannot be
/// read, or if it does not fit into memory.
[[nodiscard]] RecordedRun read_recording(const std::filesystem::path& file, const WantedOfRun& wanted = {});

}  // namespace thenar
