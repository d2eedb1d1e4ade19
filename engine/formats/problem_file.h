// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <variant>

#include "engine/formats/contact_file.h"
#include "solvers/grasp_forces.h"
#include "solvers/lcp.h"
#include "solvers/muscles/muscle_forces.h"
#include "solvers/muscles/stiff_problem.h"

namespace thenar {

/// A grasp-force problem; torques are about the origin of the contact points.
struct GraspFile : GraspData {
  std::string name;
  std::string status;             ///< Known answer for the pyramid: "optimal" or "infeasible"; may be empty.
  std::string status_exact_cone;  ///< Known answer for the exact cone.
  Eigen::VectorXd f_optimal, f_optimal_exact_cone;  ///< Known optima, 3 per contact [N]; may be empty.
};

struct MuscleFile : MuscleData {
  std::string name;
  std::string status;         ///< Known answer: "optimal" or "infeasible"; may be empty.
  Eigen::VectorXd f_optimal;  ///< Known optimum [N]; may be empty.
};

/// Muscle forces under an object stiffness.
struct StiffMuscleFile : StiffMuscleData {
  std::string name;
  std::string status;         ///< Known answer: "optimal" or "infeasible"; may be empty.
  Eigen::VectorXd f_optimal;  ///< Known optimum [N]; may be empty.
};

struct LcpFile : LcpData {
  std::string name;
  std::string status;  ///< Known answer: "solved" or "no_solution"; may be empty.
  Eigen::VectorXd z;   ///< A solution; may be empty.
};

using ProblemFile = std::variant<ContactFile, GraspFile, MuscleFile, StiffMuscleFile, LcpFile>;

/// Reads a problem with finite values and consistent shapes. A problem without a name is named after its file.
///
/// .fcp   A contact problem: contact_file.h. So are .hdf5 and .h5, in the format of FCLIB: fclib_file.h.
/// .json  The kind is `problem`: "P1" grasp forces, "P2" muscle forces, "P3" those under an object stiffness, "LCP". A
///        grasp is defined by its contact points and axes; G, A and c are optional, but must not contradict them. mu
///        and lambda are a number for all contacts, or a list with one for each.
///
/// Throws FileError: "path: what is wrong", with the line or the key.
[[nodiscard]] ProblemFile read_problem(const std::filesystem::path& file);

/// Writes a problem so that it is read back to the last bit, with all data of the formats. A known optimum is written
/// with its objective and the rows without slack. Throws FileError.
/// Requires  Finite values.
void write_problem(const std::filesystem::path& file, const GraspFile& problem);
void write_problem(const std::filesystem::path& file, const MuscleFile& problem);
void write_problem(const std::filesystem::path& file, const StiffMuscleFile& problem);
void write_problem(const std::filesystem::path& file, const LcpFile& problem);

}  // namespace thenar
