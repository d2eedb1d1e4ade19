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

/// What a recording holds, in numbers. All is SI, world axes, as docs/reference/window.md has the fields.
struct RecordedRun {
  std::string name;     ///< Of the scene.
  SignalNames names;    ///< Of fingers, joints and muscles: whose the numbers of a field are, in this order.
  McapReading reading;  ///< Whether the file was whole.

  std::vector<std::string> recorded;  ///< Names of all fields that the file has of a state.
  std::vector<Field> fields;          ///< Of a row of `numbers`: its columns begin .. begin + count.
  std::vector<double> numbers;        ///< A row a state: states().

  std::vector<Field> contact_fields;    ///< Of a row of `contact_numbers`: "time_s", then as a state message has them.
  std::vector<double> contact_numbers;  ///< A row for each contact of each state: contacts().

  std::vector<ContactBlock> contact_blocks;  ///< Every contact in every tick, where that was recorded.

  [[nodiscard]] Eigen::Map<const RowMatrix> states() const { return rows(numbers, fields); }
  [[nodiscard]] Eigen::Map<const RowMatrix> contacts() const { return rows(contact_numbers, contact_fields); }
  /// The states' columns of a field: rows x count; none, if it was not recorded.
  [[nodiscard]] RowMatrix field(const std::string& of) const;
  /// Times of the states [s]. They go back where the simulation was set back.
  [[nodiscard]] Eigen::VectorXd times_s() const { return field("time_s"); }

 private:
  static Eigen::Map<const RowMatrix> rows(const std::vector<double>& numbers, const std::vector<Field>& fields);
};

/// A field's columns of rows, also where there are none.
[[nodiscard]] RowMatrix columns_of(const Eigen::Map<const RowMatrix>& rows, const Field& field);

/// Which of a recording is wanted: the rest takes no memory.
struct WantedOfRun {
  std::function<bool(const Field&)> field = {};  ///< Nothing: all.
  bool contacts = true;                          ///< Of the states, and of ticks.
};

/// Reads a recording, also one that was cut off, or made by versions before. Where it goes on with a scene whose states
/// have a field in another size, as with other fingertips, that field is NaN from there on. Throws FileError if it is
/// no recording, has no scene, or one that cannot be read.
[[nodiscard]] RecordedRun read_recording(const std::filesystem::path& file, const WantedOfRun& wanted = {});

}  // namespace thenar
