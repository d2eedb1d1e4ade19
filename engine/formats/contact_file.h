// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "solvers/contact_problem.h"

namespace thenar {

/// A contact problem, or a sequence of them that differ in delta_free.
struct ContactFile {
  std::string name;
  std::string status;                       ///< Known answer: "solved" or "no_solution"; empty if the file states none.
  std::string units, source;                ///< Text of the file; may be empty.
  Eigen::MatrixXd W;                        ///< 3n x 3n [m/N].
  std::vector<Eigen::VectorXd> delta_free;  ///< One per step, at least one [m]; several are a sequence for warm starts.
  Eigen::VectorXd mu;
  Eigen::VectorXd f_reference;      ///< Solves the first step [N]; empty if the file has none.
  Eigen::VectorXd delta_reference;  ///< [m], with f_reference.
  double reference_residual = 0.0;  ///< Natural-map residual of f_reference, stated in the file or computed.
  Eigen::VectorXd f_last;           ///< First guess for the first step [N]; empty if the file has none.

  [[nodiscard]] Eigen::Index contacts() const { return mu.size(); }
  [[nodiscard]] ContactProblem problem(std::size_t step = 0) const { return {W, delta_free[step], mu}; }
};

/// Reads a contact problem from the bytes of its file, with finite values and consistent shapes.
///
/// .fcp: `fcp 1`, then lines `key value` up to `end_header`, then little-endian doubles: W (row by
/// row), delta_free of every step, mu; with `has_ref 1` f_reference and delta_reference; with `has_f_last 1`
/// f_last. A reader without support for f_last finds spare bytes at the end.
///
/// Throws FileError: "path: what is wrong", with the line or the key.
[[nodiscard]] ContactFile read_contact_problem(const std::filesystem::path& file, const std::string& bytes);

/// Returns the bytes of its .fcp file, from which it is read back to the last bit.
/// Requires  Finite values.
[[nodiscard]] std::string contact_bytes(const ContactFile& problem);

/// Writes the .fcp file. Throws FileError.
void write_problem(const std::filesystem::path& file, const ContactFile& problem);

// Rules of all problem files.

// Beyond this, gaps are lost in the rounding of friction's term in the laws, and residuals are meaningless.
inline constexpr double kMostFriction = 1e6;
inline const std::string kNoFriction = "must lie within 0 .. 1e6";

/// Returns the index of the first entry that is not finite, or -1.
template <typename Values>
Eigen::Index first_not_finite(const Values& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values(i))) return i;
  }
  return -1;
}

/// Throws FileError if the status of a known answer is none of these words; it may be empty.
void check_status(const std::filesystem::path& file, const std::string& where, const std::string& status,
                  std::initializer_list<const char*> known);

}  // namespace thenar
