// SPDX-License-Identifier: Apache-2.0
// Contact problems in the format of FCLIB: its library reads what we write and we read what it writes, both to the last
// bit; a global problem is the local one that it stands for; what is broken is refused in words that say where.

#include "engine/formats/fclib_file.h"

#include <gtest/gtest.h>

#ifdef THENAR_FCLIB
#include <hdf5.h>
#include <hdf5_hl.h>

#include <Eigen/LU>
#include <random>
#include <vector>

extern "C" {
#include <fclib.h>
}

#include "tests/formats/awkward_problems.h"
#include "tests/support/recorded_problems.h"

namespace thenar::fclib_file_test {
namespace {

using namespace awkward_problems;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index cols, std::mt19937_64& random) {
  MatrixXd matrix(rows, cols);
  for (double& value : matrix.reshaped()) value = uniform(random, -1.0, 1.0);
  return matrix;
}

MatrixXd random_symmetric(Index size, std::mt19937_64& random) {
  const MatrixXd half = random_matrix(size, size, random);
  return half * half.transpose() + MatrixXd::Identity(size, size);
}

/// How a matrix lies in a file.
enum Storage { kTriplets, kColumns, kRows };

/// A matrix as the library of FCLIB has it, with zeros left out. Triplets state each entry as two halves.
class FclibMatrix {
 public:
  FclibMatrix(const MatrixXd& matrix, Storage storage) {
    const MatrixXd lines = storage == kRows ? MatrixXd(matrix.transpose()) : matrix;  // In rows: by their columns.
    for (int col = 0; col < lines.cols(); ++col) {
      if (storage != kTriplets) p_.push_back(static_cast<int>(x_.size()));
      for (int row = 0; row < lines.rows(); ++row) {
        for (int half = 0; half < (storage == kTriplets ? 2 : 1) && lines(row, col) != 0.0; ++half) {
          if (storage == kTriplets) p_.push_back(col);
          i_.push_back(row);
          x_.push_back(storage == kTriplets ? lines(row, col) / 2.0 : lines(row, col));
        }
      }
    }
    const int entries = static_cast<int>(x_.size());
    if (storage != kTriplets) p_.push_back(entries);
    const int nz = storage == kTriplets ? entries : storage == kColumns ? -1 : -2;
    matrix_ = {
        entries, static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols()), p_.data(), i_.data(), x_.data(), nz,
        nullptr};
  }
  fclib_matrix* get() { return &matrix_; }

 private:
  std::vector<int> p_, i_;
  std::vector<double> x_;
  fclib_matrix matrix_;
};

MatrixXd dense(const fclib_matrix& matrix) {
  MatrixXd result = MatrixXd::Zero(matrix.m, matrix.n);
  EXPECT_EQ(matrix.nz, -1) << "in columns";
  for (int col = 0; col < matrix.n; ++col) {
    for (int k = matrix.p[col]; k < matrix.p[col + 1]; ++k) result(matrix.i[k], col) = matrix.x[k];
  }
  return result;
}

struct Local {
  MatrixXd W;
  VectorXd q, mu;
};

Local random_local(std::mt19937_64& random) {
  return {random_symmetric(6, random), random_matrix(6, 1, random), (VectorXd(2) << 0.5, 0.0).finished()};
}

std::string title = "two contacts", description = "a test", known = "no_solution";
fclib_info info{title.data(), description.data(), known.data()};

/// A fresh file that the library of FCLIB has written.
fs::path write_local(Local problem, Storage storage, int spacedim = 3) {
  const fs::path file = scratch() / "library.hdf5";
  FclibMatrix W(problem.W, storage);
  fclib_local local{W.get(), nullptr, nullptr, problem.mu.data(), problem.q.data(), nullptr, spacedim, &info};
  EXPECT_EQ(fclib_write_local(&local, file.c_str()), 1);
  return file;
}

ContactFile read_contact(const fs::path& file) { return std::get<ContactFile>(read_problem(file)); }

TEST(FclibFile, AProblemIsReadBackToTheLastBit) {
  std::mt19937_64 random(1);
  ContactFile problem = contact_problem(random);
  // Gaps are computed from these, and must be numbers.
  problem.W(2) = problem.delta_free[0][2] = problem.f_reference[2] = 0.1;
  for (const char* name : {"problem.hdf5", "problem.h5"}) {
    const fs::path file = scratch() / name;
    write_fclib_problem(file, problem);
    const ContactFile read = read_contact(file);
    EXPECT_EQ(read.name, problem.name);
    EXPECT_EQ(read.status, problem.status);
    EXPECT_EQ(read.units, problem.units);
    EXPECT_EQ(read.source, problem.source);
    EXPECT_TRUE(same_bits(read.W, problem.W));
    ASSERT_EQ(read.delta_free.size(), 1U) << "the first step";
    EXPECT_TRUE(same_bits(read.delta_free[0], problem.delta_free[0]));
    EXPECT_TRUE(same_bits(read.mu, problem.mu));
    EXPECT_TRUE(same_bits(read.f_reference, problem.f_reference));
    EXPECT_TRUE(same_bits(read.f_last, problem.f_last));
  }
}

