// SPDX-License-Identifier: Apache-2.0
#include "python/problems.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "python/arrays.h"
#include "python/interpreter.h"
#include "solvers/contact_newton.h"
#include "solvers/gauss_seidel.h"
#include "solvers/grasp_forces.h"
#include "solvers/muscles/muscle_forces.h"
#include "solvers/muscles/stiff_muscles.h"

namespace thenar::python {

namespace {

constexpr py::ssize_t kMostContacts = 2000;

const char* word(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged:
      return "converged";
    case SolveStatus::kBudgetSpent:
      return "budget spent";
    case SolveStatus::kNotFinite:
      return "not finite";
    case SolveStatus::kNoSolution:
      return "no solution";
  }
  return "";
}
const char* word(GraspStatus status) {
  return status == GraspStatus::kOptimal      ? "optimal"
         : status == GraspStatus::kInfeasible ? "infeasible"
                                              : "budget spent";
}
const char* word(MuscleStatus status) {
  return status == MuscleStatus::kOptimal      ? "optimal"
         : status == MuscleStatus::kInfeasible ? "infeasible"
                                               : "budget spent";
}

/// A number for all of n contacts, or an array with one for each.
Eigen::VectorXd number_of_each(py::handle value, Eigen::Index n, const std::string& name) {
  const auto any = py::array::ensure(value);
  if (any && any.ndim() == 0) return Eigen::VectorXd::Constant(n, number(value, name));
  return vector(value, n, name);
}

py::tuple solve_contact(py::handle W, py::handle delta_free, py::handle mu, const std::string& method,
                        py::handle tolerance, int iterations, py::handle guess) {
  ContactData data;
  data.W = matrix(W, -1, -1, "W");
  const Eigen::Index rows = data.W.rows();
  if (rows % 3 != 0 || data.W.cols() != rows) throw py::value_error("W is square, with three rows a contact");
  if (rows > 3 * kMostContacts) throw py::value_error(fmt::format("W has more than {} contacts", kMostContacts));
  data.delta_free = vector(delta_free, rows, "delta_free");
  data.mu = number_of_each(mu, rows / 3, "mu");
  if (data.mu.size() > 0 && data.mu.minCoeff() < 0.0) throw py::value_error("mu is less than 0");
  if (iterations < 0) throw py::value_error("iterations must be 0 or more");
  const double stop = number(tolerance, "tolerance");
  Eigen::VectorXd f = guess.is_none() ? Eigen::VectorXd(Eigen::VectorXd::Zero(rows)) : vector(guess, rows, "guess");
  Eigen::VectorXd delta(rows), certificate;
  SolveReport report;
  int steps = 0;
  if (method == "newton") {
    const Unlocked others;
    AccurateWorkspace work(rows / 3);
    const AccurateReport accurate =
        solve_contacts_accurately(data, {.tolerance = stop, .max_steps = iterations}, work, {f, delta});
    report = accurate.solve;
    steps = accurate.steps;
    if (report.status == SolveStatus::kNoSolution) certificate = work.certificate.head(rows / 3);
  } else if (method == "gauss_seidel") {
    const Unlocked others;
    SweepWorkspace work(rows / 3);
    report = solve_contacts(data, GaussSeidelSettings{.tolerance = stop, .max_sweeps = iterations}, work, {f, delta});
  } else {
    throw py::value_error(fmt::format("there is no method '{}': newton, gauss_seidel", method));
  }
  return py::make_tuple(word(report.status), copy(f), copy(delta), report.residual, report.sweeps, steps,
                        certificate.size() > 0 ? py::object(copy(certificate)) : py::none());
}

py::tuple solve_grasp(py::handle points, py::handle axes, py::handle wrench, py::handle friction,
                      py::handle internal_force, const std::string& cone, py::handle centre) {
  const Eigen::MatrixXd at = matrix(points, -1, 3, "points_m");
  const Eigen::Index n = at.rows();
  if (n < 1 || n > kMaxGraspContacts)
    throw py::value_error(fmt::format("points_m has 1 to {} contacts", kMaxGraspContacts));
  const Array frames = numbers(axes, {n, 3, 3}, "axes");
  std::vector<GraspContact> contacts(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    contacts[i].point_m = at.row(i).transpose();
    contacts[i].axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(frames.data() + 9 * i);
    if ((contacts[i].axes.transpose() * contacts[i].axes - Eigen::Matrix3d::Identity()).norm() > 1e-9) {
      throw py::value_error(fmt::format("axes[{}] is not orthonormal: columns n, t1, t2", i));
    }
  }
  GraspProblem problem;
  problem.contacts = contacts;
  problem.centre_m = vector(centre, 3, "centre_m");
  problem.wrench = vector(wrench, 6, "wrench");
  const Eigen::VectorXd mu = number_of_each(friction, n, "friction");
  const Eigen::VectorXd lambda_N = number_of_each(internal_force, n, "internal_force_N");
  if (mu.minCoeff() < 0.0) throw py::value_error("friction is less than 0");
  std::vector<ContactGrip> grips;
  for (Eigen::Index i = 0; i < n; ++i) grips.push_back({.friction = mu[i], .internal_force_N = lambda_N[i]});
  problem.grips = grips;
  if (cone != "exact" && cone != "pyramid")
    throw py::value_error(fmt::format("there is no cone '{}': exact, pyramid", cone));
  problem.cone = cone == "exact" ? FrictionCone::kExact : FrictionCone::kPyramid;
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * n);
  const GraspReport report = solve_grasp_forces(problem, f);
  const Eigen::Matrix3Xd columns = f.reshaped(3, n);
  return py::make_tuple(word(report.status), copy(columns.transpose()), report.residual, report.iterations,
                        copy(report.multiplier));
}

