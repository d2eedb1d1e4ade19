#include "solvers/grasp_forces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/support/algebra.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/grasp_problems.h"

namespace thenar::grasp_forces_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// c of eq. (15).
VectorXd bias_of(const Grasp& grasp) {
  VectorXd c(3 * grasp.n());
  for (Index i = 0; i < grasp.n(); ++i) c.segment<3>(3 * i) = -grasp.internal_force_N * grasp.contacts[i].frame.col(0);
  return c;
}

struct Solution {
  GraspReport report;
  VectorXd f;
};

Solution solve(const Grasp& grasp) {
  VectorXd f = VectorXd::Constant(3 * grasp.n(), std::numeric_limits<double>::quiet_NaN());
  const GraspReport report = solve_grasp_forces(grasp.problem(FrictionCone::kPyramid), f);
  return {report, f};
}

Solution solve_by_lemke(const Grasp& grasp) {
  GraspWorkspace work;
  VectorXd f = VectorXd::Constant(3 * grasp.n(), std::numeric_limits<double>::quiet_NaN());
  const GraspReport report = solve_grasp_forces_by_lemke(grasp.problem(FrictionCone::kPyramid), work, f);
  return {report, f};
}

Grasp hand_grasp(const nlohmann::json& hand) {
  Grasp grasp;
  for (int i = 0; i < 3; ++i) {
    grasp.contacts.push_back({vector_of(hand.at("contact_points")[i]), matrix_of(hand.at("B")[i])});
  }
  grasp.centre_m = vector_of(hand.at("object_centre"));
  return grasp;
}

/// The point of the pyramid nearest to y (contact axes), by trying all its faces, edges and the tip: the projections on
/// them, of which the nearest inside the pyramid is it.
Vector3d nearest_in_pyramid(double mu, const Vector3d& y) {
  std::vector<MatrixXd> faces{MatrixXd(0, 3), MatrixXd::Identity(3, 3)};
  for (const double u : {-1.0, 1.0}) {
    faces.push_back(Eigen::RowVector3d(mu, u, 0.0));
    faces.push_back(Eigen::RowVector3d(mu, 0.0, u));
    for (const double v : {-1.0, 1.0}) faces.push_back((MatrixXd(2, 3) << mu, u, 0.0, mu, 0.0, v).finished());
  }
  Vector3d nearest = Vector3d::Zero();
  for (const MatrixXd& A : faces) {
    Vector3d point = y;
    if (A.rows() > 0) point -= pseudo_inverse(A) * (A * y);
    const bool inside = point.tail<2>().cwiseAbs().maxCoeff() <= mu * point[0] + 1e-14 * y.norm() && point[0] >= 0.0;
    if (inside && (point - y).norm() < (nearest - y).norm()) nearest = point;
  }
  return nearest;
}

/// Karush-Kuhn-Tucker with the multiplier that the solver gave: G f = W, and f_i = P_K(G_i'l - c_i). Forces are a few
/// newtons to some tens (near the border of feasibility), and a dozen changes on rows of order 1 amplify rounding by
/// less than 1e4: 1e-10 is on the safe side, and a wrong set of tight rows leaves errors of the forces' own size.
void expect_optimal(const Grasp& grasp, const Solution& solution, double tolerance = 1e-10) {
  const VectorXd& f = solution.f;
  const double size = f.norm() + bias_of(grasp).norm();
  const MatrixXd G = grasp_map(grasp);
  EXPECT_LE((G.topRows(3) * f - grasp.wrench.head<3>()).norm(), tolerance * size);
  EXPECT_LE((G.bottomRows(3) * f - grasp.wrench.tail<3>()).norm(), tolerance * size * G.bottomRows(3).norm());
  EXPECT_GE((pyramid_rows(grasp) * f).minCoeff(), -tolerance * size);
  const VectorXd pulled = G.transpose() * solution.report.multiplier - bias_of(grasp);
  EXPECT_LE(solution.report.residual, 1e-9 + 1e-11 * pulled.norm() / size);
  EXPECT_LE(grasp_kkt_error(grasp.problem(FrictionCone::kPyramid), solution.report.multiplier, f),
            std::max(1e-9, tolerance) + 1e-11 * pulled.norm() / size);
  // Cones so thin that forces must be far larger than the wrench: the multiplier is larger still, and distances from
  // it, which the trials below compare, round by more than they differ.
  if (pulled.norm() > 1e2 * size) return;
  for (Index i = 0; i < grasp.n(); ++i) {
    const Matrix3d& frame = grasp.contacts[i].frame;
    const Vector3d nearest = frame * nearest_in_pyramid(grasp.friction, frame.transpose() * pulled.segment<3>(3 * i));
    EXPECT_LE((f.segment<3>(3 * i) - nearest).norm(), tolerance * size);
  }
}

