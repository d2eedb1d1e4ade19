// SPDX-License-Identifier: Apache-2.0
// Problem files: what is written is read back to the last bit, and what is broken is refused in words that say where.

#include "engine/formats/problem_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "engine/formats/files.h"
#include "tests/formats/awkward_problems.h"
#include "tests/support/json_eigen.h"
#include "tests/support/recorded_problems.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::problem_file_test {
namespace {

using namespace awkward_problems;

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
    EXPECT_TRUE(same_bits(g.contacts[i].axes, grasp.contacts[i].axes));
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

  MuscleFile limited = muscles;
  limited.limit = awkward(23, 1, random).cwiseAbs();
  limited.limit[3] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(same_bits(written_and_read(limited, "limited.json").limit, limited.limit));

  StiffMuscleFile stiff{awkward_stiffness(random), "s", "optimal", awkward(5, 1, random)};
  for (int which = 0; which < 2; ++which) {
    const StiffMuscleFile s = written_and_read(stiff, "stiff.json");
    EXPECT_EQ(s.status, stiff.status);
    EXPECT_EQ(s.joints, stiff.joints);
    EXPECT_EQ(s.kappa, stiff.kappa);
    EXPECT_EQ(s.length_m, stiff.length_m);
    const std::pair<MatrixXd, MatrixXd> matrices[] = {{s.H, stiff.H},
                                                      {s.tau, stiff.tau},
                                                      {s.limit, stiff.limit},
                                                      {s.arm, stiff.arm},
                                                      {s.turn, stiff.turn},
                                                      {s.fibre_per_m, stiff.fibre_per_m},
                                                      {s.tendon_N_per_m, stiff.tendon_N_per_m},
                                                      {s.A, stiff.A},
                                                      {s.B, stiff.B},
                                                      {s.D, stiff.D},
                                                      {s.K_des, stiff.K_des},
                                                      {s.f_optimal, stiff.f_optimal}};
    for (const auto& [got, wanted] : matrices) EXPECT_TRUE(same_bits(got, wanted));
    ASSERT_EQ(s.squeeze.has_value(), stiff.squeeze.has_value());
    if (s.squeeze) {
      EXPECT_TRUE(same_bits(s.squeeze->B, stiff.squeeze->B));
      EXPECT_EQ(s.squeeze->weight, stiff.squeeze->weight);
    }
    // And with a squeeze.
    stiff.squeeze = StiffSqueeze{awkward(4, 1, random),
                                 Matrix6d::Identity() / 3.0,
                                 awkward(6, 4, random),
                                 awkward(4, 4, random),
                                 -0.1,
                                 1.0 / 3.0,
                                 0.7};
  }

  const LcpFile lcp{{awkward(5, 5, random), awkward(5, 1, random)}, "l", "", {}};
  const LcpFile l = written_and_read(lcp, "lcp.json");
  EXPECT_TRUE(same_bits(l.M, lcp.M));
  EXPECT_TRUE(same_bits(l.q, lcp.q));
}

