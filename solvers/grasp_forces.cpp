#include "solvers/grasp_forces.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Contacts that stray from a line by less than this part of their distances are on it. With exact arithmetic forces 1e8
// times the rest could still balance a torque about that line; in doubles little would be left of them.
constexpr double kCollinear = 1e-8;
// A torque about that line below this part of the torques at hand is rounding.
constexpr double kConsistent = 1e-9;

// Forces are trusted if they break no law by more than this part of their size, and cost no more than this part too
// much.
constexpr double kTrust = 1e-8;
constexpr double kTrustedGap = 1e-6;
// Forces this many times the least that would give the wrench without pyramids count as none.
constexpr double kOutOfReach = 1e6;

constexpr double kGreatestFriction = 10.0;
constexpr double kFrictionStep = 1e-3;

/// Forces at the contacts, one a column, world axes.
using Forces = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxGraspContacts>;

struct Wrench {
  Vector3d force;
  Vector3d torque;  ///< About the contacts' centroid.
};

/// G and its pseudo-inverse. About the centroid of the contacts GG' = diag(n I, J), J their inertia with unit masses.
struct GraspMap {
  Vector3d centroid;
  Forces arms;  ///< Contact points from the centroid.
  Matrix3d K;   ///< J^+ = K K': the axes of J over the roots of their moments, zero where the contacts have none.
  Matrix3d powerless;  ///< The axes without moment: no contact force gives a torque about them. Else zero.
};

/// The moment about the axis `a` through the centroid. By distances, not a'J a: for contacts nearly on the axis this
/// keeps the digits that the differences in J lose.
double moment_about(const Forces& arms, const Vector3d& a) {
  double sum = 0.0;
  for (Index i = 0; i < arms.cols(); ++i) sum += arms.col(i).cross(a).squaredNorm();
  return sum;
}

GraspMap make_grasp_map(std::span<const GraspContact> contacts) {
  GraspMap map;
  const Index n = std::ssize(contacts);
  map.centroid.setZero();
  for (const GraspContact& contact : contacts) map.centroid += contact.point_m / static_cast<double>(n);

  map.arms.resize(3, n);
  Matrix3d scatter = Matrix3d::Zero();
  double largest_m = 0.0;
  for (Index i = 0; i < n; ++i) {
    map.arms.col(i) = contacts[i].point_m - map.centroid;
    scatter.noalias() += map.arms.col(i) * map.arms.col(i).transpose();
    largest_m = std::max(largest_m, contacts[i].point_m.cwiseAbs().maxCoeff());
  }
  // The axes of J = tr(S) I - S are those of the scatter S.
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(scatter);
  // Contacts at one point differ by the rounding of their coordinates.
  const double rounding_m = 16.0 * std::numeric_limits<double>::epsilon() * largest_m;
  const double least_moment = std::max(kCollinear * kCollinear * scatter.trace(), rounding_m * rounding_m);

  map.K.setZero();
  map.powerless.setZero();
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = axes.eigenvectors().col(k);
    const double moment = moment_about(map.arms, axis);
    (moment > least_moment ? map.K : map.powerless).col(k) = moment > least_moment ? axis / std::sqrt(moment) : axis;
  }
  return map;
}

/// G f
Wrench wrench_of(const GraspMap& map, const Forces& f) {
  Wrench wrench{Vector3d::Zero(), Vector3d::Zero()};
  for (Index i = 0; i < f.cols(); ++i) {
    wrench.force += f.col(i);
    wrench.torque += map.arms.col(i).cross(f.col(i));
  }
  return wrench;
}

/// G^+ w: the least forces that give the wrench.
Forces least_forces(const GraspMap& map, const Wrench& w) {
  const Vector3d shared = w.force / static_cast<double>(map.arms.cols());
  const Vector3d turning = map.K * (map.K.transpose() * w.torque);
  Forces f(3, map.arms.cols());
  for (Index i = 0; i < f.cols(); ++i) f.col(i) = shared + turning.cross(map.arms.col(i));
  return f;
}

Wrench wrench_about_centroid(const GraspMap& map, const GraspProblem& problem) {
  const Vector3d force = problem.wrench.head<3>();
  const Vector3d torque = problem.wrench.tail<3>();
  return {force, torque - (map.centroid - problem.centre_m).cross(force)};
}

/// Whether forces of any size and direction at the contacts can give the wrench.
bool is_within_reach(const GraspMap& map, const GraspProblem& problem, const Wrench& w) {
  const double torque_scale =
      problem.wrench.tail<3>().norm() + (map.centroid - problem.centre_m).norm() * w.force.norm();
  return (map.powerless.transpose() * w.torque).cwiseAbs().maxCoeff() <= kConsistent * torque_scale;
}

/// The five rows of eq. (10) of one contact, world axes.
Eigen::Matrix<double, 5, 3> pyramid_rows(const Matrix3d& frame, double mu) {
  const auto n = frame.col(0).transpose();
  const auto u = frame.col(1).transpose();
  const auto v = frame.col(2).transpose();
  Eigen::Matrix<double, 5, 3> A;
  A << mu * n - u, mu * n + u, mu * n - v, mu * n + v, n;
  return A;
}

