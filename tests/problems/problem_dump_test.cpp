// SPDX-License-Identifier: Apache-2.0
// What a run hands over as its problems is what it solved.

#include "engine/problems/problem_dump.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "engine/problems/problem_check.h"
#include "solvers/muscles/stiff_muscles.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::problem_dump_test {
namespace {

using Eigen::VectorXd;

/// The dense problem that the last tick's forces have the residual of that the tick reported, with W in factors.
void expect_last_problem(const Model& model, const Frame& frame, const ContactMemory& memory,
                         const ContactScratch& work, const TickReport& report) {
  const ContactFile problem = contact_problem_file(model, frame, work);
  ASSERT_EQ(problem.contacts(), report.contacts);
  ASSERT_GT(problem.contacts(), 0);
  const VectorXd f = memory.f.head(3 * problem.contacts());
  // Gaps differ by the rounding of sums of some hundred terms: 1e-12 of the scale.
  EXPECT_NEAR(contact_residual(problem.problem(), f).norm, report.solve.residual, 1e-12);
}

TEST(ProblemDump, ContactProblemsAreThoseOfTheTick) {
  Loop loop(scene_of("box_grasp", {kCoarseBox, "contact.max_per_finger=5"}));
  loop.run(0.05);
  for (int i = 0; i < 5; ++i) {
    const VectorXd before = loop.memory.f;
    const std::vector<FrameContact> contacts = loop.frame.contacts;
    loop.memory.change_N.setZero();
    const TickReport report = loop.tick();
    expect_last_problem(loop.model, loop.frame, loop.memory, loop.work, report);
    // The first guess is what the tick before left, contact by contact, where nothing foresees how it goes on.
    const ContactFile problem = contact_problem_file(loop.model, loop.frame, loop.work);
    Eigen::Index kept = 0;
    for (Eigen::Index k = 0; k < loop.frame.size(); ++k) {
      for (std::size_t j = 0; j < contacts.size(); ++j) {
        const FrameContact& now = loop.frame.contacts[static_cast<std::size_t>(k)];
        if (contacts[j].finger != now.finger || contacts[j].control_point != now.control_point) continue;
        ++kept;
        // Opened contacts' forces are shared among those that are loaded.
        const double f_n = before[3 * static_cast<Eigen::Index>(j)];
        EXPECT_GE(problem.f_last[3 * k], f_n * (1.0 - 1e-12));
      }
    }
    EXPECT_GT(kept, 10);
  }
}

// A held drive is a spring on the joints, which W knows of.
TEST(ProblemDump, ContactProblemsOfAHoldHaveItsStiffness) {
  LockstepSettings settings;
  settings.channel = [](double time_s, Frame&) { return time_s < 0.03; };
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox, "contact.max_per_finger=5"}));
  GraspRun loops(model, settings);
  int held = 0;
  for (int tick = 0; tick < 60; ++tick) {
    const TickReport report = loops.tick();
    if (!report.held) continue;
    ++held;
    expect_last_problem(model, loops.frame, loops.memory, loops.work, report);
  }
  EXPECT_GT(held, 10);
}

TEST(ProblemDump, ControlProblemsHaveTheAnswersOfTheTick) {
  Loop loop(scene_of("box_grasp", {kCoarseBox, "contact.max_per_finger=5"}));
  loop.run(0.05);
  loop.tick();
  const GraspFile grasp = grasp_problem_file(loop.model.scene, loop.report);
  EXPECT_EQ(grasp.status, "optimal");
  // The same problem but for the rounding of the points' shift.
  EXPECT_LE((grasp.f_optimal - loop.controller.f_desired).norm(), 1e-12 * grasp.f_optimal.norm());
  const auto muscles = std::get<MuscleFile>(muscle_problem_file(loop.controller, loop.report));
  EXPECT_EQ(muscles.status, "optimal");
  EXPECT_LE(muscle_residual(muscles, loop.controller.f_muscle), 1e-12);
}

/// The box of which muscles are asked for a stiffness, N/m and the same on an arm of 23 mm.
Scene stiff_box(const char* translation, const char* rotation) {
  const auto all = [](const std::string& key, const std::string& value) {
    return "control.muscles.object_stiffness." + key + "=[" + value + ", " + value + ", " + value + "]";
  };
  return scene_of("box_stiff", {kCoarseBox, all("translation", translation), all("rotation", rotation)});
}