// Forces and gaps keep their signs and their order, normal first: a solution is one of the file's problem, too.
TEST(FclibFile, SolutionsOfRecordedProblemsStaySolutions) {
  for (const ContactFile& problem : recorded_contact_problems()) {
    SCOPED_TRACE(problem.name);
    const fs::path file = scratch() / "problem.hdf5";
    write_fclib_problem(file, problem);
    const ContactFile read = read_contact(file);
    EXPECT_TRUE(same_bits(read.W, problem.W));
    EXPECT_TRUE(same_bits(read.f_reference, problem.f_reference));
    EXPECT_EQ(read.units, problem.units);
    // Gaps are computed again, to the rounding of a sum of 3n terms.
    const double terms_m = (problem.W.cwiseAbs() * problem.f_reference.cwiseAbs()).maxCoeff();
    EXPECT_LE((read.delta_reference - problem.delta_reference).cwiseAbs().maxCoeff(), 1e-14 * terms_m);
    EXPECT_LE(read.reference_residual, 1e-9) << "the references are known to 1e-10";
  }
}

TEST(FclibFile, ReadsWhatItsLibraryWrites) {
  std::mt19937_64 random(2);
  const Local local = random_local(random);
  for (const Storage storage : {kTriplets, kColumns, kRows}) {
    SCOPED_TRACE(storage);
    const fs::path file = write_local(local, storage);
    EXPECT_EQ(read_contact(file).f_reference.size(), 0);
    VectorXd u = random_matrix(6, 1, random), r = random_matrix(6, 1, random), guess = random_matrix(6, 1, random);
    fclib_solution solution{nullptr, u.data(), r.data(), nullptr}, first{nullptr, u.data(), guess.data(), nullptr};
    ASSERT_EQ(fclib_write_solution(&solution, file.c_str()), 1);
    ASSERT_EQ(fclib_write_guesses(1, &first, file.c_str()), 1);

    const ContactFile read = read_contact(file);
    EXPECT_TRUE(same_bits(read.W, local.W));
    EXPECT_TRUE(same_bits(read.delta_free.at(0), local.q));
    EXPECT_TRUE(same_bits(read.mu, local.mu));
    EXPECT_TRUE(same_bits(read.f_reference, r));
    EXPECT_TRUE(same_bits(read.f_last, guess));
    EXPECT_EQ(read.name, title);
    EXPECT_EQ(read.source, description);
    EXPECT_EQ(read.units, kUnitsOfFclib);
    EXPECT_EQ(read.status, known);
    EXPECT_GT(read.reference_residual, 1e-3) << "a random force solves nothing, whatever its file says";
  }
}

TEST(FclibFile, ItsLibraryReadsWhatIsWritten) {
  std::mt19937_64 random(3);
  const ContactFile problem = contact_problem(random);
  const fs::path file = scratch() / "ours.hdf5";
  write_fclib_problem(file, problem);
  fclib_local* const local = fclib_read_local(file.c_str());
  ASSERT_NE(local, nullptr);
  EXPECT_EQ(local->spacedim, 3);
  EXPECT_TRUE(same_bits(dense(*local->W), problem.W));
  EXPECT_TRUE(same_bits(VectorXd(VectorXd::Map(local->q, 6)), problem.delta_free[0]));
  EXPECT_TRUE(same_bits(VectorXd(VectorXd::Map(local->mu, 2)), problem.mu));
  EXPECT_EQ(local->V, nullptr);
  EXPECT_STREQ(local->info->title, "two contacts");
  EXPECT_STREQ(local->info->description, "a test; units: SI");
  EXPECT_STREQ(local->info->math_info, "solved");
  fclib_delete_local(local);

  fclib_solution* const solution = fclib_read_solution(file.c_str());
  EXPECT_TRUE(same_bits(VectorXd(VectorXd::Map(solution->r, 6)), problem.f_reference));
  EXPECT_TRUE(same_bits(VectorXd(VectorXd::Map(solution->u, 6)), problem.delta_reference));
  fclib_delete_solutions(solution, 1);
  int guesses = 0;
  fclib_solution* const guess = fclib_read_guesses(file.c_str(), &guesses);
  ASSERT_EQ(guesses, 1);
  EXPECT_TRUE(same_bits(VectorXd(VectorXd::Map(guess->r, 6)), problem.f_last));
  fclib_delete_solutions(guess, 1);
}

