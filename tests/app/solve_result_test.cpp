// SPDX-License-Identifier: Apache-2.0
// What `thenar solve` says of an answer.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "engine/formats/problem_file.h"
#include "tests/support/program.h"

namespace thenar::solve_result_test {
namespace {

using Eigen::VectorXd;
namespace fs = std::filesystem;

/// Two contacts that press a rigid body from opposite sides by 1 mm: no forces can open them.
ContactFile pressed_rigid_body() {
  ContactFile problem;
  problem.name = "pressed";
  Eigen::Matrix<double, 6, 3> J;
  J << 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, 1, 0, 0, 0, -1;
  problem.W = 1e-3 * J * J.transpose();
  problem.mu = VectorXd::Constant(2, 0.5);
  problem.delta_free = {VectorXd::Zero(6)};
  problem.delta_free[0][0] = -1e-3;
  return problem;
}

TEST(Solve, SaysInWordsWhyThereIsNoSolution) {
  const fs::path file = scratch() / "pressed.fcp";
  write_problem(file, pressed_rigid_body());
  const ProgramResult contact = thenar_program("solve --repeat 1 " + file.string());
  EXPECT_EQ(contact.code, 0) << contact.text;
  EXPECT_NE(contact.text.find("no_solution: bodies that do not give way press contacts 0 (1) and 1 (1) together"),
            std::string::npos)
      << contact.text;
  EXPECT_NE(contact.text.find("stay closed by 0.001 m whatever the forces"), std::string::npos) << contact.text;

  const ProgramResult grasp = thenar_program("solve --repeat 1 " + data("small/08_box3_infeasible.json"));
  EXPECT_EQ(grasp.code, 0) << grasp.text;
  EXPECT_NE(grasp.text.find("contact 1 lacks "), std::string::npos) << grasp.text;
  EXPECT_NE(grasp.text.find(" N of tangential"), std::string::npos) << grasp.text;
  EXPECT_NE(grasp.text.find("a friction of at least "), std::string::npos) << grasp.text;

  const ProgramResult muscles = thenar_program("solve --repeat 1 " + data("small/36_muscle_infeasible.json"));
  EXPECT_EQ(muscles.code, 0) << muscles.text;
  EXPECT_NE(muscles.text.find(" N m of row 11"), std::string::npos) << muscles.text;
  EXPECT_NE(muscles.text.find("at best |H f - tau| is "), std::string::npos) << muscles.text;
}

// What a file says of its answer is held against what is found, and a tolerance against what is reached.
TEST(Solve, EndsWithSixWhereTheAnswerIsNotRight) {
  const fs::path folder = scratch();
  ContactFile wrong = pressed_rigid_body();
  wrong.status = "solved";
  write_problem(folder / "wrong.fcp", wrong);
  const ProgramResult verdict = thenar_program("solve --repeat 1 " + (folder / "wrong.fcp").string());
  EXPECT_EQ(verdict.code, 6);
  EXPECT_NE(verdict.text.find("failed: pressed by newton: 'no_solution', and the file says 'solved'"),
            std::string::npos)
      << verdict.text;

  const std::string muscles = data("small/34_muscle_feasible.json");
  EXPECT_EQ(thenar_program("solve --repeat 1 " + muscles).code, 0);
  const ProgramResult accuracy = thenar_program("solve --repeat 1 --tolerance 1e-15 " + muscles);
  EXPECT_EQ(accuracy.code, 6);
  EXPECT_NE(accuracy.text.find("is above 1e-15"), std::string::npos) << accuracy.text;
}

}  // namespace
}  // namespace thenar::solve_result_test
