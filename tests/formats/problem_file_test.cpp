// Problem files: what is written is read back to the last bit, and what is broken is refused in words that say where.

#include "engine/formats/problem_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>
#include <limits>
#include <random>

#include "engine/formats/files.h"
#include "tests/support/json_eigen.h"
#include "tests/support/recorded_problems.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::problem_file_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
namespace fs = std::filesystem;

/// Numbers of all magnitudes and signs; the first four are those that printing loses most easily.
MatrixXd awkward(Index rows, Index cols, std::mt19937_64& random) {
  MatrixXd values(rows, cols);
  for (Index i = 0; i < values.size(); ++i) {
    values(i) = std::ldexp(uniform(random, -1.0, 1.0), static_cast<int>(uniform(random, -60.0, 60.0)));
  }
  const double special[] = {-0.0, 5e-324, std::numeric_limits<double>::max(), 0.1};
  for (Index i = 0; i < std::min<Index>(4, values.size()); ++i) values(i) = special[i];
  return values;
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

ContactFile contact_problem(std::mt19937_64& random) {
  ContactFile problem;
  problem.name = "two contacts";
  problem.status = "solved";
  problem.units = "SI";
  problem.source = "a test";
  problem.W = awkward(6, 6, random);
  problem.W.diagonal() = problem.W.diagonal().cwiseAbs().eval();
  problem.delta_free = {awkward(6, 1, random), awkward(6, 1, random), awkward(6, 1, random)};
  problem.mu = (VectorXd(2) << 0.0, 0.3).finished();
  problem.f_reference = awkward(6, 1, random);
  problem.delta_reference = awkward(6, 1, random);
  problem.reference_residual = 1.0 / 3.0;
  problem.f_last = awkward(6, 1, random);
  return problem;
}

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

TEST(ProblemFile, SmallProblemsAreReadBackToTheLastBit) {
  std::mt19937_64 random(3);
  GraspFile grasp;
  grasp.name = "a \"grasp\"\n";
  grasp.status = "optimal";
  grasp.status_exact_cone = "infeasible";
  for (int i = 0; i < 3; ++i) grasp.contacts.push_back({awkward(3, 1, random) * 1e-300, random_rotation(random)});
  grasp.wrench = awkward(6, 1, random);
  grasp.friction = 1.0 / 3.0;
  grasp.internal_force_N = 1e-17;
  grasp.f_optimal = awkward(9, 1, random) * 1e-300;
  grasp.f_optimal_exact_cone = awkward(9, 1, random);
  const GraspFile g = written_and_read(grasp, "grasp.json");
  EXPECT_EQ(g.name, grasp.name);
  EXPECT_EQ(g.status, grasp.status);
  EXPECT_EQ(g.status_exact_cone, grasp.status_exact_cone);
  ASSERT_EQ(g.contacts.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(same_bits(g.contacts[i].point_m, grasp.contacts[i].point_m));
    EXPECT_TRUE(same_bits(g.contacts[i].frame, grasp.contacts[i].frame));
  }
  EXPECT_TRUE(same_bits(g.wrench, grasp.wrench));
  EXPECT_EQ(g.friction, grasp.friction);
  EXPECT_EQ(g.internal_force_N, grasp.internal_force_N);
  EXPECT_TRUE(same_bits(g.f_optimal, grasp.f_optimal));
  EXPECT_TRUE(same_bits(g.f_optimal_exact_cone, grasp.f_optimal_exact_cone));

  const MuscleFile muscles{{awkward(12, 23, random), awkward(12, 1, random)}, "m", "infeasible", {}};
  const MuscleFile m = written_and_read(muscles, "muscle.json");
  EXPECT_EQ(m.status, muscles.status);
  EXPECT_TRUE(same_bits(m.H, muscles.H));
  EXPECT_TRUE(same_bits(m.tau, muscles.tau));

  const LcpFile lcp{{awkward(5, 5, random), awkward(5, 1, random)}, "l", "", {}};
  const LcpFile l = written_and_read(lcp, "lcp.json");
  EXPECT_TRUE(same_bits(l.M, lcp.M));
  EXPECT_TRUE(same_bits(l.q, lcp.q));
}

// Reference files, written anew, say the same as before: also what we compute and they state.
TEST(ProblemFile, WritesWhatTheReferenceFilesSay) {
  for (const fs::path& file : data_files("small")) {
    SCOPED_TRACE(file);
    const nlohmann::json expected = read_json(file);
    const fs::path copy = scratch() / "copy.json";
    std::visit([&](const auto& problem) { write_problem(copy, problem); }, read_problem(file));
    const nlohmann::json written = read_json(copy);
    for (const char* key : {"name",
                            "problem",
                            "status",
                            "n_contacts",
                            "mu",
                            "lambda",
                            "contact_points",
                            "normals_inward",
                            "tangent_u",
                            "tangent_v",
                            "W",
                            "tau",
                            "H",
                            "M",
                            "q",
                            "z",
                            "f_opt",
                            "f_opt_exact_cone",
                            "exact_cone_status",
                            "active_rows"}) {
      EXPECT_EQ(written.value(key, nlohmann::json()), expected.value(key, nlohmann::json())) << key;
    }
    for (const char* key : {"G", "A"}) {  // Products of two numbers below 2: one rounding.
      if (!expected.contains(key)) continue;
      EXPECT_LE((matrix_of(written.at(key)) - matrix_of(expected.at(key))).cwiseAbs().maxCoeff(), 5e-16) << key;
    }
    if (expected.contains("objective")) {  // A sum of some twenty terms.
      const double objective = expected.at("objective");
      EXPECT_NEAR(written.at("objective"), objective, 1e-13 * vector_of(expected.at("f_opt")).squaredNorm());
    }
  }
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

void expect_refused(const fs::path& file, const std::string& bytes, const std::string& message) {
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

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
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

TEST(ProblemFile, RefusesBrokenSmallFiles) {
  const fs::path file = scratch() / "broken.json";
  const auto data = [](const char* name) { return read(fs::path(THENAR_TEST_DATA) / "small" / name); };
  const std::string text = data("12_two_contacts_rank5.json");
  expect_refused(file, text.substr(0, text.size() / 2), "parse error at line");
  expect_refused(file, text + "x", "parse error at line");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": NaN, \"x\": 0.9"), "parse error at line 3");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": 1e999, \"x\": 0.9"), "number overflow");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": -0.9"), "key 'mu': must lie within 0 .. 1e6");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": 0.8"), "key 'A': contradicts");
  expect_refused(file, replaced(text, "\"lambda\": 2", "\"lambda\": 3"), "key 'c': contradicts");
  expect_refused(file, replaced(text, "\"mu\"", "\"lambda\""), "key 'lambda': is there twice");
  expect_refused(file, replaced(text, "\"mu\"", "\"friction\""), "key 'mu': is missing");
  expect_refused(file, replaced(text, "\"n_contacts\": 2", "\"n_contacts\": 3"), "key 'n_contacts': differs");
  expect_refused(file, replaced(text, "\"W\": [", "\"W\": [0, "), "key 'W': must be a list of 6 numbers");
  expect_refused(file, replaced(text, "\"G\": [[1,", "\"G\": [["), "key 'G[0]': must be a list of 6 numbers");
  expect_refused(file, replaced(text, "\"G\": [[1,", "\"G\": [[2,"), "key 'G': contradicts");
  expect_refused(file, replaced(text, "\"tangent_v\": [[0.69", "\"tangent_v\": [[0.59"),
                 "contact 0: normal, tangent_u");
  expect_refused(file, replaced(text, "\"tangent_v\": [[0.69", "\"tangent_v\": [[\"0\", 0.69"), "key 'tangent_v[0]'");
  expect_refused(file, replaced(text, "\"f_opt\": [", "\"f_opt\": [1, "), "key 'f_opt': must be a list of 6 numbers");
  expect_refused(file, replaced(text, "\"optimal\"", "\"good\""), "key 'status' must be optimal or infeasible");
  expect_refused(file, replaced(text, "\"P1\"", "\"P9\""), "key 'problem': 'P9' is none of P1, P2, LCP");
  expect_refused(file, replaced(text, "\"P1\"", "\"P2\""), "key 'H': is missing");
  expect_refused(file, "[1, 2]", "must be a JSON object");
  expect_refused(file, "{}", "key 'problem': is missing");
  expect_refused(file, "", "parse error at line 1");
  expect_refused(file, R"({"problem": "LCP", "M": [[1, 0]], "q": [1]})", "key 'M': must have as many rows as columns");
  expect_refused(file, R"({"problem": "LCP", "M": [[1, 0], [1]], "q": [1, 1]})", "key 'M[1]': must be a list of 2");
  expect_refused(file, R"({"problem": "LCP", "M": [], "q": []})", "key 'M': must be a list of rows of numbers");
  expect_refused(file, R"({"problem": "LCP", "M": [[]], "q": []})", "key 'M': must not be empty");
  expect_refused(file, R"({"problem": "LCP", "M": [1, 2], "q": [1, 1]})", "key 'M': must be a list of rows of numbers");
  expect_refused(file, R"({"problem": "LCP", "M": [{}], "q": [1]})", "key 'M': must be a list of rows of numbers");
  expect_refused(file, R"({"problem": "LCP", "M": [[1], 2], "q": [1, 1]})", "key 'M[1]': must be a list of 1 numbers");
  expect_refused(file, R"({"problem": "P2", "H": [[1]], "tau": [1], "c": [2]})", "key 'c': must be zero");
  expect_refused(file, R"({"problem": "P2", "H": [[1]], "tau": [1, 2]})", "key 'tau': must be a list of 1 numbers");
  expect_refused(file.parent_path() / "problem.yaml", "{}", "must be an .fcp file");
}