/// The twist that the solver gave moves with the wrench, and against every edge of every pyramid: any forces inside
/// them do no work on it where the wrench would have to.
void expect_infeasible(const Grasp& grasp, const Solution& solution, double tolerance = 1e-10) {
  const Vector6d& twist = solution.report.multiplier;
  const MatrixXd G = grasp_map(grasp);
  const VectorXd velocities = G.transpose() * twist;
  // What the velocities are the sums of.
  const double size = (G.cwiseAbs().transpose() * twist.cwiseAbs()).norm();
  EXPECT_GT(grasp.wrench.dot(twist), 0.0);
  EXPECT_LE((pyramid_edges(grasp).transpose() * velocities).maxCoeff(), tolerance * size);
  // Forces 1e8 times the least that would do without cones count as none.
  EXPECT_LE(solution.report.residual, 1e-8);
  EXPECT_LE(infeasibility_gap(grasp.problem(FrictionCone::kPyramid), twist), std::max(1e-8, tolerance));
  EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
}

/// Expects one of both answers, with its proof.
void expect_proved(const Grasp& grasp, const Solution& solution, double tolerance = 1e-10) {
  ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
  if (solution.report.status == GraspStatus::kOptimal) {
    expect_optimal(grasp, solution, tolerance);
  } else {
    expect_infeasible(grasp, solution, tolerance);
  }
}

TEST(GraspForces, AgreeWithTheRecordedOptima) {
  for (const auto& problem : recorded_small_problems("P1")) {
    SCOPED_TRACE(problem.at("file"));
    const Grasp grasp = recorded_grasp(problem);
    EXPECT_LE((grasp_map(grasp) - matrix_of(problem.at("G"))).cwiseAbs().maxCoeff(), 1e-15);
    const Solution solution = solve(grasp);
    if (problem.at("status") == "infeasible") {
      EXPECT_EQ(solution.report.status, GraspStatus::kInfeasible);
      EXPECT_TRUE(solution.f.hasNaN()) << "f must be left as it was";
      continue;
    }
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    // 1e-10 of the forces (up to 30 N), but for the contacts that stray 6e-7 of their distance from a line: there
    // rounding of the points (1e-16) is amplified by (1/6e-7) in the forces, and by a few more in the pivots.
    const double tolerance_N = problem.at("class") == "nearcollinear" ? 1e-6 : 1e-9;
    EXPECT_LE((solution.f - vector_of(problem.at("f_opt"))).cwiseAbs().maxCoeff(), tolerance_N);
  }
}

TEST(GraspForces, AgreeWithTheHandsReference) {
  const nlohmann::json hand = read_json(THENAR_TEST_DATA "/hand_reference.json");
  Grasp grasp = hand_grasp(hand);
  // The same products of the same numbers, to the last bit or two.
  EXPECT_LE((grasp_map(grasp) - matrix_of(hand.at("G"))).cwiseAbs().maxCoeff(), 1e-16);
  for (const auto& problem : hand.at("grasp")) {
    grasp.wrench = vector_of(problem.at("W"));
    grasp.friction = problem.at("mu");
    grasp.internal_force_N = problem.at("lam");
    const Solution solution = solve(grasp);
    if (problem.at("f").is_null()) {
      EXPECT_EQ(solution.report.status, GraspStatus::kInfeasible);
      continue;
    }
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    // Forces of a few newtons, a dozen pivots: see expect_optimal.
    EXPECT_LE((solution.f - vector_of(problem.at("f"))).cwiseAbs().maxCoeff(), 1e-10);
  }
}

// Every status is proved: an optimum by its multipliers, infeasibility by the distance of the wrench from the cone of
// wrenches that the pyramids can give.
TEST(GraspForces, EveryAnswerIsProved) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(3 + seed % 6, random);
    const Solution solution = solve(grasp);
    const double out_of_reach_N = wrench_out_of_reach(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    expect_proved(grasp, solution);
    if (solution.report.status == GraspStatus::kOptimal) {
      EXPECT_LE(out_of_reach_N, 1e-9);
    } else {
      ++infeasible;
      EXPECT_GE(out_of_reach_N, 1e-9);
    }
  }
  EXPECT_GT(infeasible, 50);
  EXPECT_LT(infeasible, 450);
}