/// The four edges of one contact's pyramid as rows, world axes.
Eigen::Matrix<double, 4, 3> pyramid_edges(const Matrix3d& frame, double mu) {
  const auto n = frame.col(0).transpose();
  const auto u = mu * frame.col(1).transpose();
  const auto v = mu * frame.col(2).transpose();
  Eigen::Matrix<double, 4, 3> E;
  E << n + u + v, n + u - v, n - u + v, n - u - v;
  return E;
}

/// Rows N with N N' = A G^+ G A', for rows A of which the contact i owns `per_contact`.
void project_rows(const GraspMap& map, Index per_contact, GraspWorkspace& work) {
  const Index n = map.arms.cols();
  work.N.resize(work.A.rows(), 6);
  work.N.leftCols<3>() = work.A / std::sqrt(static_cast<double>(n));
  for (Index i = 0; i < n; ++i) {
    // (r x a)' K, for all rows a at once: a'(K x r).
    Matrix3d turned;
    for (int k = 0; k < 3; ++k) turned.col(k) = map.K.col(k).cross(map.arms.col(i));
    work.N.middleRows(i * per_contact, per_contact).rightCols<3>().noalias() =
        work.A.middleRows(i * per_contact, per_contact).lazyProduct(turned);
  }
}

/// A' z: the forces that multipliers z of the rows stand for.
Forces combine_rows(const GraspWorkspace& work, Index per_contact, Index contacts) {
  Forces f(3, contacts);
  for (Index i = 0; i < contacts; ++i) {
    f.col(i).noalias() =
        work.A.middleRows(i * per_contact, per_contact).transpose() * work.z.segment(i * per_contact, per_contact);
  }
  return f;
}

/// A f, row by row.
void multiply_rows(GraspWorkspace& work, Index per_contact, const Forces& f) {
  work.q.resize(work.A.rows());
  for (Index i = 0; i < f.cols(); ++i) {
    work.q.segment(i * per_contact, per_contact).noalias() = work.A.middleRows(i * per_contact, per_contact) * f.col(i);
  }
}

/// y + G^+ (w - G y): of the forces that give the wrench, those nearest y. This is pi y + G^+ w.
Forces nearest_forces(const GraspMap& map, const Wrench& w, const Forces& y) {
  const Wrench had = wrench_of(map, y);
  return y + least_forces(map, {w.force - had.force, w.torque - had.torque});
}

bool is_finite(const GraspProblem& problem) {
  bool finite = problem.wrench.allFinite() && problem.centre_m.allFinite() && std::isfinite(problem.friction) &&
                std::isfinite(problem.internal_force_N);
  for (const GraspContact& contact : problem.contacts) {
    finite = finite && contact.point_m.allFinite() && contact.frame.allFinite();
  }
  return finite;
}

/// The LCP's matrix: M = A pi A' = A A' - N N', with A A' in 5x5 blocks.
void assemble(const GraspMap& map, const GraspProblem& problem, GraspWorkspace& work) {
  const Index n = std::ssize(problem.contacts);
  work.A.resize(5 * n, 3);
  for (Index i = 0; i < n; ++i) {
    work.A.middleRows<5>(5 * i) = pyramid_rows(problem.contacts[i].frame, problem.friction);
  }
  project_rows(map, 5, work);
  work.M.resize(5 * n, 5 * n);
  work.M.noalias() = -work.N.lazyProduct(work.N.transpose());
  for (Index i = 0; i < n; ++i) {
    const auto A_i = work.A.middleRows<5>(5 * i);
    work.M.block<5, 5>(5 * i, 5 * i) += A_i * A_i.transpose();
  }
}

/// Whether the forces keep what the LCP promised: G f = W^d, A f >= 0 and no duality gap z.(A f). In a pyramid of
/// little friction opposite faces nearly coincide; z then grows like 1/mu^2, and takes the digits of f with it.
bool is_sound(const GraspMap& map, const Wrench& w, const Forces& f, GraspWorkspace& work) {
  const double size_N = f.norm();
  multiply_rows(work, 5, f);
  return (nearest_forces(map, w, f) - f).norm() <= kTrust * size_N && work.q.minCoeff() >= -kTrust * size_N &&
         std::abs(work.z.dot(work.q)) <= kTrustedGap * size_N * size_N;
}

/// Whether the ray z proves that no forces do. Feasible f has 0 <= z.(A f) = z.q + (pi A'z).f, so it is at least as
/// large as -z.q / |pi A'z|: with exact arithmetic infinite, in doubles to be far beyond what little friction can ask
/// for.
bool is_proof(const GraspMap& map, const Wrench& w, const GraspWorkspace& work) {
  const Forces y = combine_rows(work, 5, map.arms.cols());
  const double left = nearest_forces(map, {Vector3d::Zero(), Vector3d::Zero()}, y).norm();
  return -work.z.dot(work.q) >= kOutOfReach * left * least_forces(map, w).norm();
}

