// SPDX-License-Identifier: Apache-2.0
// `thenar solve` and `thenar run --dump-problems` as a user meets them: right verdicts, residuals of the problem as
// given, verdicts in words, and broken input refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/formats/fclib_file.h"
#include "engine/formats/number_table.h"
#include "engine/formats/problem_file.h"
#include "engine/problems/problem_check.h"
#include "tests/support/json_eigen.h"
#include "tests/support/program.h"
#include "tests/support/recorded_problems.h"

namespace thenar::solve_test {
namespace {

using Eigen::VectorXd;
namespace fs = std::filesystem;

/// The results of a command that prints JSON, and on stderr after it what is not right.
std::vector<nlohmann::json> results_of(const std::string& arguments, int code = 0) {
  const ProgramResult run = thenar_program("solve " + arguments + " --format json");
  EXPECT_EQ(run.code, code) << run.text;
  return nlohmann::json::parse(run.text.substr(0, run.text.find("\n}\n") + 3)).at("results");
}

// Every reference file by every method that applies: the known verdict, and for solutions a residual within the default
// tolerance, recomputed here from the forces that are printed with all their digits.
TEST(Solve, FindsTheKnownAnswersOfTheReferenceFiles) {
  const std::vector<fs::path> files = data_files("small");
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const auto expected = read_json(file);
    const auto results = results_of(file.string() + " --method all --repeat 2 --forces");
    EXPECT_EQ(results.size(), expected.at("problem") == "P1" ? 3U : expected.at("problem") == "P2" ? 2U : 1U);
    for (const auto& result : results) {
      SCOPED_TRACE(result.at("method"));
      EXPECT_EQ(result.at("name"), expected.at("name"));
      EXPECT_EQ(result.at("problem"), expected.at("problem"));
      EXPECT_GT(result.at("median_us"), 0.0);
      EXPECT_GE(result.at("p99_us"), result.at("median_us"));
      const bool exact_cone = result.at("method") == "exact_cone";
      const char* const optimum = exact_cone ? "f_opt_exact_cone" : "f_opt";
      if (!exact_cone || expected.contains(optimum)) {
        EXPECT_EQ(result.at("status"), expected.at("status"));
      }
      if (!expected.contains(optimum)) continue;
      const VectorXd f = vector_of(result.at("f")), f_known = vector_of(expected.at(optimum));
      // The cones' references are known to 1e-6; contacts that are nearly on a line lose six digits.
      EXPECT_LE((f - f_known).norm(), (exact_cone ? 1e-6 : 1e-9) * f_known.norm());
      if (exact_cone) continue;
      EXPECT_NEAR(result.at("objective"), expected.at("objective"), 1e-9 * f_known.squaredNorm());
    }
  }
}

TEST(Solve, SolvesContactProblemsToTheResidualThatItStates) {
  const fs::path file = data("contact/pressed15_seq_s1.fcp");
  const auto problem = std::get<ContactFile>(read_problem(file));
  const auto results = results_of(file.string() + " --method all --repeat 2 --forces");
  ASSERT_EQ(results.size(), 4U) << "two methods, from nothing and warm";
  EXPECT_EQ(results[0].at("method"), "newton");
  EXPECT_EQ(results[2].at("method"), "gauss_seidel");
  EXPECT_EQ(results[1].at("name"), problem.name + " (warm, 50 steps)");
  for (const auto& result : results) {
    EXPECT_EQ(result.at("status"), "solved");
    EXPECT_LE(result.at("residual"), 1e-8);
    EXPECT_LE(result.at("residual_worst"), result.at("residual"));
  }
  const Residual residual = contact_residual(problem.problem(), vector_of(results[0].at("f")));
  EXPECT_EQ(results[0].at("residual"), residual.norm) << "JSON keeps every digit";
  EXPECT_EQ(results[0].at("residual_worst"), residual.worst);
  // Each step begins near its end.
  EXPECT_LT(results[1].at("iterations"), results[0].at("iterations"));
}

// A median says of how many solves it is, and time bounds them: one solve remains, however long it takes.
TEST(Solve, ATimeBoundsTheSolvesOfAFile) {
  const std::string files = data("small/14_grasp4.json") + " " + data("contact/pressed15_seq_s1.fcp");
  for (const auto& result : results_of(files + " --method all --repeat 1000000 --time '1 us'")) {
    EXPECT_EQ(result.at("runs"), result.at("name").get<std::string>().ends_with("steps)") ? 49 : 1)
        << "what warms the machine up, once";
    EXPECT_GT(result.at("median_us"), 0.0);
  }
  const auto start = std::chrono::steady_clock::now();
  const auto results = results_of(files + " --method all --repeat 1000000 --time 200ms");
  const double spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (const auto& result : results) EXPECT_GT(result.at("runs"), 1);
  // Two files, and as much again for a busy machine, its start and what is solved last.
  EXPECT_LT(spent_s, 5.0);
  EXPECT_EQ(results_of(files + " --repeat 3").front().at("runs"), 3);
  EXPECT_NE(thenar_program("solve --repeat 3 " + files).text.find("  runs   median us"), std::string::npos);
}

TEST(Solve, RefusesWrongCommands) {
  const std::string contact = data("contact/paper15_s1.fcp"), grasp = data("small/14_grasp4.json");
  const ProgramResult method = thenar_program("solve --method newton " + contact + " " + grasp);
  EXPECT_EQ(method.code, 2);
  EXPECT_NE(method.text.find("--method: newton does not solve " + grasp + " (P1)"), std::string::npos) << method.text;
  EXPECT_NE(method.text.find("active_set, lemke, exact_cone and all"), std::string::npos) << method.text;
  EXPECT_EQ(std::count(method.text.begin(), method.text.end(), '\n'), 1) << "nothing is solved before";
  EXPECT_EQ(thenar_program("solve").code, 2);
  EXPECT_EQ(thenar_program("solve --method simplex " + contact).code, 2);
  EXPECT_EQ(thenar_program("solve --repeat 0 " + contact).code, 2);
  EXPECT_EQ(thenar_program("solve --tolerance 0 " + contact).code, 2);
  EXPECT_EQ(thenar_program("solve --help").code, 0);
}

TEST(Solve, RefusesBrokenFilesBeforeItSolvesAny) {
  const fs::path broken = scratch() / "broken.fcp";
  std::ofstream(broken, std::ios::binary) << read(data("contact/paper15_s1.fcp")).substr(0, 5000);
  for (const std::string& file : {broken.string(), std::string("nowhere.fcp"), std::string("nowhere.json")}) {
    const ProgramResult run = thenar_program("solve " + data("contact/paper15_s1.fcp") + " " + file);
    EXPECT_EQ(run.code, 3);
    EXPECT_TRUE(run.text.starts_with(file + ": ")) << run.text;
    EXPECT_EQ(std::count(run.text.begin(), run.text.end(), '\n'), 1) << run.text;
  }
}

// Written for others and read again, a problem is the same one, and has the same forces, to the last bit.
TEST(Solve, ExchangesContactProblemsByFclib) {
  if (!fclib_obstacle().empty()) GTEST_SKIP() << fclib_obstacle();
  const fs::path there = scratch() / "problem.hdf5", back = scratch() / "problem.fcp";
  const auto problem = std::get<ContactFile>(read_problem(data("contact/pressed15_seq_s1.fcp")));
  const ProgramResult run =
      thenar_program("solve --repeat 1 " + data("contact/pressed15_seq_s1.fcp") + " --write " + there.string());
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_NE(run.text.find("holds one problem, which is step 0 of 50"), std::string::npos) << run.text;
  const auto results = results_of(there.string() + " --repeat 1 --forces --write " + back.string());
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].at("name"), problem.name);
  EXPECT_EQ(results[0].at("status"), "solved");
  for (const fs::path& file : {there, back}) {
    SCOPED_TRACE(file);
    const auto read = std::get<ContactFile>(read_problem(file));
    EXPECT_EQ(read.W, problem.W);
    EXPECT_EQ(read.delta_free[0], problem.delta_free[0]);
    EXPECT_EQ(read.mu, problem.mu);
    EXPECT_EQ(read.status, "solved");
    EXPECT_EQ(read.f_reference, vector_of(results[0].at("f")));
    EXPECT_LE(read.reference_residual, 1e-8);
  }
}