// What is the same for all contacts is written as a number, else as a list.
TEST(ProblemFile, ContactsOfTheirOwnFrictionAreReadBackToTheLastBit) {
  std::mt19937_64 random(4);
  GraspFile grasp;
  for (int i = 0; i < 3; ++i) grasp.contacts.push_back({awkward(3, 1, random) * 1e-300, random_rotation(random)});
  const auto expect_same = [&](bool mu_is_list, bool lambda_is_list) {
    const fs::path file = scratch() / "grasp.json";
    write_problem(file, grasp);
    const GraspFile g = std::get<GraspFile>(read_problem(file));
    const GraspProblem expected = grasp.problem(FrictionCone::kExact), read = g.problem(FrictionCone::kExact);
    for (Index i = 0; i < 3; ++i) {
      EXPECT_EQ(read.friction_of(i), expected.friction_of(i));
      EXPECT_EQ(read.internal_force_of(i), expected.internal_force_of(i));
    }
    const nlohmann::json written = read_json(file);
    EXPECT_EQ(written.at("mu").is_array(), mu_is_list);
    EXPECT_EQ(written.at("lambda").is_array(), lambda_is_list);
    return g;
  };
  grasp.grips = {{1.0 / 3.0, 1e-17}, {0.0, -0.1}, {5e-324, 1e300}};
  expect_same(true, true);
  grasp.grips = {{0.1, 2.0}, {0.1, 3.0}, {0.1, 2.0}};
  expect_same(false, true);
  grasp.grips = {{0.1, 2.0}, {0.2, 2.0}, {0.3, 2.0}};
  expect_same(true, false);
  grasp.grips = {{0.1, 2.0}, {0.1, 2.0}, {0.1, 2.0}};
  const GraspFile uniform = expect_same(false, false);
  EXPECT_TRUE(uniform.grips.empty());
  EXPECT_EQ(uniform.friction, 0.1);
  EXPECT_EQ(uniform.internal_force_N, 2.0);
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

TEST(ProblemFile, RefusesBrokenSmallFiles) {
  const fs::path file = scratch() / "broken.json";
  const auto data = [](const char* name) { return read(fs::path(THENAR_TEST_DATA) / "small" / name); };
  const std::string text = data("12_two_contacts_rank5.json");
  expect_refused(file, text.substr(0, text.size() / 2), ": is no JSON: ");
  expect_refused(file, text + "x", ": is no JSON: ");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": NaN, \"x\": 0.9"), "line 3, column ");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": 1e999, \"x\": 0.9"), "number overflow");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": -0.9"), "key 'mu': must lie within 0 .. 1e6");
  expect_refused(file, replaced(text, "\"mu\": 0.9", "\"mu\": 0.8"), "key 'A': contradicts");
  const auto with_mu = [&](const std::string& mu) { return replaced(text, "\"mu\"", "\"mu\": " + mu + ", \"x\""); };
  const auto with_lambda = [&](const std::string& lambda) {
    return replaced(text, "\"lambda\"", "\"lambda\": " + lambda + ", \"x\"");
  };
  const std::string each = "must be a number, or a list of 2 numbers, one a contact";
  for (const char* mu : {"[0.9]", "[]", "[0.9, 0.9, 0.9]", "[0.9, null]", "[[0.9, 0.9]]", "\"0.9\"", "{}"}) {
    expect_refused(file, with_mu(mu), "key 'mu': " + each);
    expect_refused(file, with_lambda(mu), "key 'lambda': " + each);
  }
  expect_refused(file, with_mu("[0.9, -0.9]"), "key 'mu': must lie within 0 .. 1e6");
  expect_refused(file, with_mu("[2e6, 0.9]"), "key 'mu': must lie within 0 .. 1e6");
  expect_refused(file, with_mu("[0.9, 0.8]"), "key 'A': contradicts");
  expect_refused(file, with_lambda("[2, 3]"), "key 'c': contradicts");
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
  expect_refused(file, replaced(text, "\"P1\"", "\"P9\""), "key 'problem': 'P9' is none of P1, P2, P3, LCP");
  expect_refused(file, replaced(text, "\"P1\"", "\"P2\""), "key 'H': is missing");
  expect_refused(file, "[1, 2]", "must be a JSON object");
  expect_refused(file, "{}", "key 'problem': is missing");
  expect_refused(file, "", "line 1, column 1: is no JSON");
  expect_refused(file, R"({"problem": "LCP", "M": [[1, 0]], "q": [1]})", "key 'M': must have as many rows as columns");
  expect_refused(file, R"({"problem": "LCP", "M": [[1, 0], [1]], "q": [1, 1]})", "key 'M[1]': must be a list of 2");
  expect_refused(file, R"({"problem": "LCP", "M": [], "q": []})", "key 'M': must be a list of rows of numbers");
  expect_refused(file, R"({"problem": "LCP", "M": [[]], "q": []})", "key 'M': must not be empty");
  expect_refused(file, R"({"problem": "LCP", "M": [1, 2], "q": [1, 1]})", "key 'M': must be a list of rows of numbers");
  expect_refused(file, R"({"problem": "LCP", "M": [{}], "q": [1]})", "key 'M': must be a list of rows of numbers");
  expect_refused(file, R"({"problem": "LCP", "M": [[1], 2], "q": [1, 1]})", "key 'M[1]': must be a list of 1 numbers");
  expect_refused(file, R"({"problem": "P2", "H": [[1]], "tau": [1], "c": [2]})", "key 'c': must be zero");
  expect_refused(file, R"({"problem": "P2", "H": [[1]], "tau": [1, 2]})", "key 'tau': must be a list of 1 numbers");
  expect_refused(file.parent_path() / "problem.yaml", "{}", "must be an .fcp, .hdf5 or .h5 file");
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
