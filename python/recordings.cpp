#include "python/recordings.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/formats/text.h"
#include "engine/results/recorded_run.h"
#include "python/arrays.h"

namespace thenar::python {

namespace {

/// A pose as states have it, a place and then a rotation by rows, as a 4 x 4 matrix.
void write_pose(const double* from, double* to) {
  for (int row = 0; row < 3; ++row) {
    std::copy_n(from + 3 + 3 * row, 3, to + 4 * row);
    to[4 * row + 3] = from[row];
  }
  std::copy_n(std::array{0.0, 0.0, 0.0, 1.0}.data(), 4, to + 12);
}

bool is_pose(const std::string& name) { return name == "object" || name == "target" || name == "segments"; }
bool is_vector_of_fingers(const std::string& name) {
  return name == "force_N" || name == "desired_N" || name == "centre_m" || name == "normal";
}

py::array poses_of(const RowMatrix& numbers) {
  const py::ssize_t states = numbers.rows(), each = numbers.cols() / 12;
  Array array({states, each, py::ssize_t{4}, py::ssize_t{4}});
  for (py::ssize_t i = 0; i < states * each; ++i) write_pose(numbers.data() + 12 * i, array.mutable_data() + 16 * i);
  return each == 1 ? py::array(array.reshape({states, py::ssize_t{4}, py::ssize_t{4}})) : py::array(array);
}

py::array field_of(const RecordedRun& run, const std::string& name) {
  for (const Field& field : run.fields) {
    if (field.name != name) continue;
    const RowMatrix numbers = run.field(name);
    if (is_pose(name) && field.count % 12 == 0 && field.count > 0) return poses_of(numbers);
    Array array({numbers.rows(), numbers.cols()});
    std::copy_n(numbers.data(), numbers.size(), array.mutable_data());
    if (is_vector_of_fingers(name) && field.count % 3 == 0) {
      return array.reshape({numbers.rows(), numbers.cols() / 3, py::ssize_t{3}});
    }
    return field.count == 1 ? py::array(array.reshape({numbers.rows()})) : py::array(array);
  }
  std::vector<std::string_view> names(run.recorded.begin(), run.recorded.end());
  throw py::key_error(fmt::format("'{}'{}", name, did_you_mean(nearest_word(name, names))));
}

/// A row for each contact of each state, its columns by name.
py::dict contacts_of(const RecordedRun& run) {
  const auto rows = run.contacts();
  py::dict columns;
  for (const Field& field : run.contact_fields) {
    const RowMatrix part =
        rows.middleCols(static_cast<Eigen::Index>(field.begin), static_cast<Eigen::Index>(field.count));
    Array array({part.rows(), part.cols()});
    std::copy_n(part.data(), part.size(), array.mutable_data());
    py::array column = field.count == 1 ? py::array(array.reshape({part.rows()})) : py::array(array);
    if (field.name == "finger" || field.name == "control_point") column = column.attr("astype")("i8");
    columns[py::str(field.name)] = column;
  }
  return columns;
}

std::vector<std::string> names_of_fields(const RecordedRun& run) {
  std::vector<std::string> names;
  for (const Field& field : run.fields) names.push_back(field.name);
  return names;
}

}  // namespace

void bind_recordings(py::module_& module) {
  py::class_<RecordedRun>(module, "Recording", R"(What a recording holds, as arrays: recording['force_N'].

A row a state. Names and units are those of Simulation and of the live window; `object` and `target` are (states, 4, 4)
poses, and what is a vector a finger is (states, fingers, 3). What a recording does not know is NaN.)")
      .def(py::init([](const std::filesystem::path& file) {
             const py::gil_scoped_release others;
             return std::make_unique<RecordedRun>(read_recording(file));
           }),
           py::arg("file"), "Reads an MCAP file that thenar wrote, also one that was cut off. Raises FileError.")
      .def("__getitem__", &field_of, py::arg("field"))
      .def("__contains__",
           [](const RecordedRun& run, const std::string& name) {
             const std::vector<std::string> names = names_of_fields(run);
             return std::find(names.begin(), names.end(), name) != names.end();
           })
      .def("__len__", [](const RecordedRun& run) { return run.states().rows(); })
      .def("__iter__", [](const RecordedRun& run) { return py::iter(py::cast(names_of_fields(run))); })
      .def_property_readonly(
          "whole", [](const RecordedRun& run) { return run.reading.whole; },
          "Whether the file was ended: it was not cut off, and is sound.")
      .def("keys", &names_of_fields, "Names of the fields that the states have.")
      .def_property_readonly(
          "name", [](const RecordedRun& run) { return run.name; }, "Of the scene.")
      .def_property_readonly("fingers", [](const RecordedRun& run) { return run.names.fingers; })
      .def_property_readonly("joints", [](const RecordedRun& run) { return run.names.joints; })
      .def_property_readonly("muscles", [](const RecordedRun& run) { return run.names.muscles; })
      .def_property_readonly(
          "time_s", [](const RecordedRun& run) { return copy(run.times_s()); },
          "(states,) They go back where the simulation was set back.")
      .def_property_readonly("contacts", &contacts_of, R"(All contacts of all states, a dict of columns.

time_s of the state, finger, control_point, point_m, normal, force_N: world axes, the force acts on the object.)")
      .def("__repr__", [](const RecordedRun& run) {
        return fmt::format("<thenar.Recording of '{}', {} states>", run.name, run.states().rows());
      });
}

}  // namespace thenar::python
