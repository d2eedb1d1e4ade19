#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "solvers/grasp_forces.h"
#include "tests/allocation_counter.h"
#include "tests/json_eigen.h"
#include "tests/nnls.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A grasp problem that owns its contacts.
struct Grasp {
  std::vector<GraspContact> contacts;
  Vector3d centre_m = Vector3d::Zero();
  Vector6d wrench = Vector6d::Zero();
  double friction = 0.5;
  double internal_force_N = 0.0;

  [[nodiscard]] Index n() const { return std::ssize(contacts); }
  [[nodiscard]] GraspProblem problem() const { return {contacts, centre_m, wrench, friction, internal_force_N}; }

  [[nodiscard]] MatrixXd G() const {
    MatrixXd G(6, 3 * n());
    grasp_map(contacts, centre_m, G);
    return G;
  }

  /// Eq. (10), written out here once more for the oracle.
  [[nodiscard]] MatrixXd A() const {
    MatrixXd A = MatrixXd::Zero(5 * n(), 3 * n());
    for (Index i = 0; i < n(); ++i) {
      const Matrix3d& frame = contacts[i].frame;
      for (int row = 0; row < 4; ++row) {
        A.block<1, 3>(5 * i + row, 3 * i) =
            (friction * frame.col(0) + (row % 2 == 0 ? -1.0 : 1.0) * frame.col(1 + row / 2)).transpose();
      }
      A.block<1, 3>(5 * i + 4, 3 * i) = frame.col(0).transpose();
    }
    return A;
  }

  /// The edges of all pyramids, one a column: the forces that the contacts can give are their non-negative
  /// combinations.
  [[nodiscard]] MatrixXd edges() const {
    MatrixXd E = MatrixXd::Zero(3 * n(), 4 * n());
    for (Index i = 0; i < n(); ++i) {
      for (int k = 0; k < 4; ++k) {
        const Vector3d edge(1.0, k / 2 == 0 ? friction : -friction, k % 2 == 0 ? friction : -friction);
        E.block<3, 1>(3 * i, 4 * i + k) = contacts[i].frame * edge;
      }
    }
    return E;
  }

  [[nodiscard]] VectorXd c() const {
    VectorXd c(3 * n());
    for (Index i = 0; i < n(); ++i) c.segment<3>(3 * i) = -internal_force_N * contacts[i].frame.col(0);
    return c;
  }
};

struct Solution {
  GraspReport report;
  VectorXd f;
};

Solution solve(const Grasp& grasp) {
  GraspWorkspace work;
  VectorXd f = VectorXd::Constant(3 * grasp.n(), std::numeric_limits<double>::quiet_NaN());
  const GraspReport report = solve_grasp_forces(grasp.problem(), work, f);
  return {report, f};
}

Vector3d random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

