#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace thenar {

/// A recorded contact problem: find forces f with gaps delta = W f + delta_free that obey Signorini and Coulomb.
///
/// An .fcp file is a text header of `key value` lines ended by `end_header`, then little-endian doubles:
/// W (row by row), delta_free of every step, mu, and, with `has_ref 1`, forces and gaps that solve the first step.
struct ContactProblem {
  std::string name;
  Eigen::MatrixXd W;
  std::vector<Eigen::VectorXd> delta_free;  ///< One a step; several steps are a sequence for warm starts.
  Eigen::VectorXd mu;
  Eigen::VectorXd f_reference;      ///< Empty if the file has none.
  Eigen::VectorXd delta_reference;  ///< Empty if the file has none.
  double reference_residual = 0.0;  ///< Natural-map residual of the reference, as the file states it.

  [[nodiscard]] Eigen::Index contacts() const { return mu.size(); }
};

inline ContactProblem read_contact_problem(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::map<std::string, std::string> header;
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    const auto space = line.find(' ');
    header[line.substr(0, space)] = line.substr(space + 1);
  }
  const auto read_vector = [&](Eigen::Index size) {
    Eigen::VectorXd values(size);
    file.read(reinterpret_cast<char*>(values.data()), size * static_cast<Eigen::Index>(sizeof(double)));
    return values;
  };

  ContactProblem problem;
  problem.name = header.at("name");
  const Eigen::Index rows = 3 * std::stol(header.at("contacts"));
  problem.W = read_vector(rows * rows).reshaped<Eigen::RowMajor>(rows, rows);
  for (long step = 0; step < std::stol(header.at("steps")); ++step) problem.delta_free.push_back(read_vector(rows));
  problem.mu = read_vector(rows / 3);
  if (header.at("has_ref") == "1") {
    problem.f_reference = read_vector(rows);
    problem.delta_reference = read_vector(rows);
    problem.reference_residual = std::stod(header.at("ref_error"));
  }
  if (!file) throw std::runtime_error(path.string() + ": shorter than its header says");
  return problem;
}

/// All contact problems of the test data, by name.
inline std::vector<ContactProblem> recorded_contact_problems() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(THENAR_TEST_DATA "/contact")) paths.push_back(entry);
  std::sort(paths.begin(), paths.end());
  std::vector<ContactProblem> problems;
  for (const auto& path : paths) problems.push_back(read_contact_problem(path));
  return problems;
}

}  // namespace thenar
