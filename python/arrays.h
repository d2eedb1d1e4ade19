// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/hand/hand.h"

/// Numbers of the engine as numpy arrays, and back.
namespace thenar::python {

namespace py = pybind11;
using Array = py::array_t<double>;

/// Returns a read-only array on the engine's own memory: shape and strides [elements of double]. `owner` lives as long
/// as it.
inline Array view(const double* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                  py::handle owner) {
  for (py::ssize_t& stride : strides) stride *= static_cast<py::ssize_t>(sizeof(double));
  Array array(std::move(shape), std::move(strides), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

template <typename Matrix>
Array view_of_matrix(const Matrix& m, py::handle owner) {
  return view(m.data(), {m.rows(), m.cols()}, {1, m.outerStride()}, owner);
}

/// A member of a structure: its name, how numpy calls its kind, how many of them, and where they are.
struct Member {
  const char* name;
  const char* kind;
  py::ssize_t count;
  std::size_t offset;
};
/// Returns the dtype of structures of `bytes` bytes.
[[nodiscard]] py::dtype structure(const std::vector<Member>& members, std::size_t bytes);

/// Returns a copy, row by row.
template <typename Derived>
Array copy(const Eigen::MatrixBase<Derived>& m) {
  if constexpr (Derived::ColsAtCompileTime == 1) {
    Array array(m.size());
    Eigen::Map<Eigen::VectorXd>(array.mutable_data(), m.size()) = m;
    return array;
  } else {
    Array array({m.rows(), m.cols()});
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(array.mutable_data(), m.rows(),
                                                                                       m.cols()) = m;
    return array;
  }
}

/// Returns the JSON in Python: dicts, lists, text and numbers.
[[nodiscard]] py::object of_json(const nlohmann::ordered_json& json);

/// Read numbers of a caller, finite and of this shape; a dimension of -1 may be of any size. Raises ValueError or
/// TypeError that names them.
Array numbers(py::handle value, const std::vector<py::ssize_t>& shape, const std::string& name);
Eigen::VectorXd vector(py::handle value, py::ssize_t size, const std::string& name);
Eigen::MatrixXd matrix(py::handle value, py::ssize_t rows, py::ssize_t columns, const std::string& name);
/// Reads a 4 x 4 matrix of a rotation and a place.
Eigen::Isometry3d pose(py::handle value, const std::string& name);
/// Reads a whole number, within bounds.
std::int64_t whole_number(py::handle value, const std::string& name, std::int64_t least, std::int64_t most);
/// Reads a finite number.
double number(py::handle value, const std::string& name);

}  // namespace thenar::python
