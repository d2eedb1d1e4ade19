// SPDX-License-Identifier: Apache-2.0
#include "tests/support/grasp_problems.h"

#include <Eigen/Geometry>
#include <random>

#include "bench/cases/grasp_families.h"
#include "tests/support/json_eigen.h"
#include "tests/support/nnls.h"

namespace thenar {

Eigen::MatrixXd grasp_map(const Grasp& grasp) {
  Eigen::MatrixXd G(6, 3 * grasp.n());
  grasp_map(grasp.contacts, grasp.centre_m, G);
  return G;
}

double friction_of(const Grasp& grasp, Eigen::Index contact) {
  return grasp.grips.empty() ? grasp.friction : grasp.grips[contact].friction;
}

double internal_force_of(const Grasp& grasp, Eigen::Index contact) {
  return grasp.grips.empty() ? grasp.internal_force_N : grasp.grips[contact].internal_force_N;
}

Eigen::MatrixXd pyramid_rows(const Grasp& grasp) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(5 * grasp.n(), 3 * grasp.n());
  for (Eigen::Index i = 0; i < grasp.n(); ++i) {
    const Eigen::Matrix3d& frame = grasp.contacts[i].axes;
    for (int row = 0; row < 4; ++row) {
      A.block<1, 3>(5 * i + row, 3 * i) =
          (friction_of(grasp, i) * frame.col(0) + (row % 2 == 0 ? -1.0 : 1.0) * frame.col(1 + row / 2)).transpose();
    }
    A.block<1, 3>(5 * i + 4, 3 * i) = frame.col(0).transpose();
  }
  return A;
}

Eigen::MatrixXd pyramid_edges(const Grasp& grasp) {
  Eigen::MatrixXd E = Eigen::MatrixXd::Zero(3 * grasp.n(), 4 * grasp.n());
  for (Eigen::Index i = 0; i < grasp.n(); ++i) {
    for (int k = 0; k < 4; ++k) {
      const double mu = friction_of(grasp, i);
      const Eigen::Vector3d edge(1.0, k / 2 == 0 ? mu : -mu, k % 2 == 0 ? mu : -mu);
      E.block<3, 1>(3 * i, 4 * i + k) = grasp.contacts[i].axes * edge;
    }
  }
  return E;
}

double wrench_out_of_reach(const Grasp& grasp) {
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 30.0, 30.0, 30.0;
  return distance_from_cone(scale.asDiagonal() * grasp_map(grasp) * pyramid_edges(grasp),
                            scale.asDiagonal() * grasp.wrench);
}

Eigen::Vector3d random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

Eigen::Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

Eigen::Matrix3d frame_about(const Eigen::Vector3d& n, std::mt19937& random) {
  Eigen::Matrix3d frame;
  frame.col(0) = n.normalized();
  frame.col(1) = frame.col(0).cross(random_vector(random)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

Grasp random_grasp(Eigen::Index contacts, std::mt19937& random) {
  Grasp grasp;
  grasp.centre_m = 0.05 * random_vector(random);
  for (Eigen::Index i = 0; i < contacts; ++i) {
    const Eigen::Vector3d outward = random_vector(random).normalized();
    const Eigen::Vector3d inward = -outward + 0.3 * random_vector(random);
    grasp.contacts.push_back({0.03 * outward, frame_about(inward, random)});
  }
  grasp.wrench.head<3>() = random_vector(random);
  grasp.wrench.tail<3>() = 0.01 * random_vector(random);
  std::uniform_real_distribution<double> uniform;
  grasp.friction = 0.2 + 0.8 * uniform(random);
  grasp.internal_force_N = 3.0 * uniform(random);
  return grasp;
}

Grasp with_random_grips(Grasp grasp, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform;
  grasp.grips.clear();
  for (Eigen::Index i = 0; i < grasp.n(); ++i) {
    const double friction = 0.2 + 0.8 * uniform(random);
    grasp.grips.push_back({.friction = friction, .internal_force_N = 3.0 * uniform(random)});
  }
  return grasp;
}

Grasp recorded_grasp(const nlohmann::json& problem) {
  Grasp grasp;
  for (Eigen::Index i = 0; i < problem.at("n_contacts"); ++i) {
    GraspContact contact;
    contact.point_m = vector_of(problem.at("contact_points")[i]);
    contact.axes << vector_of(problem.at("normals_inward")[i]), vector_of(problem.at("tangent_u")[i]),
        vector_of(problem.at("tangent_v")[i]);
    grasp.contacts.push_back(contact);
  }
  grasp.wrench = vector_of(problem.at("W"));
  grasp.friction = problem.at("mu");
  grasp.internal_force_N = problem.at("lambda");
  return grasp;
}

Grasp box_grasp(double friction) {
  Grasp grasp;
  const Eigen::Matrix3d along = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d against;
  against << -Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitZ();
  grasp.contacts = {{{-0.025, 0.0, 0.0}, along}, {{0.025, 0.01, 0.0}, against}, {{0.025, -0.01, 0.0}, against}};
  grasp.friction = friction;
  return grasp;
}

}  // namespace thenar