// A small file must not ask for much: a long row times many short ones is a matrix of gigabytes, and so is what solvers
// make of each pair of many muscles. Read within 1 GB of addresses beyond what the process has.
TEST(ProblemFile, ASmallFileAsksForLittleMemory) {
  const fs::path file = scratch() / "large.json";
  std::string row = "[1", rows = "[1]", zeros = "0";
  for (int i = 1; i < 40000; ++i) {
    row += ",1";
    if (i < 10000) rows += ",[1]";
    if (i < 10000) zeros += ",0";
  }
  row += "]";
  rlimit before{};
  getrlimit(RLIMIT_AS, &before);
  std::int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
#ifndef __SANITIZE_ADDRESS__
  const rlimit little{static_cast<rlim_t>(pages * sysconf(_SC_PAGESIZE) + 1'000'000'000), before.rlim_max};
  setrlimit(RLIMIT_AS, &little);
#endif
  expect_refused(file, R"({"problem": "LCP", "M": [)" + row + "," + rows + R"(], "q": [1]})",
                 "key 'M[1]': must be a list of");
  expect_refused(file, R"({"problem": "P2", "H": [)" + row + R"(], "tau": [1]})",
                 "key 'H': at most 1000 joints and as many muscles");
  expect_refused(file, R"({"problem": "P2", "H": [)" + rows + R"(], "tau": [)" + zeros + "]}",
                 "key 'H': at most 1000 joints and as many muscles");
  setrlimit(RLIMIT_AS, &before);
}

TEST(ProblemFile, WindowsLineEndsDoNotHurtText) {
  const fs::path file = scratch() / "file_name.json";
  write_file(file, "{\r\n\"problem\": \"LCP\",\r\n\"M\": [[2]],\r\n\"q\": [-1]}\r\n");
  const auto lcp = std::get<LcpFile>(read_problem(file));
  EXPECT_EQ(lcp.M(0, 0), 2.0);
  EXPECT_EQ(lcp.name, "file_name");
}

}  // namespace
}  // namespace thenar::problem_file_test