/// M v = H r + G l + f, G'v + b = 0, u = H'v + w.
struct Global {
  MatrixXd M, H, G;
  VectorXd f, w, b, mu;

  /// u for these forces, by a dense solve of the equations as they stand.
  [[nodiscard]] VectorXd motion(const VectorXd& r) const {
    const Index n = M.rows(), p = G.cols();
    MatrixXd K(n + p, n + p);
    K << M, -G, G.transpose(), MatrixXd::Zero(p, p);
    VectorXd right(n + p);
    right << H * r + f, -b;
    return H.transpose() * K.fullPivLu().solve(right).head(n) + w;
  }
};

fs::path write_global(Global problem, Storage storage) {
  const fs::path file = scratch() / "global.hdf5";
  FclibMatrix M(problem.M, storage), H(problem.H, storage), G(problem.G, storage);
  const bool has_G = problem.G.cols() > 0;
  fclib_global global{M.get(),
                      H.get(),
                      has_G ? G.get() : nullptr,
                      problem.mu.data(),
                      problem.f.data(),
                      has_G ? problem.b.data() : nullptr,
                      problem.w.data(),
                      3,
                      &info};
  EXPECT_EQ(fclib_write_global(&global, file.c_str()), 1);
  return file;
}

Global random_global(Index equations, std::mt19937_64& random) {
  return {random_symmetric(12, random), random_matrix(12, 6, random), random_matrix(12, equations, random),
          random_matrix(12, 1, random), random_matrix(6, 1, random),  random_matrix(equations, 1, random),
          VectorXd::Constant(2, 0.4)};
}

TEST(FclibFile, AGlobalProblemIsTheLocalOneThatItStandsFor) {
  std::mt19937_64 random(4);
  for (const Index equations : {0, 3}) {
    const Global global = random_global(equations, random);
    for (const Storage storage : {kTriplets, kColumns, kRows}) {
      SCOPED_TRACE(storage);
      const ContactFile read = read_contact(write_global(global, storage));
      EXPECT_TRUE(same_bits(read.mu, global.mu));
      EXPECT_EQ(read.name, title);
      for (int i = 0; i < 10; ++i) {
        const VectorXd r = random_matrix(6, 1, random), u = global.motion(r);
        // Two eliminations of a matrix with a condition below 1e3: rounding, times that.
        EXPECT_LE((read.W * r + read.delta_free.at(0) - u).norm(), 1e-12 * u.norm());
      }
    }
  }
}

// ---- broken files ----