/// Limits of n muscles: None, or an array that may have infinities.
Eigen::VectorXd limits(py::handle value, Eigen::Index n, const std::string& name) {
  if (value.is_none()) return {};
  const auto given = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!given || given.ndim() != 1 || given.shape(0) != n) {
    PyErr_Clear();
    throw py::value_error(fmt::format("{} has {} numbers, or is None", name, n));
  }
  const Eigen::VectorXd limit = Eigen::Map<const Eigen::VectorXd>(given.data(), n);
  if (!(limit.array() >= 0.0).all()) throw py::value_error(fmt::format("{} is less than 0", name));
  return limit;
}

py::tuple solve_muscles(py::handle H, py::handle tau, py::handle limit) {
  const Eigen::MatrixXd arms = matrix(H, -1, -1, "H");
  if (arms.rows() < 1 || arms.rows() > kMaxJoints || arms.cols() < 1 || arms.cols() > kMaxMuscles) {
    throw py::value_error(fmt::format("H has 1 to {} joints and 1 to {} muscles", kMaxJoints, kMaxMuscles));
  }
  const Eigen::VectorXd torques = vector(tau, arms.rows(), "torques_Nm");
  Eigen::VectorXd f = Eigen::VectorXd::Zero(arms.cols());
  const Eigen::VectorXd limit_N = limits(limit, arms.cols(), "limit_N");
  const MuscleReport report = solve_muscle_forces({arms, torques, limit_N}, f);
  return py::make_tuple(word(report.status), copy(f), report.residual, report.iterations,
                        copy(Eigen::VectorXd(report.multiplier)));
}

/// A symmetric 6 x 6 matrix.
Matrix6d wrench_matrix(py::handle value, const std::string& name) {
  const Matrix6d given = matrix(value, 6, 6, name);
  return 0.5 * (given + given.transpose());
}

py::tuple solve_stiff_muscles_(const py::dict& given) {
  const auto at = [&](const char* key) { return py::object(given[key]); };
  StiffMuscleData p;
  p.H = matrix(at("H"), -1, -1, "H");
  const Eigen::Index joints = p.H.rows(), muscles = p.H.cols();
  if (joints < 1 || joints > kMaxJoints || muscles < 1 || muscles > kMaxMuscles) {
    throw py::value_error(fmt::format("H has 1 to {} joints and 1 to {} muscles", kMaxJoints, kMaxMuscles));
  }
  p.tau = vector(at("torques_Nm"), joints, "torques_Nm");
  p.limit = limits(at("limit_N"), muscles, "limit_N");
  Eigen::Index sum = 0, pairs = 0;
  for (const py::handle n : at("finger_joints")) {
    p.joints.push_back(n.cast<int>());
    if (p.joints.back() < 1 || p.joints.back() > kMaxStiffJoints) {
      throw py::value_error(fmt::format("finger_joints are 1 to {}", kMaxStiffJoints));
    }
    sum += p.joints.back();
    pairs += p.joints.back() * (p.joints.back() + 1) / 2;
  }
  if (sum != joints || std::ssize(p.joints) > kMaxStiffFingers) {
    throw py::value_error(fmt::format("finger_joints are at most {}, in sum the rows of H", kMaxStiffFingers));
  }
  p.arm = at("arm_m").is_none() ? p.H : matrix(at("arm_m"), joints, muscles, "arm_m");
  p.turn = matrix(at("turn_m"), pairs, muscles, "turn_m");
  p.fibre_per_m = vector(at("fibre_per_m"), muscles, "fibre_per_m");
  p.tendon_N_per_m = limits(at("tendon_N_per_m"), muscles, "tendon_N_per_m");
  p.A = wrench_matrix(at("A"), "A");
  p.B = matrix(at("B"), 6, joints, "B");
  p.D = matrix(at("D"), joints, joints, "D");
  p.K_des = wrench_matrix(at("K_des"), "K_des");
  p.kappa = number(at("kappa"), "kappa");
  p.length_m = number(at("length_m"), "length_m");
  Eigen::VectorXd f = Eigen::VectorXd::Zero(muscles);
  const StiffMuscleReport report = solve_stiff_muscles(p, f);
  Matrix6d K_o = Matrix6d::Zero();
  if (report.status == MuscleStatus::kOptimal) (void)object_stiffness(p, f, 0.0, K_o);
  const bool is_lacking = report.status == MuscleStatus::kInfeasible;
  const StiffLack lack = is_lacking ? find_stiff_lack(p) : StiffLack();
  return py::make_tuple(word(report.status), copy(f), report.residual, report.iterations, copy(Eigen::MatrixXd(K_o)),
                        copy(Eigen::VectorXd(report.multiplier)), copy(Eigen::MatrixXd(report.Z)), lack.lacking_N_per_m,
                        copy(Eigen::VectorXd(lack.direction)));
}

}  // namespace

void bind_problems(py::module_& module) {
  module.def("solve_contact", &solve_contact);
  module.def("solve_grasp", &solve_grasp);
  module.def("solve_muscles", &solve_muscles);
  module.def("solve_stiff_muscles", &solve_stiff_muscles_);
}

}  // namespace thenar::python