/// Box corners and whole numbers: rows of A coincide, ratios tie, optima lie on many rows at once.
Grasp degenerate_grasp(unsigned seed, double friction) {
  std::mt19937 random(seed);
  const auto whole = [&] { return static_cast<double>(random() % 3) - 1.0; };
  Grasp grasp;
  for (unsigned i = 0; i < 2 + seed % 5; ++i) {
    const Index face = random() % 3;
    const double side = random() % 2 == 0 ? 1.0 : -1.0;
    Vector3d point(0.02 * whole(), 0.02 * whole(), 0.02 * whole());
    point[face] = 0.02 * side;
    Matrix3d frame;
    frame << -side * Vector3d::Unit(face), Vector3d::Unit((face + 1) % 3), -side * Vector3d::Unit((face + 2) % 3);
    grasp.contacts.push_back({point, frame});
  }
  grasp.wrench << whole(), whole(), whole(), 0.02 * whole(), 0.02 * whole(), 0.02 * whole();
  grasp.friction = friction;
  grasp.internal_force_N = static_cast<double>(seed % 2);
  return grasp;
}

TEST(GraspForces, EveryAnswerIsProvedOnDegenerateGrasps) {
  for (unsigned seed = 0; seed < 900; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, std::array{1.0, 0.5, 0.1}[seed % 3]);
    const Solution solution = solve(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    EXPECT_EQ(solution.report.status == GraspStatus::kOptimal, wrench_out_of_reach(grasp) < 1e-9);
    expect_proved(grasp, solution);
  }
}

// Faces of a thin pyramid nearly coincide: multipliers grow like 1/mu^2 and the digits go, with Lemke's method at once,
// with the active set on a few problems at 1e-6. No answer is then an answer, a wrong one is not.
TEST(GraspForces, LittleFriction) {
  int optimal = 0;
  int unanswered = 0;
  int unanswered_by_lemke = 0;
  for (unsigned seed = 0; seed < 900; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, std::array{0.03, 1e-3, 1e-6}[seed % 3]);
    const Solution solution = solve(grasp);
    const Solution by_lemke = solve_by_lemke(grasp);
    if (by_lemke.report.status == GraspStatus::kBudgetSpent) ++unanswered_by_lemke;
    if (solution.report.status == GraspStatus::kBudgetSpent) {
      ++unanswered;
      continue;
    }
    expect_proved(grasp, solution, std::max(1e-9, 1e-13 / grasp.friction));
    optimal += solution.report.status == GraspStatus::kOptimal ? 1 : 0;
    if (by_lemke.report.status != GraspStatus::kBudgetSpent) {
      EXPECT_EQ(by_lemke.report.status, solution.report.status);
    }
  }
  EXPECT_GT(optimal, 100);
  EXPECT_LT(unanswered_by_lemke, optimal);
  // Of 300 at a friction of 1e-6; which of them, rounding decides.
  EXPECT_LT(unanswered, 25);
}

// Two methods that have no step in common. Lemke's method loses digits where forces are large, near the border of
// feasibility: 1e-9 of the forces while they are below 100 N, for wrenches of a few. Beyond 10 kN the border is so near
// that forces follow the rounding of the contacts themselves.
TEST(GraspForces, LemkesMethodAgreesWithTheActiveSet) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 10000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(2 + seed % 7, random);
    const Solution solution = solve(grasp);
    const Solution by_lemke = solve_by_lemke(grasp);
    ASSERT_NE(solution.report.status, GraspStatus::kBudgetSpent);
    ASSERT_EQ(by_lemke.report.status, solution.report.status);
    if (solution.report.status == GraspStatus::kOptimal) {
      const double size_N = solution.f.norm();
      EXPECT_LE((by_lemke.f - solution.f).norm(), (size_N < 100.0 ? 1e-9 : std::max(1e-6, 1e-10 * size_N)) * size_N);
    } else {
      ++infeasible;
      expect_infeasible(grasp, by_lemke, 1e-9);
    }
  }
  EXPECT_GT(infeasible, 1000);
  EXPECT_LT(infeasible, 9000);
}

/// Forces inside the pyramids that need not be the optimum, and the wrench they give: so the grasp is feasible.
Grasp held(Grasp grasp, const VectorXd& f_inside) {
  grasp.wrench = grasp_map(grasp) * f_inside;
  return grasp;
}

