// SPDX-License-Identifier: Apache-2.0
#include "python/recordings.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/figures/recording_page.h"
#include "engine/formats/contact_block.h"
#include "engine/formats/text.h"
#include "engine/recordings/recorded_run.h"
#include "engine/results/contact_fields.h"
#include "python/arrays.h"
#include "python/interpreter.h"
#include "python/tick_views.h"

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

constexpr double kNone[3] = {kNotMeasured, kNotMeasured, kNotMeasured};

bool is_pose(const std::string& name, const TickField* known) {
  return (known != nullptr && known->of == Of::kPose) || name == "segments";
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
    const TickField* const known = tick_field(name);
    if (is_pose(name, known) && field.count % 12 == 0 && field.count > 0) return poses_of(numbers);
    Array array({numbers.rows(), numbers.cols()});
    std::copy_n(numbers.data(), numbers.size(), array.mutable_data());
    const bool has_axes = known != nullptr && (known->of == Of::kFingerAxis || known->of == Of::kBodyAxis);
    if (has_axes && field.count % 3 == 0) {
      return array.reshape({numbers.rows(), numbers.cols() / 3, py::ssize_t{3}});
    }
    return field.count == 1 ? py::array(array.reshape({numbers.rows()})) : py::array(array);
  }
  std::vector<std::string_view> names(run.recorded.begin(), run.recorded.end());
  throw py::key_error(fmt::format("'{}'{}", name, did_you_mean(nearest_word(name, names))));
}

/// A row for each contact of each state.
struct StateContact {
  double time_s;
  ShownContact contact;
};

std::int64_t whole(double number) { return std::abs(number) < 1e15 ? static_cast<std::int64_t>(number) : -1; }

py::array contacts_of(const RecordedRun& run) {
  const auto rows = run.contacts();
  py::array array(contact_dtype(offsetof(StateContact, contact), sizeof(StateContact)), rows.rows());
  auto* const all = static_cast<char*>(array.mutable_data());
  // A recording may have fewer fields, or others of these names.
  const auto fill = [&](std::string_view name, std::size_t count, bool is_whole, std::size_t offset) {
    const auto field = std::ranges::find_if(run.contact_fields,
                                            [&](const Field& one) { return one.name == name && one.count == count; });
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const double* const from = field == run.contact_fields.end()
                                     ? kNone
                                     : rows.data() + i * rows.cols() + static_cast<Eigen::Index>(field->begin);
      char* const to = all + static_cast<std::size_t>(i) * sizeof(StateContact) + offset;
      const std::int64_t number = whole(*from);
      std::memcpy(to, is_whole ? static_cast<const void*>(&number) : from, count * sizeof(double));
    }
  };
  fill("time_s", 1, false, offsetof(StateContact, time_s));
  for (const ContactField& field : contact_fields()) {
    fill(field.name, field.count, field.is_whole, offsetof(StateContact, contact) + field.offset);
  }
  return array;
}

/// A row for each contact of each tick, where those were recorded.
struct TimedContact {
  double time_s;
  TickContact contact;
};

py::array tick_contacts_of(const RecordedRun& run) {
  const auto of = [](std::size_t offset) { return offsetof(TimedContact, contact) + offset; };
  const py::dtype kind = structure({{"time_s", "f8", 1, offsetof(TimedContact, time_s)},
                                    {"finger", "u2", 1, of(offsetof(TickContact, finger))},
                                    {"control_point", "u2", 1, of(offsetof(TickContact, control_point))},
                                    {"force_N", "f4", 3, of(offsetof(TickContact, force_N))},
                                    {"slip_m", "f4", 2, of(offsetof(TickContact, slip_m))},
                                    {"point_m", "f4", 3, of(offsetof(TickContact, point_m))},
                                    {"normal", "f4", 3, of(offsetof(TickContact, normal))},
                                    {"tangent", "f4", 3, of(offsetof(TickContact, tangent))}},
                                   sizeof(TimedContact));
  std::size_t count = 0;
  for (const ContactBlock& block : run.contact_blocks) count += block.rows.size();
  py::array array(kind, static_cast<py::ssize_t>(count));
  auto* to = static_cast<TimedContact*>(array.mutable_data());
  for (const ContactBlock& block : run.contact_blocks) {
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      *to++ = {block.time_s + static_cast<double>(i / block.contacts) * block.step_s, block.rows[i]};
    }
  }
  return array;
}

