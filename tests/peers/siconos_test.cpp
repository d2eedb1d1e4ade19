// SPDX-License-Identifier: Apache-2.0
// Siconos solves the contact problems that we write, which FCLIB's own library reads, and finds the forces that we do;
// and we read what it writes.

#include <gtest/gtest.h>
#include <siconos/numerics/FrictionContactProblem.h>
#include <siconos/numerics/Friction_cst.h>
#include <siconos/numerics/NonSmoothDrivers.h>
#include <siconos/numerics/NumericsMatrix.h>
#include <siconos/numerics/SolverOptions.h>
#include <suitesparse/cs.h>  // what Siconos's sparse matrices are

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

// After Siconos, which declares the types of FCLIB as it likes.
extern "C" {
#include <fclib.h>
}

#include "engine/formats/fclib_file.h"
#include "engine/formats/problem_file.h"
#include "solvers/contact_newton.h"
#include "solvers/residual.h"
#include "tests/support/program.h"

namespace thenar::siconos_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ContactFile read_contact(const fs::path& file) { return std::get<ContactFile>(read_problem(file)); }

/// A Siconos problem that owns its numbers.
struct SiconosProblem {
  MatrixXd W;
  VectorXd q, mu;
  std::shared_ptr<NumericsMatrix> matrix;
  FrictionContactProblem problem;

  SiconosProblem(MatrixXd W_in, VectorXd q_in, VectorXd mu_in)
      : W(std::move(W_in)), q(std::move(q_in)), mu(std::move(mu_in)) {
    NumericsMatrix* const made =
        NM_create_from_data(NM_DENSE, static_cast<int>(W.rows()), static_cast<int>(W.cols()), W.data());
    matrix = {made, [](NumericsMatrix* m) {
                m->matrix0 = nullptr;  // Not its own.
                NM_clear(m);
                std::free(m);
              }};
    problem = {3, static_cast<int>(mu.size()), made, q.data(), mu.data()};
  }
  SiconosProblem(const SiconosProblem&) = delete;
  SiconosProblem& operator=(const SiconosProblem&) = delete;
};

/// What FCLIB's own library reads in a file, in units in which W is of order 1: Siconos measures its error in those of
/// q.
std::unique_ptr<SiconosProblem> read_by_fclib(const fs::path& file) {
  fclib_local* const local = fclib_read_local(file.c_str());
  if (local == nullptr) return nullptr;
  const fclib_matrix& in_columns = *local->W;
  EXPECT_EQ(in_columns.nz, -1);
  MatrixXd W = MatrixXd::Zero(in_columns.m, in_columns.n);
  for (int col = 0; col < in_columns.n; ++col) {
    for (int k = in_columns.p[col]; k < in_columns.p[col + 1]; ++k) W(in_columns.i[k], col) = in_columns.x[k];
  }
  const double unit = W.diagonal().mean();
  auto problem =
      std::make_unique<SiconosProblem>(MatrixXd(W / unit), VectorXd(VectorXd::Map(local->q, W.rows()) / unit),
                                       VectorXd(VectorXd::Map(local->mu, W.rows() / 3)));
  fclib_delete_local(local);
  return problem;
}

/// Siconos's forces: by its Newton, and where that stops early, by its Gauss-Seidel from there on.
VectorXd solve(SiconosProblem& problem) {
  VectorXd r = VectorXd::Zero(problem.q.size()), u = r;
  for (const auto& [solver, budget] : {std::pair{SICONOS_FRICTION_3D_NSN_AC, 500}, {SICONOS_FRICTION_3D_NSGS, 20000}}) {
    const std::shared_ptr<SolverOptions> options(solver_options_create(solver), solver_options_delete);
    options->iparam[SICONOS_IPARAM_MAX_ITER] = budget;
    options->dparam[SICONOS_DPARAM_TOL] = 1e-14;
    if (fc3d_driver(&problem.problem, r.data(), u.data(), options.get()) == 0) break;
  }
  return r;
}

/// What is committed with a solution that is unique: pulps with compliance, friction below 1.
std::vector<fs::path> committed_problems() {
  std::vector<fs::path> files;
  for (const char* name : {"paper15_s1", "paper30_s1", "paper60_s1", "paper60_curved_s1", "pressed15_s1",
                           "pressed30_s1", "pressed60_s1", "pressed15_seq_s1", "pressed60_seq_s1"}) {
    files.push_back(data("contact/" + std::string(name) + ".fcp"));
  }
  return files;
}