/// Puts other numbers in the place of a data set.
void replace(const fs::path& file, const char* name, const std::vector<double>& values) {
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hsize_t size = values.size();
  ASSERT_GE(H5Ldelete(id, name, H5P_DEFAULT), 0);
  ASSERT_GE(H5LTmake_dataset_double(id, name, 1, &size, values.data()), 0);
  H5Fclose(id);
}
void replace(const fs::path& file, const char* name, const std::vector<int>& values) {
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hsize_t size = values.size();
  ASSERT_GE(H5Ldelete(id, name, H5P_DEFAULT), 0);
  ASSERT_GE(H5LTmake_dataset_int(id, name, 1, &size, values.data()), 0);
  H5Fclose(id);
}
/// Puts a data set in its place that says that it is so large, and has no numbers.
void declare(const fs::path& file, const char* name, hsize_t size) {
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), space = H5Screate_simple(1, &size, nullptr);
  ASSERT_GE(H5Ldelete(id, name, H5P_DEFAULT), 0);
  H5Dclose(H5Dcreate2(id, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Sclose(space);
  H5Fclose(id);
}

void expect_refused(const fs::path& file, const std::string& message) {
  awkward_problems::expect_refused(file, read(file), message);
}

TEST(FclibFile, RefusesBrokenFiles) {
  const fs::path file = scratch() / "broken.hdf5";
  std::mt19937_64 random(5);
  const Local local = random_local(random);
  const std::string good = read(write_local(local, kColumns));
  awkward_problems::expect_refused(file, "", "is no HDF5 file");
  awkward_problems::expect_refused(file, "fcp 1\n", "is no HDF5 file");
  for (const double part : {0.001, 0.1, 0.5, 0.9}) {
    const auto size = static_cast<std::size_t>(part * static_cast<double>(good.size()));
    awkward_problems::expect_refused(file, good.substr(0, size), "is no HDF5 file, or a damaged one");
  }
  const auto broken = [&](const auto& change, const std::string& message) {
    write_file(file, good);
    change();
    expect_refused(file, message);
  };
  const auto with = [&](const char* name, const auto& values, const std::string& message) {
    broken([&] { replace(file, name, values); }, message);
  };
  using Integers = std::vector<int>;
  using Doubles = std::vector<double>;
  const double nan = std::nan("");
  with("/fclib_local/spacedim", Integers{2}, "/fclib_local/spacedim: is 2, and only contacts in space");
  with("/fclib_local/spacedim", Integers{4}, "4 lies outside of 2 .. 3");
  with("/fclib_local/vectors/mu", Doubles{-0.1, 0.5}, "mu: must lie within 0 .. 1e6");
  with("/fclib_local/vectors/mu", Doubles{0.1, nan}, "/fclib_local/vectors/mu: value 2 of 2 is not finite");
  with("/fclib_local/vectors/mu", Doubles{0.1, 0.1, 0.1}, "/fclib_local/vectors/q: must hold 9 numbers, and holds 6");
  with("/fclib_local/vectors/q", Doubles{0, 0, 0, nan, 0, 0}, "/fclib_local/vectors/q: value 4 of 6 is not finite");
  with("/fclib_local/vectors/q", Doubles{0, 0, 0}, "/fclib_local/vectors/q: must hold 6 numbers, and holds 3");
  with("/fclib_local/W/m", Integers{3}, "/fclib_local/W/m: 3 lies outside of 6 .. 6");
  with("/fclib_local/W/n", Integers{2'000'000'000}, "/fclib_local/W/n: 2000000000 lies outside");
  with("/fclib_local/W/nzmax", Integers{2'000'000'000}, "/fclib_local/W/nzmax: 2000000000 lies outside of 0 .. 288");
  with("/fclib_local/W/nz", Integers{-3}, "/fclib_local/W/nz: -3 lies outside");
  with("/fclib_local/W/nz", Doubles{-1}, "/fclib_local/W/nz: holds no numbers of its kind");
  with("/fclib_local/W/p", Integers{0, 6, 12, 18, 24, 30}, "/fclib_local/W/p: must hold 7 numbers, and holds 6");
  with("/fclib_local/W/p", Integers{0, 6, 12, 18, 24, 30, 37}, "/fclib_local/W/p: 37 lies outside of 0 .. 36");
  with("/fclib_local/W/p", Integers{0, 36, 0, 36, 0, 36, 0}, "/fclib_local/W/p: must not fall");
  with("/fclib_local/W/i", Integers(36, 6), "/fclib_local/W/i: 6 lies outside of 0 .. 5");
  with("/fclib_local/W/i", Integers(35, 1), "/fclib_local/W/i: must hold 36 numbers, and holds 35");
  with("/fclib_local/W/x", Doubles(36, -1.0), "W: entry 1 of its diagonal is negative");
  with("/fclib_local/W/x", Doubles(36, nan), "/fclib_local/W/x: value 1 of 36 is not finite");
  broken([&] { declare(file, "/fclib_local/vectors/mu", 1'000'000'000'000); },
         "/fclib_local/vectors/mu: must hold 1 .. 2000 numbers, and holds 1000000000000");
  broken([&] { declare(file, "/fclib_local/W/x", 1'000'000'000'000); },
         "/fclib_local/W/x: must hold 36 .. 288 numbers");

  // What is whole, and yet not for us.
  FclibMatrix W(local.W, kColumns), V(random_matrix(6, 2, random), kColumns), R(random_symmetric(2, random), kColumns);
  VectorXd q = local.q, mu = local.mu, s = VectorXd::Zero(2);
  fclib_local mixed{W.get(), V.get(), R.get(), mu.data(), q.data(), s.data(), 3, nullptr};
  fs::remove(file);
  ASSERT_EQ(fclib_write_local(&mixed, file.c_str()), 1);
  expect_refused(file, "/fclib_local/V: equations besides those of the contacts");
  Global singular = random_global(0, random);
  singular.M.row(3).setZero();
  singular.M.col(3).setZero();
  expect_refused(write_global(singular, kTriplets), "/fclib_global/M: is singular");
}

// Whatever the bytes: a problem, or one line that says what is wrong.
TEST(FclibFile, BrokenBytesAreReadOrRefused) {
  std::mt19937_64 random(6);
  const std::string good = read(write_local(random_local(random), kRows));
  const fs::path file = "broken.hdf5";
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    std::string bytes = good;
    for (std::uint64_t changes = 1 + random() % 5; changes > 0; --changes) {
      bytes[random() % bytes.size()] = static_cast<char>(random() % 4 == 0 ? 0xff : random());
    }
    if (i % 10 == 0) bytes.resize(random() % bytes.size());
    try {
      (void)read_fclib_problem(file, bytes);
    } catch (const FileError& error) {
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with("broken.hdf5: ")) << what;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      ++refused;
    }
  }
  EXPECT_GE(refused, 20) << "those that were cut off, at least";
}

}  // namespace
}  // namespace thenar::fclib_file_test
#endif
