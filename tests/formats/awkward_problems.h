// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "engine/formats/files.h"
#include "engine/formats/problem_file.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

/// Numbers that printing loses most easily, and files of them.
namespace thenar::awkward_problems {

using Eigen::Index;
using Eigen::MatrixXd;
namespace fs = std::filesystem;

/// Numbers of all magnitudes and signs; the first four are those that printing loses most easily.
inline MatrixXd awkward(Index rows, Index cols, std::mt19937_64& random) {
  MatrixXd values(rows, cols);
  for (Index i = 0; i < values.size(); ++i) {
    values(i) = std::ldexp(uniform(random, -1.0, 1.0), static_cast<int>(uniform(random, -60.0, 60.0)));
  }
  const double special[] = {-0.0, 5e-324, std::numeric_limits<double>::max(), 0.1};
  for (Index i = 0; i < std::min<Index>(4, values.size()); ++i) values(i) = special[i];
  return values;
}

/// Two contacts and three steps.
inline ContactFile contact_problem(std::mt19937_64& random) {
  ContactFile problem;
  problem.name = "two contacts";
  problem.status = "solved";
  problem.units = "SI";
  problem.source = "a test";
  problem.W = awkward(6, 6, random);
  problem.W.diagonal() = problem.W.diagonal().cwiseAbs().eval();
  problem.delta_free = {awkward(6, 1, random), awkward(6, 1, random), awkward(6, 1, random)};
  problem.mu = (Eigen::VectorXd(2) << 0.0, 0.3).finished();
  problem.f_reference = awkward(6, 1, random);
  problem.delta_reference = awkward(6, 1, random);
  problem.reference_residual = 1.0 / 3.0;
  problem.f_last = awkward(6, 1, random);
  return problem;
}

/// A finger of three joints and one of one, five muscles, one without a limit.
inline StiffMuscleData awkward_stiffness(std::mt19937_64& random) {
  const auto symmetric = [&] { return Matrix6d(awkward(6, 6, random).selfadjointView<Eigen::Lower>()); };
  StiffMuscleData p;
  p.H = awkward(4, 5, random);
  p.tau = awkward(4, 1, random);
  p.limit = awkward(5, 1, random).cwiseAbs();
  p.limit[2] = std::numeric_limits<double>::infinity();
  p.joints = {3, 1};
  p.arm = awkward(4, 5, random);
  p.turn = awkward(7, 5, random);
  p.fibre_per_m = awkward(5, 1, random).cwiseAbs().array() + 5e-324;
  p.tendon_N_per_m = awkward(5, 1, random).cwiseAbs().array() + 5e-324;
  p.tendon_N_per_m[1] = std::numeric_limits<double>::infinity();
  p.A = symmetric();
  p.B = awkward(6, 4, random);
  p.D = awkward(4, 4, random);
  p.K_des = symmetric();
  p.kappa = -0.1;
  p.length_m = 1.0 / 3.0;
  return p;
}

template <typename Matrix>
bool same_bits(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

template <typename File>
File written_and_read(const File& problem, const char* name) {
  const fs::path file = scratch() / name;
  write_problem(file, problem);
  return std::get<File>(read_problem(file));
}

inline void expect_refused(const fs::path& file, const std::string& bytes, const std::string& message) {
  write_file(file, bytes);
  try {
    (void)read_problem(file);
    ADD_FAILURE() << "was read; it should say: " << message;
  } catch (const FileError& error) {
    const std::string what = error.what();
    EXPECT_TRUE(what.starts_with(file.string() + ": ")) << what;
    EXPECT_NE(what.find(message), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  }
}

inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

}  // namespace thenar::awkward_problems
