// SPDX-License-Identifier: Apache-2.0
#include "python/arrays.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace thenar::python {

namespace {

std::string in_words(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (const py::ssize_t size : shape) text += (text.empty() ? "" : ", ") + (size < 0 ? "n" : std::to_string(size));
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

}  // namespace

py::dtype structure(const std::vector<Member>& members, std::size_t bytes) {
  py::list names, formats, offsets;
  for (const Member& member : members) {
    names.append(member.name);
    formats.append(member.count == 1 ? py::dtype(member.kind)
                                     : py::dtype::from_args(py::make_tuple(member.kind, py::make_tuple(member.count))));
    offsets.append(member.offset);
  }
  return py::dtype(names, formats, offsets, static_cast<py::ssize_t>(bytes));
}

py::object of_json(const nlohmann::ordered_json& json) {
  return py::module_::import("json").attr("loads")(json.dump());
}

Array numbers(py::handle value, const std::vector<py::ssize_t>& shape, const std::string& name) {
  // Text, None or objects: numpy would make numbers of some of them.
  const auto any = py::array::ensure(value);
  if (!any) {
    PyErr_Clear();
    throw py::type_error(fmt::format("{} must be numbers of the shape {}", name, in_words(shape)));
  }
  const char kind = any.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') {
    throw py::type_error(fmt::format("{} must be numbers of the shape {}", name, in_words(shape)));
  }
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(any);
  if (!array) throw py::error_already_set();
  const std::vector<py::ssize_t> given(array.shape(), array.shape() + array.ndim());
  bool fits = given.size() == shape.size();
  for (std::size_t i = 0; fits && i < shape.size(); ++i) fits = shape[i] < 0 || given[i] == shape[i];
  if (!fits) throw py::value_error(fmt::format("{} has the shape {}, not {}", name, in_words(given), in_words(shape)));
  for (py::ssize_t i = 0; i < array.size(); ++i) {
    if (!std::isfinite(array.data()[i])) throw py::value_error(fmt::format("{} has a number that is not finite", name));
  }
  return array;
}

Eigen::VectorXd vector(py::handle value, py::ssize_t size, const std::string& name) {
  const Array array = numbers(value, {size}, name);
  return Eigen::Map<const Eigen::VectorXd>(array.data(), array.size());
}

Eigen::MatrixXd matrix(py::handle value, py::ssize_t rows, py::ssize_t columns, const std::string& name) {
  const Array array = numbers(value, {rows, columns}, name);
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      array.data(), array.shape(0), array.shape(1));
}

Eigen::Isometry3d pose(py::handle value, const std::string& name) {
  const Eigen::Matrix4d X = matrix(value, 4, 4, name);
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  const bool rotation = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-6 && R.determinant() > 0.0;
  if (!rotation || (X.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).norm() > 1e-12) {
    throw py::value_error(name + " is no pose: a rotation, a place, and 0 0 0 1 below");
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  pose.translation() = X.topRightCorner<3, 1>();
  return pose;
}

std::int64_t whole_number(py::handle value, const std::string& name, std::int64_t least, std::int64_t most) {
  if (PyLong_Check(value.ptr()) == 0 && PyIndex_Check(value.ptr()) == 0) {
    throw py::type_error(name + " must be a whole number");
  }
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) throw py::error_already_set();
  const std::int64_t n = PyLong_AsLongLong(index.ptr());
  if (PyErr_Occurred() != nullptr || n < least || n > most) {
    PyErr_Clear();
    throw py::value_error(fmt::format("{} must lie within {} .. {}", name, least, most));
  }
  return n;
}

double number(py::handle value, const std::string& name) {
  if (py::isinstance<py::bool_>(value)) throw py::type_error(name + " must be a number");
  const double x = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::type_error(name + " must be a number");
  }
  if (!std::isfinite(x)) throw py::value_error(name + " is not finite");
  return x;
}

}  // namespace thenar::python
