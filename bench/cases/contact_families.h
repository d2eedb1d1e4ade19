// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>
#include <vector>

#include "bench/cases/factored_contacts.h"
#include "bench/cases/random.h"
#include "solvers/contact_problem.h"

namespace thenar {

namespace families {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Columns n, t1, t2.
inline Matrix3d axes(const Vector3d& direction) {
  const Vector3d n = direction.normalized();
  const Vector3d t1 = n.cross(std::abs(n.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitY()).normalized();
  Matrix3d E;
  E << n, t1, n.cross(t1);
  return E;
}

/// Rows E' [I, -[p]x]: how a body's motion about the origin changes gap and slips of a contact that presses along n.
inline Eigen::Matrix<double, 3, 6> body_rows(const Matrix3d& E, const Vector3d& p) {
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() = E.transpose();
  for (int a = 0; a < 3; ++a) J.row(a).tail<3>() = p.cross(E.col(a)).transpose();
  return J;
}

/// Place k of `count` in a disc, evenly spread, as in a sunflower.
inline Eigen::Vector2d sunflower(Index k, Index count, double radius_m) {
  const double turn = std::numbers::pi * (1.0 + std::sqrt(5.0)) * (static_cast<double>(k) + 0.5);
  const double r = radius_m * std::sqrt((static_cast<double>(k) + 0.5) / static_cast<double>(count));
  return {r * std::cos(turn), r * std::sin(turn)};
}

/// What the families of grasps differ in. The defaults hold an object of 50 mm at a step of 5 ms.
struct GraspScene {
  Index per_finger = 20;
  Index copies = 1;  ///< Of every contact: W has as many equal rows.
  double step_s = 5e-3;
  double pulp_radius_m = 8e-3;       ///< Of the gap's curvature under a finger; large: all contacts are pressed.
  double depth_m = 1.2e-3;           ///< Free penetration.
  double slip_m = 0.5e-3;            ///< Free slip.
  double compliance_m_per_N = 2e-4;  ///< Of a contact alone; 0: rigid pulps, W of rank 18 at most.
  double bumpiness = 0.0;            ///< Random tilt of normals.
  double object_viscosity = 20.0;
  std::array<double, 3> joint_viscosity{0.05, 0.05, 0.05};
};

/// Three fingers on one object: a thumb from the left, two fingers from the right. W in factors, too, for who asks;
/// they have one viscosity of joints, the first finger's.
inline ContactData grasp(const GraspScene& scene, Random& random, FactoredContacts* factors = nullptr) {
  constexpr double kPadRadius_m = 4.5e-3, kKernelWidth_m = 1.5e-3, kJitter_m = 2e-4;
  // The object's rotational over its translational viscosity: that of a sphere of 21 mm, 4/3 r^2.
  constexpr double kRotation_m2 = 6e-4;
  const std::array<Vector3d, 3> centre{Vector3d(-0.025, 0.0, 0.0), Vector3d(0.025, 0.012, 0.004),
                                       Vector3d(0.025, -0.012, -0.004)};
  const Index per_finger = scene.per_finger * scene.copies, n = 3 * per_finger;
  ContactData problem{MatrixXd::Zero(3 * n, 3 * n), VectorXd(3 * n), VectorXd::Constant(n, 0.6)};
  MatrixXd J_object(3 * n, 6);
  for (int finger = 0; finger < 3; ++finger) {
    const Vector3d inwards = finger == 0 ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitX());
    const Matrix3d pad = axes(inwards);
    // Joints: one that spreads, three that bend; phalanges of 45, 25 and 20 mm hang down to the pad.
    std::array<Vector3d, 4> joint_centre, joint_axis;
    joint_centre.fill(centre[finger] - 0.03 * inwards + Vector3d(0.0, 0.0, 0.07));
    const Vector3d along = Vector3d(0.4 * inwards.x(), 0.0, -0.916);
    joint_centre[2] += 0.045 * along;
    joint_centre[3] += 0.070 * along;
    joint_axis.fill(Vector3d::UnitZ().cross(along).normalized());
    joint_axis[0] = Vector3d::UnitZ();

    const Index first = 3 * finger * per_finger;
    MatrixXd J_finger(3 * per_finger, 4);
    std::vector<Vector3d> point(per_finger);
    std::vector<Matrix3d> E(per_finger);
    const double depth_m = scene.depth_m * random.uniform(0.75, 1.25);
    const Eigen::Vector2d slip_m(scene.slip_m * random.normal(), scene.slip_m * random.normal());
    const double twist = random.uniform(-0.15, 0.15) * std::min(1.0, scene.slip_m / 0.5e-3);
    for (Index i = 0; i < per_finger; ++i) {
      if (i % scene.copies == 0) {
        const double jitter_1 = kJitter_m * random.normal(), jitter_2 = kJitter_m * random.normal();
        const Eigen::Vector2d place =
            sunflower(i / scene.copies, scene.per_finger, kPadRadius_m) + Eigen::Vector2d(jitter_1, jitter_2);
        point[i] = centre[finger] + pad.rightCols<2>() * place;
        E[i] = axes(inwards + scene.bumpiness * random.normal3());
        const Index row = first + 3 * i;
        problem.delta_free[row] = place.squaredNorm() / (2.0 * scene.pulp_radius_m) - depth_m;
        problem.delta_free.segment<2>(row + 1) = slip_m + twist * Eigen::Vector2d(-place.y(), place.x());
      } else {
        point[i] = point[i - 1];
        E[i] = E[i - 1];
        problem.delta_free.segment<3>(first + 3 * i) = problem.delta_free.segment<3>(first + 3 * i - 3);
      }
      J_object.middleRows<3>(first + 3 * i) = body_rows(E[i], point[i]);
      for (int j = 0; j < 4; ++j) {
        J_finger.block<3, 1>(3 * i, j) = -E[i].transpose() * joint_axis[j].cross(point[i] - joint_centre[j]);
      }
    }
    auto W_finger = problem.W.block(first, first, 3 * per_finger, 3 * per_finger);
    if (factors != nullptr) {
      factors->J_own.conservativeResize(first + 3 * per_finger, GroupedDelassus::kOwn);
      factors->J_own.bottomRows(3 * per_finger) = J_finger;
      factors->begin.push_back(first / 3 + per_finger);
    }
    W_finger = scene.step_s / scene.joint_viscosity[finger] * J_finger * J_finger.transpose();
    for (Index i = 0; i < per_finger; ++i) {
      for (Index j = 0; j < per_finger; ++j) {
        const double distance = (point[i] - point[j]).norm() / kKernelWidth_m;
        W_finger.block<3, 3>(3 * i, 3 * j) +=
            scene.compliance_m_per_N * std::exp(-0.5 * distance * distance) * E[i].transpose() * E[j];
      }
    }
    if (factors != nullptr) {
      SurfaceCompliance& C = factors->compliance.emplace_back(per_finger);
      factors->axes.conservativeResize(first + 3 * per_finger, 3);
      for (Index i = 0; i < per_finger; ++i) {
        factors->axes.middleRows<3>(first + 3 * i) = E[i].transpose();
        C.set_column(i, per_finger, [&](Index j) -> SurfaceCompliance::Entry {
          const double distance = (point[i] - point[j]).norm() / kKernelWidth_m;
          return {scene.compliance_m_per_N * std::exp(-0.5 * distance * distance), 0.0, 0.0};
        });
      }
    }
  }
  Vector6d mobility;
  mobility << Vector3d::Constant(1.0), Vector3d::Constant(1.0 / kRotation_m2);
  if (factors != nullptr) {
    factors->own_mobility = scene.step_s / scene.joint_viscosity[0];
    factors->common_mobility.head<6>() = scene.step_s / scene.object_viscosity * mobility;
    factors->J_common.setZero(3 * n, GroupedDelassus::kPadded);
    factors->J_common.leftCols<6>() = J_object;
  }
  problem.W += scene.step_s / scene.object_viscosity * J_object * mobility.asDiagonal() * J_object.transpose();
  problem.W = 0.5 * (problem.W + problem.W.transpose()).eval();
  return problem;
}

/// A rigid body between fixed, rigid surfaces that press along the columns `normal` at the columns `point`, pushed by a
/// wrench about the origin. W is compliance I plus a matrix of rank 6.
inline ContactData rigid_body(const Eigen::Matrix3Xd& point, const Eigen::Matrix3Xd& normal, double gap_m,
                              double compliance_m_per_N, double mu, const Vector6d& wrench) {
  const Index n = point.cols();
  MatrixXd J(3 * n, 6);
  for (Index i = 0; i < n; ++i) J.middleRows<3>(3 * i) = body_rows(axes(normal.col(i)), point.col(i));
  Vector6d mobility;  // 5 ms over 20 N s/m, 0.0125 N m s
  mobility << Vector3d::Constant(2.5e-4), Vector3d::Constant(0.4);
  ContactData problem{J * mobility.asDiagonal() * J.transpose(), J * mobility.cwiseProduct(wrench),
                      VectorXd::Constant(n, mu)};
  problem.W = 0.5 * (problem.W + problem.W.transpose()).eval();
  problem.W.diagonal().array() += compliance_m_per_N;
  for (Index i = 0; i < n; ++i) problem.delta_free[3 * i] += gap_m;
  return problem;
}

/// Curved pulps: of the candidates, those in the middle carry force.
inline ContactData curved(Random& random) {
  GraspScene scene;
  scene.per_finger = random.whole(1, 20);
  scene.step_s = random.chance(0.5) ? 5e-3 : 1e-3;
  scene.depth_m = random.uniform(0.2e-3, 2e-3);
  scene.slip_m = random.uniform(0.0, 1e-3);
  scene.bumpiness = random.chance(0.5) ? 0.0 : random.uniform(0.0, 0.3);
  ContactData problem = grasp(scene, random);
  problem.mu.setConstant(random.uniform(0.2, 1.2));
  return problem;
}

/// Flattened pulps: nearly all contacts carry force.
inline GraspScene flat(Random& random) {
  GraspScene scene;
  scene.per_finger = random.whole(2, 20);
  scene.pulp_radius_m = random.power_of_ten(-1.3, 3.0);
  scene.depth_m = 2e-3;
  scene.slip_m = random.uniform(0.05e-3, 0.6e-3);
  return scene;
}

inline ContactData pressed(Random& random) {
  ContactData problem = grasp(flat(random), random);
  problem.mu.setConstant(random.uniform(0.3, 1.2));
  return problem;
}

/// Compliance down to none, where forces are no longer unique.
inline ContactData stiff(Random& random) {
  GraspScene scene = flat(random);
  scene.compliance_m_per_N = random.chance(0.25) ? 0.0 : 2e-4 * random.power_of_ten(-8.0, 0.0);
  scene.slip_m = random.uniform(0.05e-3, 0.4e-3);
  if (random.chance(0.5)) scene.bumpiness = 0.1;
  ContactData problem = grasp(scene, random);
  problem.mu.setConstant(random.uniform(0.3, 1.0));
  return problem;
}

/// Bodies whose viscosities differ by up to 10^4.
inline ContactData ratio(Random& random) {
  GraspScene scene = flat(random);
  scene.object_viscosity *= random.power_of_ten(-2.0, 2.0);
  for (double& viscosity : scene.joint_viscosity) viscosity *= random.power_of_ten(-2.0, 2.0);
  scene.compliance_m_per_N *= random.power_of_ten(-2.0, 0.0);
  ContactData problem = grasp(scene, random);
  problem.mu.setConstant(random.uniform(0.3, 1.0));
  return problem;
}

/// Friction from none to 2, the same everywhere or another at each contact.
inline ContactData friction(Random& random) {
  GraspScene scene = flat(random);
  scene.slip_m = random.uniform(0.2e-3, 2e-3);
  scene.compliance_m_per_N *= random.power_of_ten(-1.0, 0.0);
  if (random.chance(0.5)) scene.bumpiness = 0.1;
  ContactData problem = grasp(scene, random);
  const bool mixed = random.chance(0.5);
  double mu = 0.0;
  for (Index i = 0; i < problem.contacts(); ++i) {
    // Exactly 0 where the clamp bites.
    if (i == 0 || mixed) mu = std::max(0.0, random.uniform(-0.3, 2.0));
    problem.mu[i] = mu;
  }
  return problem;
}

/// Every contact twice or four times.
inline ContactData duplicates(Random& random) {
  GraspScene scene = flat(random);
  scene.copies = random.chance(0.5) ? 2 : 4;
  scene.per_finger = random.whole(1, 20 / scene.copies);
  scene.compliance_m_per_N *= random.power_of_ten(-3.0, 0.0);
  ContactData problem = grasp(scene, random);
  problem.mu.setConstant(random.uniform(0.3, 1.0));
  return problem;
}

/// A body pushed down between two walls, half an angle each, that wedges where tan(angle) < mu.
inline ContactData wedge(Random& random) {
  const double angle = random.uniform(0.02, 0.5);
  const double roughness_m = random.chance(0.5) ? 1e-5 : 1e-3;
  constexpr std::array<double, 4> kAlong_m{-0.02, -0.007, 0.007, 0.02};
  constexpr std::array<double, 3> kUp_m{-0.02, 0.0, 0.02};
  Eigen::Matrix3Xd point(3, 24), normal(3, 24);
  Index i = 0;
  for (const double side : {-1.0, 1.0}) {
    for (const double y : kAlong_m) {
      for (const double z : kUp_m) {
        point.col(i) = Vector3d(side * (0.025 + std::tan(angle) * z), y, z) + roughness_m * random.normal3();
        normal.col(i++) = Vector3d(-side * std::cos(angle), 0.0, std::sin(angle));
      }
    }
  }
  const Vector3d force = Vector3d(0.0, 0.0, -20.0) + random.normal3().cwiseProduct(Vector3d(2.0, 1.0, 0.0));
  const Vector3d torque = random.normal3().cwiseProduct(Vector3d(0.05, 0.05, 0.02));
  Vector6d wrench;
  wrench.head<3>() = force;
  wrench.tail<3>() = torque;
  const double compliance = random.chance(1.0 / 3.0) ? 0.0 : random.power_of_ten(-8.0, -5.0);
  return rigid_body(point, normal, 0.0, compliance, random.uniform(0.1, 1.5), wrench);
}

/// A peg in a hole, with clearance or with interference; without compliance an interference fit has no solution.
inline ContactData peg(Random& random) {
  Eigen::Matrix3Xd point(3, 32), normal(3, 32);
  Index i = 0;
  for (const double z : {-0.015, -0.005, 0.005, 0.015}) {
    const double turn = random.uniform(0.0, 0.3);
    for (int k = 0; k < 8; ++k) {
      const double angle = turn + 0.25 * std::numbers::pi * k;
      point.col(i) = Vector3d(0.01 * std::cos(angle), 0.01 * std::sin(angle), z);
      normal.col(i++) = Vector3d(-std::cos(angle), -std::sin(angle), 0.0);
    }
  }
  const double gap_m = random.chance(0.5) ? random.power_of_ten(-6.0, -4.5) : -random.power_of_ten(-6.0, -4.5);
  const double compliance = random.chance(1.0 / 3.0) ? 0.0 : random.power_of_ten(-9.0, -6.0);
  const Vector3d force = Vector3d(0.0, 0.0, -15.0) + random.normal3().cwiseProduct(Vector3d(3.0, 3.0, 0.0));
  const Vector3d torque = Vector3d(0.4, 0.2, 0.05).cwiseProduct(random.normal3());
  Vector6d wrench;
  wrench.head<3>() = force;
  wrench.tail<3>() = torque;
  return rigid_body(point, normal, gap_m, compliance, random.uniform(0.1, 0.9), wrench);
}

/// A rigid box on a rigid plane: 4 to 64 contacts for 6 degrees of freedom.
inline ContactData box_on_plane(Random& random) {
  const Index side = random.whole(2, 8);
  Eigen::Matrix3Xd point(3, side * side);
  for (Index i = 0; i < side * side; ++i) {
    const auto at = [&](Index k) { return 0.04 * static_cast<double>(k) / static_cast<double>(side - 1) - 0.02; };
    point.col(i) = Vector3d(at(i / side), at(i % side), -0.015);
  }
  const Eigen::Matrix3Xd normal = Vector3d::UnitZ().replicate(1, side * side);
  const Vector3d force = Vector3d(0.0, 0.0, -5.0) + random.normal3().cwiseProduct(Vector3d(1.5, 1.5, 0.0));
  const Vector3d torque = random.normal3().cwiseProduct(Vector3d(0.03, 0.03, 0.05));
  Vector6d wrench;
  wrench.head<3>() = force;
  wrench.tail<3>() = torque;
  return rigid_body(point, normal, 0.0, 0.0, random.uniform(0.1, 1.0), wrench);
}

}  // namespace families

/// A family of random contact problems. The same seed makes the same problem.
struct ContactFamily {
  std::string_view name;
  ContactData (*from)(Random&);