/// For each contact a force n + t1 friction a + t2 friction b with a, b drawn from [-edge, edge].
VectorXd forces_inside(const Grasp& grasp, double edge, std::mt19937& random) {
  std::uniform_real_distribution<double> share(-edge, edge);
  std::uniform_real_distribution<double> normal_N(0.5, 3.0);
  VectorXd f(3 * grasp.n());
  for (Index i = 0; i < grasp.n(); ++i) {
    f.segment<3>(3 * i) = normal_N(random) * (grasp.contacts[i].frame * Vector3d(1.0, grasp.friction * share(random),
                                                                                 grasp.friction * share(random)));
  }
  return f;
}

TEST(GraspForces, FeasibleGraspsAreFoundSo) {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(2 + seed % 7, random);
    grasp.friction = std::array{0.5, 1e-2, 1e-6, 0.0}[seed % 4];
    grasp = held(grasp, forces_inside(grasp, 0.9, random));
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    // Errors of 1e-13 on the faces are as much more along them as the pyramid is thin.
    expect_optimal(grasp, solution, grasp.friction > 0.0 ? std::max(1e-9, 1e-13 / grasp.friction) : 1e-9);
  }
}

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

// Without squeeze a wrench that forces on edges of the pyramids give has an optimum on many rows at once, often at the
// tip of a pyramid.
TEST(GraspForces, OptimaOnEdgesAndTips) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(3 + seed % 6, random);
    grasp.internal_force_N = 0.0;
    VectorXd f = VectorXd::Zero(3 * grasp.n());
    for (Index i = 0; i < 1 + seed % 3; ++i)
      f += static_cast<double>(i + 1) * pyramid_edges(grasp).middleCols<4>(4 * i).col(seed % 4);
    grasp = held(grasp, f);
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    expect_optimal(grasp, solution, 1e-9);
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

TEST(GraspForces, TheSameProblemGivesTheSameBits) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(2 + seed % 7, random);
    const Solution first = solve(grasp);
    std::ignore = solve(random_grasp(8, random));
    const Solution second = solve(grasp);
    EXPECT_EQ(first.report.multiplier, second.report.multiplier);
    EXPECT_EQ(first.report.residual, second.report.residual);
    if (first.report.status == GraspStatus::kOptimal) {
      EXPECT_EQ(first.f, second.f);
    }
  }
}

// The check sees what is wrong: forces that give another wrench, and forces that give this one but are not the best.
TEST(GraspForces, TheKktErrorIsThatOfTheForces) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(3, random);
    grasp = held(grasp, forces_inside(grasp, 0.9, random));
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    const GraspProblem problem = grasp.problem(FrictionCone::kPyramid);
    const auto error = [&](const VectorXd& f) { return grasp_kkt_error(problem, solution.report.multiplier, f); };
    const double size_N = std::max(solution.f.norm(), bias_of(grasp).norm());
    VectorXd off = solution.f;
    off[seed % 9] += 1e-3 * size_N;
    // The change is what differs from the projection; what it adds to |f| is 1e-3.
    EXPECT_NEAR(error(off), 1e-3, 2e-6);
    // Two contacts pressed together along the line through them: the wrench stays.
    VectorXd pressed = solution.f;
    const Vector3d along = (grasp.contacts[1].point_m - grasp.contacts[0].point_m).normalized();
    pressed.segment<3>(0) += 1e-3 * size_N * along;
    pressed.segment<3>(3) -= 1e-3 * size_N * along;
    EXPECT_NEAR(error(pressed), 1e-3 * std::sqrt(2.0), 4e-6);
    EXPECT_TRUE(std::isinf(infeasibility_gap(problem, -problem.wrench)));
    EXPECT_GT(infeasibility_gap(problem, problem.wrench), 1e-3);
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
      inside.segment<3>(3 * i) = grasp.contacts[i].frame * (Vector3d(3.0, 0.0, 0.0) + 0.2 * random_vector(random));
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
    for (GraspContact& contact : moved.contacts) contact = {R * contact.point_m + shift, R * contact.frame};
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

// f minimises 1/2 f'f - lambda N(f), N the sum of normal forces, over a set that lambda does not change. Adding the two
// statements of optimality for two lambdas gives (lambda_2 - lambda_1) (N_2 - N_1) >= 0.
TEST(GraspForces, MoreSqueezeMeansMoreNormalForce) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp = random_grasp(4, random);
    double last_N = 0.0;
    for (const double squeeze_N : {0.0, 0.5, 1.0, 2.0, 5.0}) {
      grasp.internal_force_N = squeeze_N;
      const Solution solution = solve(grasp);
      if (solution.report.status != GraspStatus::kOptimal) break;
      double normal_N = 0.0;
      for (Index i = 0; i < grasp.n(); ++i)
        normal_N += solution.f.segment<3>(3 * i).dot(grasp.contacts[i].frame.col(0));
      EXPECT_GE(normal_N, last_N - 1e-9 * (1.0 + normal_N));
      last_N = normal_N;
    }
  }
}

