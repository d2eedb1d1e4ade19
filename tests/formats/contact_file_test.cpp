// SPDX-License-Identifier: Apache-2.0
// Recorded contact problems: what is written is read back to the last bit, and what is broken is refused in words that
// say where.

#include "engine/formats/contact_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "engine/formats/problem_file.h"
#include "tests/formats/awkward_problems.h"
#include "tests/support/recorded_problems.h"
#include "tests/support/scratch.h"

namespace thenar::contact_file_test {
namespace {

using namespace awkward_problems;

using Eigen::VectorXd;

TEST(ProblemFile, AContactProblemIsReadBackToTheLastBit) {
  std::mt19937_64 random(1);
  const ContactFile problem = contact_problem(random);
  const ContactFile read = written_and_read(problem, "problem.fcp");
  EXPECT_EQ(read.name, problem.name);
  EXPECT_EQ(read.status, problem.status);
  EXPECT_EQ(read.units, problem.units);
  EXPECT_EQ(read.source, problem.source);
  EXPECT_TRUE(same_bits(read.W, problem.W));
  ASSERT_EQ(read.delta_free.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(same_bits(read.delta_free[i], problem.delta_free[i]));
  EXPECT_TRUE(same_bits(read.mu, problem.mu));
  EXPECT_TRUE(same_bits(read.f_reference, problem.f_reference));
  EXPECT_TRUE(same_bits(read.delta_reference, problem.delta_reference));
  EXPECT_EQ(read.reference_residual, problem.reference_residual);
  EXPECT_TRUE(same_bits(read.f_last, problem.f_last));
}

// The format as others read it: W by rows, then q, mu, r_ref, u_ref; our own first guess comes after all that.
TEST(ProblemFile, AReaderOfThePublishedFormatFindsSpareBytesAtTheEnd) {
  std::mt19937_64 random(2);
  const ContactFile problem = contact_problem(random);
  const fs::path file = scratch() / "problem.fcp";
  write_problem(file, problem);
  const std::string bytes = read(file);
  const std::string end = "\nend_header\n";
  const std::string header = bytes.substr(0, bytes.find(end) + 1);
  EXPECT_TRUE(header.starts_with("fcp 1\ncontacts 2\nsteps 3\nhas_ref 1\n")) << header;
  std::vector<double> expected;
  for (Index i = 0; i < 6; ++i) expected.insert(expected.end(), problem.W.row(i).begin(), problem.W.row(i).end());
  for (const VectorXd& q : problem.delta_free) expected.insert(expected.end(), q.begin(), q.end());
  for (const VectorXd& v : {problem.mu, problem.f_reference, problem.delta_reference}) {
    expected.insert(expected.end(), v.begin(), v.end());
  }
  const std::size_t data = bytes.find(end) + end.size();
  ASSERT_EQ(bytes.size(), data + 8 * (expected.size() + 6));
  EXPECT_EQ(std::memcmp(bytes.data() + data, expected.data(), 8 * expected.size()), 0);
}

TEST(ProblemFile, ReadsTheRecordedContactProblems) {
  const auto problems = recorded_contact_problems();
  ASSERT_FALSE(problems.empty());
  for (const ContactFile& problem : problems) {
    SCOPED_TRACE(problem.name);
    // The file states the gaps of its forces: to the rounding of a sum of 3n terms.
    const VectorXd delta = problem.W * problem.f_reference + problem.delta_free.front();
    const double terms_m = (problem.W.cwiseAbs() * problem.f_reference.cwiseAbs()).maxCoeff();
    EXPECT_LE((delta - problem.delta_reference).cwiseAbs().maxCoeff(), 1e-14 * terms_m);
    EXPECT_FALSE(problem.units.empty());
  }
}

TEST(ProblemFile, RefusesBrokenContactFiles) {
  std::mt19937_64 random(4);
  const fs::path file = scratch() / "broken.fcp";
  ContactFile problem = contact_problem(random);
  write_problem(file, problem);
  const std::string good = read(file);
  ASSERT_NO_THROW((void)read_problem(file));
  const std::size_t data = good.find("end_header\n") + 11;
  const auto with_double = [&](std::size_t index, double value) {
    std::string bytes = good;
    std::memcpy(bytes.data() + data + 8 * index, &value, 8);
    return bytes;
  };
  const double nan = std::nan("");
  expect_refused(file, "", "line 1: must be 'fcp 1'");
  expect_refused(file, "ply\n", "line 1: must be 'fcp 1'");
  expect_refused(file, replaced(good, "fcp 1", "fcp 2"), "line 1: must be 'fcp 1'");
  expect_refused(file, good.substr(0, good.size() - 1), "and its header asks for " + std::to_string(good.size()));
  expect_refused(file, good + "\n", "has " + std::to_string(good.size() + 1) + " bytes");
  expect_refused(file, good.substr(0, 20), "'end_header' is missing");
  expect_refused(file, replaced(good, "end_header\n", "end_header\r\n"), "ends with CR LF");
  expect_refused(file, replaced(good, "fcp 1\n", "fcp 1\r\n"), "line 1: ends with CR LF");
  expect_refused(file, replaced(good, "contacts 2", "contacts 3"), "its header asks for");
  expect_refused(file, replaced(good, "contacts 2", "contacts 1000000"), "its header asks for 72");
  expect_refused(file, replaced(good, "contacts 2", "contacts 4000000000"),
                 "line 2: 'contacts' must be a whole number");
  expect_refused(file, replaced(good, "contacts 2", "contacts 99999999999999999999"), "line 2: 'contacts'");
  expect_refused(file, replaced(good, "contacts 2", "contacts -2"), "line 2: 'contacts'");
  expect_refused(file, replaced(good, "contacts 2", "contacts 0"), "line 2: 'contacts'");
  expect_refused(file, replaced(good, "contacts 2", "contacts 2.0"), "line 2: 'contacts'");
  expect_refused(file, replaced(good, "contacts 2", "points 2"), "the header has no 'contacts'");
  expect_refused(file, replaced(good, "steps 3", "steps 2"), "2 contacts, 2 steps");
  expect_refused(file, replaced(good, "has_ref 1", "has_ref yes"), "line 4: 'has_ref' must be");
  expect_refused(file, replaced(good, "status solved", "status optimal"), "'status' must be solved or no_solution");
  expect_refused(file, replaced(good, "units SI", "contacts 2"), "has 'contacts' again");
  expect_refused(file, replaced(good, "units SI", "units"), "must be 'key value'");
  expect_refused(file, with_double(7, nan), "W: value 8 of 36 is not finite");
  expect_refused(file, with_double(36 + 6, std::numeric_limits<double>::infinity()), "q: value 1 of 6 is not finite");
  expect_refused(file, with_double(36 + 18, -0.1), "mu: must lie within 0 .. 1e6");
  expect_refused(file, with_double(36 + 18, 1e300), "mu: must lie within 0 .. 1e6");
  expect_refused(file, with_double(35, -1.0), "W: entry 6 of its diagonal is negative");
  expect_refused(file, with_double(36 + 18 + 2 + 12, nan), "f_last: value 1 of 6 is not finite");
}

}  // namespace
}  // namespace thenar::contact_file_test
