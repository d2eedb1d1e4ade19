// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <random>

#include "bench/cases/grasp_families.h"
#include "tests/support/json_eigen.h"
#include "tests/support/nnls.h"

namespace thenar {

// Grasps to try solvers on, and their matrices, written out once more for oracles.

/// G, the 6 x 3n map from contact forces to the wrench.
Eigen::MatrixXd grasp_map(const Grasp& grasp);

double friction_of(const Grasp& grasp, Eigen::Index contact);
double internal_force_of(const Grasp& grasp, Eigen::Index contact);

/// A of eq. (10).
Eigen::MatrixXd pyramid_rows(const Grasp& grasp);

/// The edges of all pyramids, one a column: the forces that the contacts can give are their non-negative combinations.
Eigen::MatrixXd pyramid_edges(const Grasp& grasp);

/// The least length of W - G f over f inside the pyramids; torques in newtons at 3 cm.
double wrench_out_of_reach(const Grasp& grasp);

Eigen::Vector3d random_vector(std::mt19937& random);

Eigen::Matrix3d random_rotation(std::mt19937& random);

/// A right-handed frame whose first axis is n, turned about it at random.
Eigen::Matrix3d frame_about(const Eigen::Vector3d& n, std::mt19937& random);

/// Contacts on a ball of 3 cm with normals up to some 30 degrees off its radius, and a wrench of a few newtons.
Grasp random_grasp(Eigen::Index contacts, std::mt19937& random);

/// The grasp with a friction and an internal force of each contact's own, from the same ranges.
Grasp with_random_grips(Grasp grasp, std::mt19937& random);

/// One of recorded_small_problems("P1").
Grasp recorded_grasp(const nlohmann::json& problem);

/// Three fingers on two faces of a box of 5 cm, as the hand holds it; x across the box.
Grasp box_grasp(double friction);

}  // namespace thenar
