// SPDX-License-Identifier: Apache-2.0
#include "python/tick_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "engine/results/contact_fields.h"

namespace thenar::python {

namespace {

bool is_number(Of of) { return of == Of::kNumber || of == Of::kCount || of == Of::kFlag; }

py::object number_of(Of of, double number) {
  if (of == Of::kFlag) return py::bool_(number != 0.0);
  if (of == Of::kCount) return py::int_(static_cast<std::int64_t>(number));
  return py::float_(number);
}

std::string_view shape_in_words(Of of) {
  switch (of) {
    case Of::kAxis:
    case Of::kPercentile:
      return "(3,) ";
    case Of::kPose:
      return "(4, 4) ";
    case Of::kFinger:
      return "(fingers,) ";
    case Of::kFingerAxis:
      return "(fingers, 3) ";
    case Of::kBodyAxis:
      return "(bodies, 3) ";
    case Of::kJoint:
      return "(joints,) ";
    case Of::kMuscle:
      return "(muscles,) ";
    default:
      return "";
  }
}

template <typename Vector>
std::span<const double> span_of(const Vector& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

}  // namespace

SeenTick::SeenTick(const Model& model, const TickRecord& tick, const Snapshot& state, const Eigen::VectorXd& asked_N)
    : state_(state), view_(view_of(model, tick, span_of(state.pull_N), span_of(asked_N))) {}

void SeenTick::prepare(const TickField& field) {
  if (field.from != From::kState || stiffness_) return;
  stiffness_ = shown_stiffness(view_.model, state_, view_.tick.stiffness);
  view_.stiffness = &*stiffness_;
}

std::vector<double> SeenTick::numbers(const TickField& field) {
  std::vector<double> numbers;
  prepare(field);
  if (field.of != Of::kPose) {
    add_numbers(field, view_, numbers);
    return numbers;
  }
  const double* const columns = field.at(view_).first;
  for (int i = 0; i < 16; ++i) numbers.push_back(columns[4 * (i % 4) + i / 4]);
  return numbers;
}

py::object SeenTick::value(const TickField& field, py::handle owner) {
  const bool is_there = field.is_in(view_.model);
  if (!is_there && field.from == From::kState) return py::none();
  if (!is_number(field.of) && owner && field.at != nullptr && field.from == From::kTick) {
    const FieldNumbers place = field.at(view_);
    if (field.of == Of::kPose) return python::view(place.first, {4, 4}, {1, 4}, owner);
    const py::ssize_t rows = is_there ? place.rows : 0;
    if (place.columns == 1) return python::view(place.first, {rows}, {place.stride}, owner);
    return python::view(place.first, {rows, place.columns}, {place.stride, 1}, owner);
  }
  std::vector<double> all;
  if (is_there || is_number(field.of)) all = numbers(field);
  if (is_number(field.of)) return number_of(field.of, all.front());
  Array array(shape_of(field, all.size()));
  std::ranges::copy(all, array.mutable_data());
  return array;
}

std::vector<py::ssize_t> shape_of(const TickField& field, std::size_t numbers) {
  const auto count = static_cast<py::ssize_t>(numbers);
  if (is_number(field.of) && numbers > 0) return {};
  if (field.of == Of::kPose) return {4, 4};
  if (field.of == Of::kFingerAxis || field.of == Of::kBodyAxis) return {count / 3, 3};
  return {count};
}

py::dtype contact_dtype(std::size_t first, std::size_t bytes) {
  std::vector<Member> members;
  if (first > 0) members.push_back({"time_s", "f8", 1, 0});
  for (const ContactField& field : contact_fields()) {
    members.push_back(
        {field.name.data(), field.is_whole ? "i8" : "f8", static_cast<py::ssize_t>(field.count), first + field.offset});
  }
  return structure(members, bytes);
}

std::string docstring(const TickField& field) {
  std::string text = fmt::format("{}{}", shape_in_words(field.of), field.sentence);
  if (!field.unit.empty()) text += fmt::format(" [{}]", field.unit);
  if (field.scenes != nullptr) text += fmt::format(" Only {}.", field.scenes->which);
  return text;
}

}  // namespace thenar::python