  [[nodiscard]] ContactData make(std::uint64_t seed) const {
    Random random(seed);
    return from(random);
  }
};

/// What contact solvers are tried on: from the grasps they are made for to those that break them.
inline constexpr std::array<ContactFamily, 9> kContactFamilies{{
    {"grasp", families::curved},
    {"pressed", families::pressed},
    {"stiff", families::stiff},
    {"ratio", families::ratio},
    {"friction", families::friction},
    {"duplicates", families::duplicates},
    {"wedge", families::wedge},
    {"peg", families::peg},
    {"box_on_plane", families::box_on_plane},
}};

/// How a solver did on a family: what a table of families has in a row.
struct FamilyRecord {
  int problems = 0, solved = 0, no_solution = 0, unanswered = 0;
  double worst_residual = 0.0;                  ///< Of the solved ones.
  std::vector<std::uint64_t> unanswered_seeds;  ///< To look at them again.
  std::vector<double> times_us;                 ///< One a problem, as `solve` reports them.
};

/// What `solve` returns for a problem of a family.
struct FamilyAnswer {
  SolveReport report;
  double time_us = 0.0;
};

/// Runs solve(problem) -> FamilyAnswer on the problems of `count` seeds from `first_seed` on.
template <typename Solver>
FamilyRecord run_family(const ContactFamily& family, std::uint64_t first_seed, int count, const Solver& solve) {
  FamilyRecord record;
  for (std::uint64_t seed = first_seed; record.problems < count; ++seed) {
    const FamilyAnswer answer = solve(family.make(seed));
    ++record.problems;
    record.times_us.push_back(answer.time_us);
    if (answer.report.status == SolveStatus::kConverged) {
      ++record.solved;
      record.worst_residual = std::max(record.worst_residual, answer.report.residual);
    } else if (answer.report.status == SolveStatus::kNoSolution) {
      ++record.no_solution;
    } else {
      ++record.unanswered;
      record.unanswered_seeds.push_back(seed);
    }
  }
  return record;
}

}  // namespace thenar
