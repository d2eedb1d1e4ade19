// SPDX-License-Identifier: Apache-2.0
// Where contacts coincide or lie on a line, and other units, axes and points that torques are taken about: a reduced
// grasp is the same. By the forces that are found on it.

#include "solvers/reduced_grasp.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "solvers/grasp_forces.h"
#include "tests/solvers/grasp_answers.h"
#include "tests/support/grasp_problems.h"

namespace thenar::reduced_grasp_test {
namespace {

using namespace grasp_answers;

// The same contact up to four times: rows of A coincide, and the multipliers are not unique.
TEST(GraspForces, RepeatedContacts) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(2 + seed % 3, random);
    const Index repeated = grasp.n();
    for (Index i = 0; i < repeated; ++i) grasp.contacts.push_back(grasp.contacts[i % (1 + seed % 2)]);
    if (seed % 3 == 0) grasp = held(grasp, forces_inside(grasp, 1.0, random));
    expect_proved(grasp, solve(grasp), 1e-9);
  }
}

// Where contacts stray from a line by a part s of their distances, rounding of the points is 1e-16/s of what they
// stray, and so are errors in what balances a torque about the line. Both answers occur: also a torque that needs large
// forces.
TEST(GraspForces, ContactsNearALine) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const double stray = std::pow(10.0, -1.0 - 8.0 * static_cast<double>(seed % 100) / 99.0);
    Grasp grasp = random_grasp(3 + seed % 3, random);
    const Vector3d along = random_vector(random).normalized();
    for (Index i = 0; i < grasp.n(); ++i) {
      grasp.contacts[i].point_m =
          0.03 * ((i % 2 == 0 ? 1.0 + static_cast<double>(i) : -static_cast<double>(i)) * along +
                  stray * random_vector(random));
    }
    if (seed % 3 != 0) grasp = held(grasp, forces_inside(grasp, 0.9, random));
    const Solution solution = solve(grasp);
    const double tolerance = std::max(1e-9, 5e-14 / stray);
    expect_proved(grasp, solution, tolerance);
    if (seed % 3 != 0) {
      EXPECT_EQ(solution.report.status, GraspStatus::kOptimal);
    }
    infeasible += solution.report.status == GraspStatus::kInfeasible ? 1 : 0;
  }
  EXPECT_GT(infeasible, 100);
}

// Other units change nothing. Powers of two: not even rounding does.
TEST(GraspForces, DoNotDependOnUnits) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = seed % 2 == 0 ? random_grasp(2 + seed % 7, random) : degenerate_grasp(seed, 0.5);
    for (const auto& [force, length] : {std::pair{20, 0}, {-20, 0}, {0, 20}, {0, -20}, {20, -20}}) {
      Grasp scaled = grasp;
      scaled.wrench.head<3>() *= std::ldexp(1.0, force);
      scaled.wrench.tail<3>() *= std::ldexp(1.0, force + length);
      scaled.internal_force_N *= std::ldexp(1.0, force);
      scaled.centre_m *= std::ldexp(1.0, length);
      for (GraspContact& contact : scaled.contacts) contact.point_m *= std::ldexp(1.0, length);
      for (const auto method : {solve, solve_by_lemke}) {
        const Solution solution = method(grasp);
        const Solution scaled_solution = method(scaled);
        ASSERT_EQ(scaled_solution.report.status, solution.report.status);
        EXPECT_EQ(scaled_solution.report.iterations, solution.report.iterations);
        if (solution.report.status == GraspStatus::kOptimal) {
          EXPECT_EQ(scaled_solution.f, std::ldexp(1.0, force) * solution.f);
        }
      }
    }
  }
}

// Pairs and contacts on a line cannot turn the object about that line: rank G = 5.
TEST(GraspForces, ContactsOnALineRefuseATorqueAboutItAndHoldTheRest) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp;
    grasp.friction = 0.5;
    const Vector3d along = random_vector(random).normalized();
    const Vector3d origin = 0.1 * random_vector(random);
    grasp.contacts.push_back({origin - 0.03 * along, frame_about(along, random)});
    grasp.contacts.push_back({origin + 0.03 * along, frame_about(-along, random)});
    if (seed % 2 == 0) grasp.contacts.push_back({origin + 0.01 * along, frame_about(-along, random)});
    // What forces well inside the pyramids give can be had.
    VectorXd inside(3 * grasp.n());
    for (Index i = 0; i < grasp.n(); ++i) {
      inside.segment<3>(3 * i) = grasp.contacts[i].axes * (Vector3d(3.0, 0.0, 0.0) + 0.2 * random_vector(random));
    }
    grasp.wrench = grasp_map(grasp) * inside;
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    expect_optimal(grasp, solution);

    grasp.wrench.tail<3>() += 1e-3 * along;
    EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);
  }
}

TEST(GraspForces, TurnWithTheWorld) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(3 + seed % 3, random);
    const Solution solution = solve(grasp);
    const Matrix3d R = random_rotation(random);
    const Vector3d shift = random_vector(random);
    Grasp moved = grasp;
    for (GraspContact& contact : moved.contacts) contact = {R * contact.point_m + shift, R * contact.axes};
    moved.centre_m = R * grasp.centre_m + shift;
    moved.wrench = (R * grasp.wrench.reshaped(3, 2)).reshaped();
    const Solution moved_solution = solve(moved);
    ASSERT_EQ(moved_solution.report.status, solution.report.status);
    // Near the border of feasibility forces are large, and their errors grow faster than they.
    if (solution.report.status != GraspStatus::kOptimal || solution.f.norm() > 50.0) continue;
    // A metre's shift of points on 3 cm costs two digits beside those of expect_optimal.
    const VectorXd turned = (R * solution.f.reshaped(3, grasp.n())).reshaped();
    EXPECT_LE((moved_solution.f - turned).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + turned.norm()));
  }
}

TEST(GraspForces, DoNotDependOnThePointThatTorquesAreTakenAbout) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(3, random);
    const Solution solution = solve(grasp);
    Grasp shifted = grasp;
    const Vector3d shift = 0.1 * random_vector(random);
    shifted.centre_m += shift;
    shifted.wrench.tail<3>() -= shift.cross(grasp.wrench.head<3>());
    const Solution shifted_solution = solve(shifted);
    ASSERT_EQ(shifted_solution.report.status, solution.report.status);
    if (solution.report.status != GraspStatus::kOptimal) continue;
    EXPECT_LE((shifted_solution.f - solution.f).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + solution.f.norm()));
  }
}

}  // namespace
}  // namespace thenar::reduced_grasp_test