/// A recording, and the file that it was read from.
struct RecordingHandle : Constructed {
  explicit RecordingHandle(const std::filesystem::path& from)
      : file(std::filesystem::absolute(from)), run(read_recording(from)) {
    std::error_code none;
    written = std::filesystem::last_write_time(file, none);
  }

  std::filesystem::path file;
  RecordedRun run;
  std::filesystem::file_time_type written;
};

std::vector<std::string> names_of_fields(const RecordedRun& run) {
  std::vector<std::string> names;
  for (const Field& field : run.fields) names.push_back(field.name);
  return names;
}

std::string page_of(const std::filesystem::path& recording) {
  const Unlocked others;
  return recording_page(recording);
}

}  // namespace

void bind_recordings(py::module_& module) {
  module.def("_page", &page_of, py::arg("recording"));
  py::class_<RecordingHandle, std::shared_ptr<RecordingHandle>>(
      module, "Recording", R"(What a recording holds, as arrays: recording['force_N'].

A row a state. Names and units are those of Simulation and of the live window; `object` and `target` are (states, 4, 4)
poses, and what is a vector a finger is (states, fingers, 3). What a recording does not know is NaN.)")
      .def(py::init([](const std::filesystem::path& file) {
             const Unlocked others;
             return std::make_shared<RecordingHandle>(file);
           }),
           py::arg("file"), "Reads an MCAP file that thenar wrote, also one that was cut off. Raises FileError.")
      .def(
          "__getitem__",
          [](const RecordingHandle& self, const std::string& field) { return field_of(self.run, field); },
          py::arg("field"))
      .def("__contains__",
           [](const RecordingHandle& self, const py::object& key) {
             if (!py::isinstance<py::str>(key)) return false;
             const std::vector<std::string> names = names_of_fields(self.run);
             return std::ranges::count(names, text_of(key, "the name of a field")) > 0;
           })
      .def("__len__", [](const RecordingHandle& self) { return self.run.states().rows(); })
      .def("__iter__", [](const RecordingHandle& self) { return py::iter(py::cast(names_of_fields(self.run))); })
      .def_property_readonly(
          "whole", [](const RecordingHandle& self) { return self.run.reading.whole; },
          "Whether the file was ended: it was not cut off, and is sound.")
      .def(
          "keys", [](const RecordingHandle& self) { return names_of_fields(self.run); },
          "Names of the fields that the states have.")
      .def_property_readonly(
          "name", [](const RecordingHandle& self) { return self.run.name; }, "Of the scene.")
      .def_property_readonly("fingers", [](const RecordingHandle& self) { return self.run.names.fingers; })
      .def_property_readonly("joints", [](const RecordingHandle& self) { return self.run.names.joints; })
      .def_property_readonly("muscles", [](const RecordingHandle& self) { return self.run.names.muscles; })
      .def_property_readonly(
          "time_s", [](const RecordingHandle& self) { return copy(self.run.times_s()); },
          "(states,) They go back where the simulation was set back.")
      .def_property_readonly(
          "contacts", [](const RecordingHandle& self) { return contacts_of(self.run); },
          R"(Structured array of all contacts of all states, a row each.

time_s of the state, finger, control_point, point_m, normal, force_N: world axes, the force acts on the object;
normal_N, friction_N and share as `Simulation.contacts` has them, NaN where the recording does not.)")
      .def_property_readonly(
          "tick_contacts", [](const RecordingHandle& self) { return tick_contacts_of(self.run); },
          R"(Structured array of all contacts of all ticks, where `record_contacts` was asked for.

time_s, finger, control_point; force_N on the object along normal, tangent and their cross product; slip_m along the
last two in that tick; point_m, normal and tangent: world, as the message of many ticks that they are of began.)")
      .def("_repr_html_",
           [](const RecordingHandle& self) {
             std::error_code fault;
             const bool same = std::filesystem::last_write_time(self.file, fault) == self.written && !fault;
             return py::module_::import("thenar.notebook").attr("of_recording")(self.file, same);
           })
      .def("__repr__", [](const RecordingHandle& self) {
        return fmt::format("<thenar.Recording of '{}', {} states>", self.run.name, self.run.states().rows());
      });
}

}  // namespace thenar::python