/// -c of eq. (14).
Forces squeeze(const GraspProblem& problem) {
  Forces minus_c(3, std::ssize(problem.contacts));
  for (Index i = 0; i < minus_c.cols(); ++i) {
    minus_c.col(i) = problem.internal_force_N * problem.contacts[i].frame.col(0);
  }
  return minus_c;
}

}  // namespace

GraspWorkspace::GraspWorkspace() : lcp(kMaxRows) {}

void grasp_map(std::span<const GraspContact> contacts, const Vector3d& centre_m, Eigen::Ref<Eigen::MatrixXd> G) {
  assert(G.rows() == 6 && G.cols() == 3 * std::ssize(contacts));
  for (Index i = 0; i < std::ssize(contacts); ++i) {
    const Vector3d r = contacts[i].point_m - centre_m;
    G.block<3, 3>(0, 3 * i).setIdentity();
    G.block<3, 3>(3, 3 * i) << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  }
}

GraspReport solve_grasp_forces(const GraspProblem& problem, GraspWorkspace& work,
                               Eigen::Ref<Eigen::VectorXd> f) noexcept {
  const Index n = std::ssize(problem.contacts);
  assert(n <= kMaxGraspContacts && f.size() == 3 * n);
  if (!is_finite(problem)) return {GraspStatus::kBudgetSpent, 0};
  if (n == 0) return {problem.wrench.isZero(0.0) ? GraspStatus::kOptimal : GraspStatus::kInfeasible, 0};

  const GraspMap map = make_grasp_map(problem.contacts);
  const Wrench w = wrench_about_centroid(map, problem);
  if (!is_within_reach(map, problem, w)) return {GraspStatus::kInfeasible, 0};

  assemble(map, problem, work);
  Forces y = squeeze(problem);
  multiply_rows(work, 5, nearest_forces(map, w, y));
  work.z.resize(5 * n);
  const LcpReport lcp = solve_lcp(work.M, work.q, usual_pivot_budget(5 * n), work.lcp, work.z);
  if (lcp.status == LcpStatus::kInfeasible && is_proof(map, w, work)) return {GraspStatus::kInfeasible, lcp.pivots};
  if (lcp.status != LcpStatus::kSolved) return {GraspStatus::kBudgetSpent, lcp.pivots};

  y += combine_rows(work, 5, n);
  const Forces found = nearest_forces(map, w, y);
  if (!is_sound(map, w, found, work)) return {GraspStatus::kBudgetSpent, lcp.pivots};
  f.reshaped(3, n) = found;
  return {GraspStatus::kOptimal, lcp.pivots};
}

namespace {

/// Least |e| over f = E' z inside the pyramids, z >= 0: with G e = W^d - G E' z an LCP in z, M = E G^+ G E',
/// q = -E G^+ W^d.
Forces missing_forces(const GraspProblem& problem) {
  const Index n = std::ssize(problem.contacts);
  const GraspMap map = make_grasp_map(problem.contacts);
  const Wrench w = wrench_about_centroid(map, problem);

  GraspWorkspace work;
  work.A.resize(4 * n, 3);
  for (Index i = 0; i < n; ++i) {
    work.A.middleRows<4>(4 * i) = pyramid_edges(problem.contacts[i].frame, problem.friction);
  }
  project_rows(map, 4, work);
  work.M = work.N * work.N.transpose();
  const Forces least = least_forces(map, w);
  multiply_rows(work, 4, -least);
  work.z.setZero(4 * n);
  // This least-squares problem always has a solution; should the budget be spent, z = 0 and the least forces are named.
  std::ignore = solve_lcp(work.M, work.q, usual_pivot_budget(4 * n), work.lcp, work.z);
  const Wrench had = wrench_of(map, combine_rows(work, 4, n));
  return least_forces(map, {w.force - had.force, w.torque - had.torque});
}

double least_friction(GraspProblem problem) {
  GraspWorkspace work;
  Eigen::VectorXd f(3 * std::ssize(problem.contacts));
  // Infeasibility is proved or not claimed; what stays without an answer, at little friction, is hard because it is
  // feasible.
  const auto is_feasible = [&](double mu) {
    problem.friction = mu;
    return solve_grasp_forces(problem, work, f).status != GraspStatus::kInfeasible;
  };
  if (is_feasible(0.0)) return 0.0;
  if (!is_feasible(kGreatestFriction)) return std::numeric_limits<double>::infinity();
  double low = 0.0;
  double high = kGreatestFriction;
  while (high - low > kFrictionStep) {
    const double middle = 0.5 * (low + high);
    (is_feasible(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

GraspDeficit explain_infeasible_grasp(const GraspProblem& problem) {
  GraspDeficit deficit;
  const Index n = std::ssize(problem.contacts);
  if (n > 0) {
    const Forces missing = missing_forces(problem);
    for (Index i = 0; i < n; ++i) deficit.missing_N.col(i) = problem.contacts[i].frame.transpose() * missing.col(i);
  }
  deficit.least_friction = least_friction(problem);
  return deficit;
}

}  // namespace thenar