TEST(Solve, RefusesWhatFclibCannotHold) {
  const std::string contact = data("contact/paper15_s1.fcp"), grasp = data("small/14_grasp4.json");
  const fs::path out = scratch() / "out.hdf5", broken = scratch() / "broken.hdf5";
  std::ofstream(broken) << "no HDF5";
  const auto expect = [&](const std::string& arguments, int code, const std::string& what) {
    const ProgramResult run = thenar_program("solve " + arguments);
    EXPECT_EQ(run.code, code) << run.text;
    EXPECT_NE(run.text.find(what), std::string::npos) << run.text;
    EXPECT_EQ(std::count(run.text.begin(), run.text.end(), '\n'), 1) << "nothing of HDF5's own: " << run.text;
    EXPECT_FALSE(fs::exists(out));
  };
  expect(contact + " --write out.txt", 2, "--write: out.txt must end in .hdf5 or .h5 (FCLIB) or in .fcp");
  expect(contact + " " + contact + " --write " + out.string(), 2, "--write: takes one problem");
  if (!fclib_obstacle().empty()) {
    expect(broken.string(), 2, broken.string() + ": " + fclib_obstacle());
    expect(contact + " --write " + out.string(), 2, out.string() + ": " + fclib_obstacle());
    return;
  }
  expect(grasp + " --write " + out.string(), 2, "--write: takes a contact problem, and " + grasp + " is none");
  expect(contact + " --write " + contact, 2, "would replace " + contact);
  expect(broken.string(), 3, broken.string() + ": is no HDF5 file");
  expect(contact + " nowhere.h5", 3, "nowhere.h5: ");
}