/// Frames of the box grasp with so many contacts, in a folder of their own.
std::vector<fs::path> frames(int contacts, const fs::path& folder) {
  const std::string most = std::to_string(contacts / 3), leaves = std::to_string(12 * (contacts / 3));
  const ProgramResult run = thenar_program(
      "run " + config("box_grasp.yaml") + " --time 0.3 --quiet --set contact.max_per_finger=" + most +
      " --set fingertips.leaves=" + leaves + " --dump-problems " + folder.string() + " --dump-every 100");
  EXPECT_EQ(run.code, 0) << run.text;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".fcp") files.push_back(entry);
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(Siconos, FindsTheForcesThatWeFind) {
  const fs::path folder = scratch(), written = folder / "problem.hdf5";
  std::vector<fs::path> files = committed_problems();
  for (const int contacts : {15, 30, 60}) {
    const std::vector<fs::path> more = frames(contacts, folder / std::to_string(contacts));
    EXPECT_GE(more.size(), 3U);
    files.insert(files.end(), more.begin(), more.end());
  }
  double worst = 0.0, worst_ours = 0.0, worst_theirs = 0.0;
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    write_fclib_problem(written, read_contact(file));
    const ContactFile ours = read_contact(written);
    const std::unique_ptr<SiconosProblem> theirs = read_by_fclib(written);
    ASSERT_NE(theirs, nullptr);

    const ContactProblem problem = ours.problem();
    AccurateWorkspace work(ours.contacts());
    VectorXd f = VectorXd::Zero(3 * ours.contacts()), delta = f;
    const AccurateReport report = solve_contacts_accurately(problem, {.tolerance = 1e-13}, work, {f, delta});
    const VectorXd r = solve(*theirs);
    const double of_theirs = natural_map(problem, r, VectorXd(ours.W * r + ours.delta_free[0])).norm;
    // Both stop below 1e-13 of the free motion, and forces may be as much further apart as W's condition: 1e5 are left.
    const double difference = (f - r).cwiseAbs().maxCoeff() / f.cwiseAbs().maxCoeff();
    EXPECT_LE(difference, 1e-8) << "ours " << report.solve.residual << ", theirs " << of_theirs;
    std::printf("%-28s %3ld contacts: difference %.1e, residuals %.1e (ours), %.1e (Siconos)\n",
                file.stem().string().c_str(), static_cast<long>(ours.contacts()), difference, report.solve.residual,
                of_theirs);
    worst = std::max(worst, difference);
    worst_ours = std::max(worst_ours, report.solve.residual);
    worst_theirs = std::max(worst_theirs, of_theirs);
  }
  std::printf("%zu problems: largest difference %.1e, largest residuals %.1e (ours), %.1e (Siconos)\n", files.size(),
              worst, worst_ours, worst_theirs);
}

// Debian builds Siconos without its writer, frictionContact_fclib_write. It makes triplets of its matrix and gives them
// to FCLIB's library, as is done here.
TEST(Siconos, WritesWhatWeRead) {
  for (const fs::path& file : committed_problems()) {
    SCOPED_TRACE(file);
    const ContactFile problem = read_contact(file);
    SiconosProblem theirs(problem.W, problem.delta_free[0], problem.mu);
    const CSparseMatrix* const triplets = NM_triplet(theirs.matrix.get());
    std::vector<int> p(triplets->p, triplets->p + triplets->nz), i(triplets->i, triplets->i + triplets->nz);
    const int entries = static_cast<int>(triplets->nz);
    fclib_matrix W{
        entries, static_cast<int>(triplets->m), static_cast<int>(triplets->n), p.data(), i.data(), triplets->x, entries,
        nullptr};
    fclib_local local{&W, nullptr, nullptr, theirs.mu.data(), theirs.q.data(), nullptr, 3, nullptr};
    const fs::path written = scratch() / "siconos.hdf5";
    ASSERT_EQ(fclib_write_local(&local, written.c_str()), 1);
    ASSERT_EQ(fclib_create_int_attributes_in_info(written.c_str(), "numberOfDegreeOfFreedom", 6), 1);
    const ContactFile read = read_contact(written);
    EXPECT_EQ(read.W, problem.W);
    EXPECT_EQ(read.delta_free[0], problem.delta_free[0]);
    EXPECT_EQ(read.mu, problem.mu);
  }
}

}  // namespace
}  // namespace thenar::siconos_test