TEST(GraspForces, WithoutFrictionAWrenchOffTheNormalsIsInfeasible) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, 0.0);
    const Solution solution = solve(grasp);
    expect_proved(grasp, solution);
    EXPECT_EQ(solution.report.status == GraspStatus::kOptimal, wrench_out_of_reach(grasp) < 1e-9);
    const Solution by_lemke = solve_by_lemke(grasp);
    EXPECT_EQ(by_lemke.report.status, solution.report.status);
    std::mt19937 random(seed);
    Grasp off = grasp;
    off.wrench += 1e-3 * Vector6d::NullaryExpr([&] { return std::normal_distribution<double>()(random); });
    if (wrench_out_of_reach(off) < 1e-9) continue;
    const Solution infeasible = solve(off);
    ASSERT_EQ(infeasible.report.status, GraspStatus::kInfeasible);
    expect_infeasible(off, infeasible);
  }
}

TEST(GraspForces, WithoutFrictionALateralLoadIsInfeasible) {
  Grasp grasp = box_grasp(0.0);
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);
  grasp.wrench[2] = 1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);
  grasp.friction = 0.3;
  const Solution solution = solve(grasp);
  ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
  expect_optimal(grasp, solution);
}

// Two fingers face each other and hold a lateral load F: each carries F/2, which needs a normal force of F/(2 mu).
TEST(GraspForces, OfTwoFingersByHand) {
  Grasp grasp;
  Matrix3d against;
  against << -Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitZ();
  grasp.contacts = {{{-0.02, 0.0, 0.0}, Matrix3d::Identity()}, {{0.02, 0.0, 0.0}, against}};
  grasp.friction = 0.4;
  grasp.wrench[1] = 2.0;
  const Solution solution = solve(grasp);
  ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
  const VectorXd expected = (VectorXd(6) << 2.5, 1.0, 0.0, -2.5, 1.0, 0.0).finished();
  EXPECT_LE((solution.f - expected).cwiseAbs().maxCoeff(), 1e-14);

  // With a squeeze of lambda > F/(2 mu) the normal forces are lambda.
  grasp.internal_force_N = 4.0;
  EXPECT_NEAR(solve(grasp).f[0], 4.0, 1e-14);
}

TEST(GraspForces, SmallGraspsAndBadInput) {
  Grasp grasp;
  grasp.friction = 0.5;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);
  grasp.wrench[0] = 1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);
  grasp.contacts = {{Vector3d::Zero(), Matrix3d::Identity()}};
  const Solution push = solve(grasp);
  ASSERT_EQ(push.report.status, GraspStatus::kOptimal);
  EXPECT_LE((push.f - Vector3d::UnitX()).cwiseAbs().maxCoeff(), 1e-15);
  grasp.wrench[0] = -1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);

  // Torques about a far point round by more than the contacts' own torques are.
  grasp.centre_m = {0.3, -1.7, 2.9};
  grasp.wrench = grasp_map(grasp) * Vector3d(2.0, 0.7, -0.3);
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);

  Grasp bad = box_grasp(0.5);
  bad.wrench[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(bad).report.status, GraspStatus::kBudgetSpent);
  bad = box_grasp(0.5);
  bad.contacts[1].point_m[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(solve(bad).report.status, GraspStatus::kBudgetSpent);
}

TEST(GraspForces, DoNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  GraspWorkspace work;
  for (const Index n : {2, 3, 8}) {
    std::mt19937 random(3);
    const Grasp grasp = random_grasp(n, random);
    const GraspProblem problem = grasp.problem(FrictionCone::kPyramid);
    VectorXd f(3 * n);
    const AllocationCounter counter;
    const GraspReport report = solve_grasp_forces(problem, f);
    const GraspReport by_lemke = solve_grasp_forces_by_lemke(problem, work, f);
    EXPECT_EQ(counter.count(), 0);
    EXPECT_NE(report.status, GraspStatus::kBudgetSpent);
    EXPECT_EQ(by_lemke.status, report.status);
  }
}

}  // namespace
}  // namespace thenar::grasp_forces_test