/// A right-handed frame whose first axis is n, turned about it at random.
Matrix3d frame_about(const Vector3d& n, std::mt19937& random) {
  Matrix3d frame;
  frame.col(0) = n.normalized();
  frame.col(1) = frame.col(0).cross(random_vector(random)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

/// Contacts on a ball of 3 cm with normals up to some 30 degrees off its radius, and a wrench of a few newtons.
Grasp random_grasp(Index contacts, std::mt19937& random) {
  Grasp grasp;
  grasp.centre_m = 0.05 * random_vector(random);
  for (Index i = 0; i < contacts; ++i) {
    const Vector3d outward = random_vector(random).normalized();
    const Vector3d inward = -outward + 0.3 * random_vector(random);
    grasp.contacts.push_back({0.03 * outward, frame_about(inward, random)});
  }
  grasp.wrench.head<3>() = random_vector(random);
  grasp.wrench.tail<3>() = 0.01 * random_vector(random);
  std::uniform_real_distribution<double> uniform;
  grasp.friction = 0.2 + 0.8 * uniform(random);
  grasp.internal_force_N = 3.0 * uniform(random);
  return grasp;
}

Grasp recorded_grasp(const nlohmann::json& problem) {
  Grasp grasp;
  for (Index i = 0; i < problem.at("n_contacts"); ++i) {
    GraspContact contact;
    contact.point_m = vector_of(problem.at("contact_points")[i]);
    contact.frame << vector_of(problem.at("normals_inward")[i]), vector_of(problem.at("tangent_u")[i]),
        vector_of(problem.at("tangent_v")[i]);
    grasp.contacts.push_back(contact);
  }
  grasp.wrench = vector_of(problem.at("W"));
  grasp.friction = problem.at("mu");
  grasp.internal_force_N = problem.at("lambda");
  return grasp;
}

Grasp hand_grasp(const nlohmann::json& hand) {
  Grasp grasp;
  for (int i = 0; i < 3; ++i) {
    grasp.contacts.push_back({vector_of(hand.at("contact_points")[i]), matrix_of(hand.at("B")[i])});
  }
  grasp.centre_m = vector_of(hand.at("object_centre"));
  return grasp;
}

/// Karush-Kuhn-Tucker: G f = W, A f >= 0, and f + c balanced by multipliers of the rows without slack.
/// Forces are a few newtons to some tens (near the border of feasibility), rows of A and G of order 1, a dozen pivots
/// amplify rounding by less than 1e4: 1e-10 of the forces' size. A row counts as tight below 1e-8; a wrong set of tight
/// rows leaves errors of the forces' own size.
void expect_optimal(const Grasp& grasp, const VectorXd& f) {
  const double size_N = 1.0 + f.norm();
  const MatrixXd A = grasp.A();
  const VectorXd slack = A * f;
  EXPECT_LE((grasp.G() * f - grasp.wrench).cwiseAbs().maxCoeff(), 1e-12 * size_N);
  EXPECT_GE(slack.minCoeff(), -1e-10 * size_N);
  std::vector<Index> tight;
  for (Index row = 0; row < slack.size(); ++row) {
    if (slack[row] < 1e-8 * size_N) tight.push_back(row);
  }
  EXPECT_LE(stationarity_error(f + grasp.c(), grasp.G(), A(tight, Eigen::all)), 1e-7 * size_N);
}

/// The least length of W - G f over f inside the pyramids; torques in newtons at 3 cm.
double wrench_out_of_reach(const Grasp& grasp) {
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 30.0, 30.0, 30.0;
  return distance_from_cone(scale.asDiagonal() * grasp.G() * grasp.edges(), scale.asDiagonal() * grasp.wrench);
}

TEST(GraspForces, AgreeWithTheRecordedOptima) {
  for (const auto& problem : recorded_small_problems("P1")) {
    SCOPED_TRACE(problem.at("file"));
    const Grasp grasp = recorded_grasp(problem);
    EXPECT_LE((grasp.G() - matrix_of(problem.at("G"))).cwiseAbs().maxCoeff(), 1e-15);
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
  EXPECT_LE((grasp.G() - matrix_of(hand.at("G"))).cwiseAbs().maxCoeff(), 1e-16);
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
    if (solution.report.status == GraspStatus::kOptimal) {
      expect_optimal(grasp, solution.f);
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
    if (solution.report.status == GraspStatus::kOptimal) expect_optimal(grasp, solution.f);
  }
}

// Faces of a thin pyramid nearly coincide: multipliers grow like 1/mu^2 and the digits go. No answer is then an answer,
// a wrong one is not: what is called optimal keeps all laws to 1e-7 of the forces.
TEST(GraspForces, LittleFrictionGivesNoWrongAnswer) {
  int optimal = 0;
  int unanswered = 0;
  for (unsigned seed = 0; seed < 900; ++seed) {
    SCOPED_TRACE(seed);
    const Grasp grasp = degenerate_grasp(seed, std::array{0.03, 0.01, 0.001}[seed % 3]);
    const Solution solution = solve(grasp);
    if (solution.report.status == GraspStatus::kInfeasible) {
      EXPECT_GE(wrench_out_of_reach(grasp), 1e-9);
    } else if (solution.report.status == GraspStatus::kOptimal) {
      ++optimal;
      const double size_N = solution.f.norm();
      EXPECT_LE((grasp.G() * solution.f - grasp.wrench).cwiseAbs().maxCoeff(), 1e-7 * size_N);
      EXPECT_GE((grasp.A() * solution.f).minCoeff(), -1e-7 * size_N);
    } else {
      ++unanswered;
    }
  }
  EXPECT_LT(unanswered, optimal / 2);
}

// Pairs and contacts on a line cannot turn the object about that line: rank G = 5.
TEST(GraspForces, ContactsOnALineRefuseATorqueAboutItAndHoldTheRest) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp grasp;
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
    grasp.wrench = grasp.G() * inside;
    const Solution solution = solve(grasp);
    ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
    expect_optimal(grasp, solution.f);

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

/// Three fingers on two faces of a box of 5 cm, as the hand holds it; x across the box.
Grasp box_grasp(double friction) {
  Grasp grasp;
  const Matrix3d along = Matrix3d::Identity();
  Matrix3d against;
  against << -Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitZ();
  grasp.contacts = {{{-0.025, 0.0, 0.0}, along}, {{0.025, 0.01, 0.0}, against}, {{0.025, -0.01, 0.0}, against}};
  grasp.friction = friction;
  return grasp;
}

TEST(GraspForces, WithoutFrictionALateralLoadIsInfeasible) {
  Grasp grasp = box_grasp(0.0);
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);
  grasp.wrench[2] = 1.0;
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kInfeasible);
  grasp.friction = 0.3;
  const Solution solution = solve(grasp);
  ASSERT_EQ(solution.report.status, GraspStatus::kOptimal);
  expect_optimal(grasp, solution.f);
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
  grasp.wrench = grasp.G() * Vector3d(2.0, 0.7, -0.3);
  EXPECT_EQ(solve(grasp).report.status, GraspStatus::kOptimal);

  Grasp bad = box_grasp(0.5);
  bad.wrench[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(solve(bad).report.status, GraspStatus::kBudgetSpent);
  bad = box_grasp(0.5);
  bad.contacts[1].point_m[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(solve(bad).report.status, GraspStatus::kBudgetSpent);
}

// min 1/2 |e|^2 over G (f + e) = W, f = E z, z >= 0. Its optimum is e = G'l with E'e <= 0 and e.f = 0, and then
// |e|^2 = l.G e = l.W - e.f = e.(G^+ W).
TEST(InfeasibleGrasp, IsExplainedByTheLeastMissingForces) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Grasp grasp = random_grasp(3 + seed % 3, random);
    const bool feasible = solve(grasp).report.status == GraspStatus::kOptimal;
    infeasible += feasible ? 0 : 1;
    const GraspDeficit deficit = explain_infeasible_grasp(grasp.problem());
    VectorXd e(3 * grasp.n());
    for (Index i = 0; i < grasp.n(); ++i) e.segment<3>(3 * i) = grasp.contacts[i].frame * deficit.missing_N.col(i);

    const MatrixXd G = grasp.G();
    const MatrixXd G_pinv = G.completeOrthogonalDecomposition().pseudoInverse();
    // Forces of a few newtons through matrices of condition about 100.
    EXPECT_LE((e - G_pinv * (G * e)).norm(), 1e-10);
    EXPECT_LE((grasp.edges().transpose() * e).maxCoeff(), 1e-9);
    EXPECT_NEAR(e.squaredNorm(), e.dot(G_pinv * grasp.wrench), 1e-9);
    Grasp rest = grasp;
    rest.wrench -= G * e;
    EXPECT_LE(wrench_out_of_reach(rest), 1e-9);
    EXPECT_EQ(e.norm() < 1e-9, feasible);
  }
  EXPECT_GT(infeasible, 20);
}

TEST(InfeasibleGrasp, LeastFrictionIsTheBorderOfFeasibility) {
  Grasp grasp = box_grasp(0.01);
  // The thumb at the left carries as much as the two fingers at the right: any friction holds the load by itself.
  grasp.wrench << 0.0, 0.0, 1.0, 0.0, 0.0, 0.0;
  EXPECT_NEAR(explain_infeasible_grasp(grasp.problem()).least_friction, 0.0, 1e-3);

  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Grasp other = random_grasp(3, random);
    const double least = explain_infeasible_grasp(other.problem()).least_friction;
    if (least == 0.0) continue;
    if (std::isfinite(least)) {
      other.friction = least + 1e-6;
      EXPECT_EQ(solve(other).report.status, GraspStatus::kOptimal);
      other.friction = least - 1e-3;
    } else {
      other.friction = 10.0;
    }
    if (other.friction >= 0.0) {
      EXPECT_EQ(solve(other).report.status, GraspStatus::kInfeasible);
    }
  }
}

TEST(GraspForces, DoNotAllocate) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours";
  GraspWorkspace work;
  for (const Index n : {2, 3, 8}) {
    std::mt19937 random(3);
    const Grasp grasp = random_grasp(n, random);
    const GraspProblem problem = grasp.problem();
    VectorXd f(3 * n);
    const AllocationCounter counter;
    const GraspReport report = solve_grasp_forces(problem, work, f);
    EXPECT_EQ(counter.count(), 0);
    EXPECT_NE(report.status, GraspStatus::kBudgetSpent);
  }
}

}  // namespace
}  // namespace thenar
