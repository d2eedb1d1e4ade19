// SPDX-License-Identifier: Apache-2.0
#include "engine/problems/problem_dump.h"

#include <fmt/format.h>

#include "engine/formats/build_info.h"
#include "engine/grasp/delassus.h"

namespace thenar {

using Eigen::Index;
using Eigen::VectorXd;

ContactFile contact_problem_file(const Model& model, const Frame& frame, const ContactScratch& work) {
  const Index rows = 3 * frame.size();
  ContactFile problem;
  problem.units = "SI_m_N_displacement_level";
  problem.source = fmt::format("thenar {}", build_info::kVersion);
  problem.W = dense_delassus(model, frame, work.kinematics, work.mobility);
  problem.delta_free.emplace_back(work.delta_free.head(rows));
  problem.mu = work.mu.head(frame.size());
  problem.f_last = work.f_first.head(rows);
  return problem;
}

GraspFile grasp_problem_file(const Scene& scene, const ControlReport& report) {
  GraspFile grasp;
  for (const GraspContact& contact : report.contacts) {
    // About the object's origin, as the wrench is: the arms keep their digits wherever the object is.
    grasp.contacts.push_back({contact.point_m - report.centre_m, contact.axes});
  }
  grasp.wrench = report.wrench_desired;
  grasp.friction = scene.control->grasp_friction;
  grasp.internal_force_N = scene.control->internal_force_N;
  grasp.grips.assign(report.reflex.grips.begin(), report.reflex.grips.end());
  // The format has the answers for both cones, whichever the run asks for.
  const auto answer = [&](FrictionCone cone, std::string& status, VectorXd& f_optimal) {
    VectorXd f(3 * std::ssize(grasp.contacts));
    const GraspStatus found = solve_grasp_forces(grasp.problem(cone), f).status;
    if (found == GraspStatus::kOptimal) f_optimal = f;
    if (found != GraspStatus::kBudgetSpent) status = found == GraspStatus::kOptimal ? "optimal" : "infeasible";
  };
  answer(FrictionCone::kPyramid, grasp.status, grasp.f_optimal);
  answer(FrictionCone::kExact, grasp.status_exact_cone, grasp.f_optimal_exact_cone);
  return grasp;
}

MusclesFile muscle_problem_file(const Controller& controller, const ControlReport& report) {
  if (report.stiffness.share > 0.0) {
    return StiffMuscleFile{controller.stiffness->problem(), {}, "optimal", controller.f_muscle};
  }
  MuscleFile muscles;
  muscles.H = controller.H;
  muscles.tau = report.torques_desired_Nm;
  muscles.limit = controller.most_N;
  if (report.muscle == MuscleStatus::kOptimal) {
    muscles.status = "optimal";
    muscles.f_optimal = controller.f_muscle;
  } else if (report.muscle == MuscleStatus::kInfeasible) {
    muscles.status = "infeasible";
  }
  return muscles;
}

std::optional<StiffMuscleFile> unmet_stiffness_file(const Controller& controller, const ControlReport& report) {
  if (!report.stiffness.is_infeasible) return std::nullopt;
  // What has no forces for a share of K_des has none for more.
  StiffMuscleFile stiff{controller.stiffness->problem(), {}, "infeasible", {}};
  stiff.K_des = controller.stiffness->wanted();
  return stiff;
}

bool ProblemDump::see_control(const ControlTick& tick) {
  const Scene& scene = tick.run->model.scene;
  if (!scene.control) return true;
  grasp_ = grasp_problem_file(scene, tick.report);
  if (!scene.control->muscles) return true;
  muscle_ = muscle_problem_file(tick.run->controller, tick.report);
  unmet_ = unmet_stiffness_file(tick.run->controller, tick.report);
  return true;
}

bool ProblemDump::see_tick(const Tick& done) try {
  const GraspRun& run = *done.run;
  const std::int64_t tick = done.after.tick - 1;
  if (tick % every_ != 0 || fault_) return true;
  const auto write = [&](auto& problem, const char* kind, const char* ending) {
    problem.name = fmt::format("{} {} {}", run.model.scene.name, kind, tick);
    write_problem(folder_ / fmt::format("{}-{:06}.{}", kind, tick, ending), problem);
    ++files_;
  };
  if (run.frame.size() > 0) {
    ContactFile contact = contact_problem_file(run.model, run.frame, run.work);
    write(contact, "contact", "fcp");
  }
  if (grasp_) write(*grasp_, "grasp", "json");
  if (muscle_) std::visit([&](auto& problem) { write(problem, "muscle", "json"); }, *muscle_);
  if (unmet_) write(*unmet_, "stiffness", "json");
  grasp_.reset();
  muscle_.reset();
  unmet_.reset();
  return true;
} catch (const FileError& error) {
  fault_ = error;
  return true;
}

}  // namespace thenar