// Two fingers that face each other, the second with less friction or none: the same forces by every method, or words
// that name the friction of each.
TEST(Solve, GraspsOfContactsThatDiffer) {
  const auto file = [](const char* mu, const char* load_N) {
    const fs::path path = scratch() / "grasp.json";
    std::ofstream(path) << R"({"problem": "P1", "contact_points": [[-0.02, 0, 0], [0.02, 0, 0]],
      "normals_inward": [[1, 0, 0], [-1, 0, 0]], "tangent_u": [[0, 1, 0], [0, 1, 0]],
      "tangent_v": [[0, 0, 1], [0, 0, -1]], "lambda": [6, 2], "mu": )"
                        << mu << R"(, "W": [0, )" << load_N << ", 0, 0, 0, 0]}";
    return path.string();
  };
  // 1/2 (N^2 + N^2) - 6 N - 2 N is least at N = 4, where the second finger holds 0.8 N. Half of the load is 1 N: N = 5.
  const auto results = results_of(file("[0.4, 0.2]", "2") + " --method all --repeat 1 --forces");
  ASSERT_EQ(results.size(), 3U);
  for (const auto& result : results) {
    SCOPED_TRACE(result.at("method"));
    EXPECT_EQ(result.at("status"), "optimal");
    const VectorXd expected = (VectorXd(6) << 5.0, 1.0, 0.0, -5.0, 1.0, 0.0).finished();
    EXPECT_LE((vector_of(result.at("f")) - expected).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(result.at("objective"), 0.5 * (26.0 + 26.0) - 6.0 * 5.0 - 2.0 * 5.0, 1e-12);
  }
  // Each finger has to carry half of the load, and the second can carry nothing.
  const ProgramResult none = thenar_program("solve --repeat 1 --method all " + file("[0.4, 0]", "2"));
  EXPECT_NE(none.text.find("at frictions 0.4 and 0 contact"), std::string::npos) << none.text;
  EXPECT_NE(none.text.find("at every contact would do"), std::string::npos) << none.text;
  const ProgramResult bad = thenar_program("solve " + file("[0.4, 0.3, 0.2]", "2"));
  EXPECT_EQ(bad.code, 3);
  EXPECT_NE(bad.text.find("grasp.json: key 'mu': must be a number, or a list of 2 numbers"), std::string::npos);
}