// Where a stiffness is chosen the problem of the muscles is that, with or without a squeeze. Solved from nothing, as a
// reader of the file does, it has the forces that the run found from the last ones: both to 1e-9 of the largest force
// [stiff_kkt_error], which the forces may answer a hundredfold, where stiffness hardly depends on some of them.
TEST(ProblemDump, MuscleProblemsUnderAStiffnessHaveTheForcesOfTheTick) {
  const std::filesystem::path file = scratch() / "muscle.json";
  for (const double squeeze_N : {0.0, 2.0}) {
    SCOPED_TRACE(squeeze_N);
    Scene scene = stiff_box("150 N/m", "0.08 N*m/rad");
    scene.control->muscles->object_stiffness->most_squeeze_N = squeeze_N;
    Loop loop(std::move(scene));
    loop.run(0.1);
    for (int tick = 0; tick < 5; ++tick) {
      loop.tick();
      ASSERT_GT(loop.report.stiffness.share, 0.0);
      std::visit([&](const auto& problem) { write_problem(file, problem); },
                 muscle_problem_file(loop.controller, loop.report));
      const auto stiff = std::get<StiffMuscleFile>(read_problem(file));
      EXPECT_EQ(stiff.status, "optimal");
      EXPECT_EQ(stiff.squeeze.has_value(), squeeze_N > 0.0);
      VectorXd f = VectorXd::Zero(stiff.H.cols());
      ASSERT_EQ(solve_stiff_muscles(stiff, f).status, MuscleStatus::kOptimal);
      EXPECT_LE((f - loop.controller.f_muscle).cwiseAbs().maxCoeff(), 1e-7 * f.maxCoeff());
      // They are not the least forces.
      VectorXd least = VectorXd::Zero(f.size());
      ASSERT_EQ(solve_muscle_forces({stiff.H, stiff.tau, stiff.limit}, least).status, MuscleStatus::kOptimal);
      EXPECT_GT((f - least).cwiseAbs().maxCoeff(), 0.1 * f.maxCoeff());
      EXPECT_FALSE(unmet_stiffness_file(loop.controller, loop.report));
    }
  }
}

// What was asked for and cannot be had is a problem of its own, proved to have no answer; what was solved in its place
// is one with an answer.
TEST(ProblemDump, AStiffnessThatCannotBeHadIsAProblemWithoutAnAnswer) {
  const std::filesystem::path file = scratch() / "stiffness.json";
  Loop loop(stiff_box("2000 N/m", "1 N*m/rad"));
  int unmet = 0;
  for (int tick = 0; tick < 100; ++tick) {
    loop.tick();
    const std::optional<StiffMuscleFile> problem = unmet_stiffness_file(loop.controller, loop.report);
    ASSERT_EQ(problem.has_value(), loop.report.stiffness.is_infeasible);
    if (!problem || ++unmet % 10 != 1) continue;
    write_problem(file, *problem);
    const auto stiff = std::get<StiffMuscleFile>(read_problem(file));
    EXPECT_EQ(stiff.status, "infeasible");
    EXPECT_NEAR((stiff.K_des.topLeftCorner<3, 3>().trace()), 3.0 * 2000.0, 1e-6) << "all of it, in any axes";
    VectorXd f = VectorXd::Zero(stiff.H.cols());
    const StiffMuscleReport report = solve_stiff_muscles(stiff, f);
    EXPECT_EQ(report.status, MuscleStatus::kInfeasible);
    EXPECT_LT(stiff_infeasibility_gap(stiff, report), 1.0) << "a proof";
    const MusclesFile solved = muscle_problem_file(loop.controller, loop.report);
    EXPECT_EQ(std::visit([](const auto& one) { return one.status; }, solved), "optimal");
    EXPECT_EQ(std::holds_alternative<StiffMuscleFile>(solved), loop.report.stiffness.share > 0.0);
  }
  EXPECT_GT(unmet, 0);
}

// Of a grip that answers, each finger has a friction and a squeeze of its own, and the pose is known late: a file of it
// that is read back has the forces of the tick.
TEST(ProblemDump, GraspProblemsOfAPulseHaveItsForces) {
  const std::filesystem::path file = scratch() / "grasp.json";
  Loop loop(scene_of("box_wet", {kCoarseBox, "contact.max_per_finger=10", "task.friction=[{at: 0.4 s, to: 0.15}]"}));
  loop.run(0.45);
  int unlike = 0;
  for (int tick = 0; tick < 100; ++tick) {
    loop.tick();
    const PerFinger<ContactGrip>& grips = loop.report.reflex.grips;
    const auto same = [&](const ContactGrip& grip) { return grip.internal_force_N == grips[0].internal_force_N; };
    if (std::all_of(grips.begin(), grips.end(), same)) continue;
    ++unlike;
    write_problem(file, grasp_problem_file(loop.model.scene, loop.report));
    const auto grasp = std::get<GraspFile>(read_problem(file));
    ASSERT_EQ(std::ssize(grasp.grips), loop.model.fingers());
    VectorXd f = VectorXd::Zero(3 * loop.model.fingers());
    ASSERT_EQ(solve_grasp_forces(grasp.problem(loop.model.scene.control->cone), f).status, GraspStatus::kOptimal);
    // The same problem but for the rounding of the points' shift.
    EXPECT_LE((f - loop.controller.f_desired).norm(), 1e-12 * f.norm());
  }
  EXPECT_GT(unlike, 20);
}

}  // namespace
}  // namespace thenar::problem_dump_test