// The problems of a run, solved again from their files, come out as they did in the run.
TEST(DumpProblems, WritesWhatTheRunSolved) {
  for (const std::string runner : {"", " --lockstep --control-delay 5ms --set 'time.control_period=3 ms'"}) {
    SCOPED_TRACE(runner);
    const fs::path folder = scratch() / "problems";
    const ProgramResult run = thenar_program("run " + config("box_grasp.yaml") + " --time 0.11" + runner +
                                             " --dump-problems " + folder.string() + " --dump-every 50");
    ASSERT_EQ(run.code, 0) << run.text;
    EXPECT_NE(run.text.find("problems of one tick in 50"), std::string::npos) << run.text;
    std::vector<std::string> names;
    std::string files;
    for (const auto& entry : fs::directory_iterator(folder)) {
      names.push_back(entry.path().filename());
      files += " " + entry.path().string();
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(names, (std::vector<std::string>{"contact-000000.fcp", "contact-000050.fcp", "contact-000100.fcp",
                                               "grasp-000000.json", "grasp-000050.json", "grasp-000100.json",
                                               "muscle-000000.json", "muscle-000050.json", "muscle-000100.json"}));
    const auto results = results_of("--repeat 2" + files);
    EXPECT_EQ(results.size(), 12U) << "contact problems from nothing, and from the forces of the tick before";

    // The warm start is the run's: near the solution, for a tick changes little.
    const auto contact = std::get<ContactFile>(read_problem(folder / "contact-000100.fcp"));
    EXPECT_EQ(contact.name, "box grasp contact 100");
    const double cold = contact_residual(contact.problem(), VectorXd::Zero(contact.f_last.size())).norm;
    EXPECT_LE(contact_residual(contact.problem(), contact.f_last).norm, 0.2 * cold);
  }
}

// Where a stiffness is chosen the muscles' problem is P3, whose forces are those that the run commanded: of the file by
// the program, and of signals.csv, which has nine digits.
TEST(DumpProblems, WritesTheProblemOfAStiffnessThatTheRunSolved) {
  const fs::path folder = scratch() / "problems", out = scratch() / "out";
  const ProgramResult run = thenar_program("run " + config("box_stiff.yaml") + " --time 0.6 --no-figures --out " +
                                           out.string() + " --dump-problems " + folder.string() + " --dump-every 50");
  ASSERT_EQ(run.code, 0) << run.text;
  const auto results = results_of("--repeat 1 --forces " + (folder / "muscle-000050.json").string());
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].at("problem"), "P3");
  EXPECT_EQ(results[0].at("status"), "optimal");
  const VectorXd f = vector_of(results[0].at("f"));
  const NumberTable signals = read_number_table(out / "signals.csv");
  const auto first = std::ranges::find(signals.names, "OP_asked_N") - signals.names.begin();
  ASSERT_LE(first + f.size(), std::ssize(signals.names));
  EXPECT_LE((signals.numbers.row(50).segment(first, f.size()).transpose() - f).cwiseAbs().maxCoeff(),
            1e-6 * f.maxCoeff());
}

TEST(DumpProblems, NeedsAVirtualClock) {
  const fs::path folder = scratch() / "problems";
  const std::string dump = "run " + config("minimal.yaml") + " --time 0.01 --dump-problems " + folder.string();
  const ProgramResult run = thenar_program(dump + " --realtime");
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.text.find("--dump-problems"), std::string::npos) << run.text;
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_EQ(thenar_program(dump + " --dump-every 0").code, 2);
  EXPECT_EQ(thenar_program("run " + config("minimal.yaml") + " --dump-every 5").code, 2);
}

}  // namespace
}  // namespace thenar::solve_test
