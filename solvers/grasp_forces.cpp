// SPDX-License-Identifier: Apache-2.0
#include "solvers/grasp_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "solvers/dual_active_set.h"
#include "solvers/exact_cone.h"
#include "solvers/orthogonal_rows.h"
#include "solvers/reduced_grasp.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Forces are an optimum if they keep all its conditions to this part of their size. Rounding leaves 1e-15, times 1/mu
// in thin cones; a wrong set of faces leaves parts of 1.
constexpr double kTrust = 1e-9;
// Relative rounding of a multiplier. Where cones are so thin that forces must be 1e5 and more times the least, it is as
// many times the forces, sums of face multipliers larger still, and the accuracy of the proof decreases with it.
constexpr double kMultiplierRounding = 1e-11;
// But no more than this part of the forces.
constexpr double kMostRounding = 1e-6;

/// An answer to a reduced problem, before it is checked.
template <int kLanes>
struct Answer {
  GraspStatus status = GraspStatus::kBudgetSpent;
  int iterations = 0;
  LaneForces<kLanes> f;
  /// Optimal: l of f = P_K(Q'l + bias). Infeasible: l.w > 0 and P_K(Q'l) = 0.
  std::array<double, 6> multiplier{};
};

/// Returns w - Q y, the change of y for which Q' y gives the wrench.
template <int kLanes>
std::array<double, 6> missing_wrench(const ReducedGrasp<kLanes>& grasp, const LaneForces<kLanes>& y) {
  std::array<double, 6> missing = reduced_wrench(grasp, y);
  for (int k = 0; k < 6; ++k) missing[k] = grasp.w[k] - missing[k];
  return missing;
}

double squared_norm(const std::array<double, 6>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x * x;
  return sum;
}

/// Completes an answer by its multiplier, from `push`, the wrench Q A'u that the faces of the pyramids give with u >=
/// 0, and `start`, what the bias lacks of w. An optimum is f = bias + Q'l + A'u with Q f = w; and infeasible is where
/// A'u = -Q'l, so that 0 <= u.(A f) = -l.w < 0. Then l has any length: 1.
template <int kLanes>
void find_multiplier(const std::array<double, 6>& start, const std::array<double, 6>& push, Answer<kLanes>& answer) {
  if (answer.status == GraspStatus::kOptimal) {
    for (int k = 0; k < 6; ++k) answer.multiplier[k] = start[k] - push[k];
  } else {
    const double over_length = -1.0 / std::sqrt(squared_norm(push));
    for (int k = 0; k < 6; ++k) answer.multiplier[k] = over_length * push[k];
  }
}

// ------------------------------------------------------------------------------------------- the dual active set

/// Faces of the pyramids as constraints. Face 0, 1: mu f_n -+ f_t1 >= 0; 2, 3: mu f_n -+ f_t2 >= 0; 4: f_n >= 0.
template <int kLanes>
struct Pyramids {
  const Lane<kLanes>& mu;

  [[nodiscard]] static int id(Index lane, int face) { return 5 * static_cast<int>(lane) + face; }

  /// Returns a of a face: f_n at `lane`, f_t1 and f_t2 behind by kLanes each.
  [[nodiscard]] Constraint<2> face(Index lane, int face, double slack) const {
    const int n = static_cast<int>(lane);
    if (face == 4) return {id(lane, face), slack, {n, n}, {1.0, 0.0}};
    const int t = n + (face < 2 ? kLanes : 2 * kLanes);
    return {id(lane, face), slack, {n, t}, {mu[lane], face % 2 == 0 ? -1.0 : 1.0}};
  }

  /// Finds the lane that holds the value. Selects without branches: they would be unpredictable.
  [[nodiscard]] static Index first_with(const Lane<kLanes>& lanes, double value) {
    const Lane<kLanes> lane = (lanes == value).select(Lane<kLanes>::LinSpaced(0, kLanes - 1), kLanes - 1);
    return static_cast<Index>(lane.minCoeff());
  }

  [[nodiscard]] Constraint<2> most_violated(const typename ActiveSet<3 * kLanes>::Vector& f, double tolerance) const {
    const auto f_n = f.template segment<kLanes>(0);
    const auto f_t1 = f.template segment<kLanes>(kLanes);
    const auto f_t2 = f.template segment<kLanes>(2 * kLanes);
    const Lane<kLanes> slack = mu * f_n - f_t1.abs().max(f_t2.abs());
    if (!(slack >= -tolerance).all()) {
      Index lane = 0;
      const double least = slack.minCoeff(&lane);
      const bool first = std::abs(f_t1[lane]) >= std::abs(f_t2[lane]);
      const double t = first ? f_t1[lane] : f_t2[lane];
      return face(lane, (first ? 0 : 2) + (t > 0.0 ? 0 : 1), least);
    }
    // The other faces imply this one, but for little or no friction.
    const double least = f_n.minCoeff();
    return face(first_with(f_n, least), 4, least);
  }
};

template <int kLanes>
Answer<kLanes> solve_pyramid(const ReducedGrasp<kLanes>& grasp) {
  ActiveSet<3 * kLanes> set;
  set.equalities = grasp.rank;
  for (int k = 0; k < grasp.rank; ++k) set.basis[k] = grasp.Q[k].reshaped();
  const Pyramids<kLanes> pyramids{grasp.cones.mu};
  Answer<kLanes> answer;
  const std::array<double, 6> start = missing_wrench(grasp, grasp.bias);
  answer.f = grasp.bias + combine(grasp, start);
  typename ActiveSet<3 * kLanes>::Vector f = answer.f.reshaped();
  const ActiveSetReport report = project(pyramids, set, f, grasp.bias.matrix().norm());
  answer.iterations = report.changes;
  if (report.status == ActiveSetStatus::kBudgetSpent) return answer;

  answer.status = report.status == ActiveSetStatus::kOptimal ? GraspStatus::kOptimal : GraspStatus::kInfeasible;
  answer.f = f.reshaped(kLanes, 3);
  std::array<double, 6> push{};
  for (int j = 0; j < set.active; ++j) {
    const Constraint<2> face = pyramids.face(set.id[j] / 5, set.id[j] % 5, 0.0);
    for (int i = 0; i < 2; ++i) {
      const double u_a = set.multiplier[j] * face.value[i];
      for (int k = 0; k < 6; ++k) push[k] += u_a * grasp.Q[k].data()[face.index[i]];
    }
  }
  find_multiplier(start, push, answer);
  return answer;
}

// ------------------------------------------------------------------------------------------- Lemke's method

/// Computes A y for forces y, eq. (10) with the rows of one kind together: row n face + i for contact i.
template <int kLanes>
void multiply_rows(const ReducedGrasp<kLanes>& grasp, const LaneForces<kLanes>& y, double* rows) {
  const Index n = grasp.contacts;
  for (Index i = 0; i < n; ++i) {
    const double bound = grasp.cones.mu[i] * y(i, 0);
    rows[i] = bound - y(i, 1);
    rows[n + i] = bound + y(i, 1);
    rows[2 * n + i] = bound - y(i, 2);
    rows[3 * n + i] = bound + y(i, 2);
    rows[4 * n + i] = y(i, 0);
  }
}

/// Returns A'z.
template <int kLanes>
LaneForces<kLanes> combine_rows(const ReducedGrasp<kLanes>& grasp, const GraspWorkspace::RowVector& z) {
  const Index n = grasp.contacts;
  LaneForces<kLanes> f = LaneForces<kLanes>::Zero();
  for (Index i = 0; i < n; ++i) {
    f(i, 0) = grasp.cones.mu[i] * (z[i] + z[n + i] + z[2 * n + i] + z[3 * n + i]) + z[4 * n + i];
    f(i, 1) = z[n + i] - z[i];
    f(i, 2) = z[3 * n + i] - z[2 * n + i];
  }
  return f;
}

/// Assembles the LCP of eq. (19) in contact axes: M = A pi A' = A A' - N N' with N = A Q', and q = A f for the forces f
/// that give the wrench nearest to -c.
template <int kLanes>
void assemble(const ReducedGrasp<kLanes>& grasp, const LaneForces<kLanes>& start, GraspWorkspace& work) {
  // Columns of whole blocks have no remainder; what lies behind row 5n is not used.
  using Block = Eigen::Array<double, 8, 1>;
  const Index n = grasp.contacts;
  const Index length = (5 * n + 7) / 8 * 8;
  for (int k = 0; k < 6; ++k) multiply_rows(grasp, grasp.Q[k], work.N.col(k).data());
  work.M.resize(length, 5 * n);
  for (Index j = 0; j < 5 * n; ++j) {
    for (Index i = 0; i < length; i += 8) {
      Block sum = -work.N(j, 0) * work.N.col(0).segment<8>(i).array();
      for (int k = 1; k < 6; ++k) sum -= work.N(j, k) * work.N.col(k).segment<8>(i).array();
      work.M.col(j).segment<8>(i) = sum;
    }
  }
  // A A' couples the rows of one contact alone: by mu^2 from the normals, and 1 or -1 from one tangent.
  const Lane<kLanes>& mu = grasp.cones.mu;
  const std::array<Lane<kLanes>, 3> products{Lane<kLanes>::Ones(), mu, mu * mu};
  for (int a = 0; a < 5; ++a) {
    for (int b = 0; b < 5; ++b) {
      const Lane<kLanes>& normals = products[(a < 4 ? 1 : 0) + (b < 4 ? 1 : 0)];
      const double tangents = a == 4 || b == 4 || a / 2 != b / 2 ? 0.0 : a == b ? 1.0 : -1.0;
      for (Index i = 0; i < n; ++i) work.M(a * n + i, b * n + i) += normals[i] + tangents;
    }
  }
  work.q.resize(5 * n);
  multiply_rows(grasp, start, work.q.data());
}

template <int kLanes>
Answer<kLanes> solve_lemke(const ReducedGrasp<kLanes>& grasp, GraspWorkspace& work) {
  Answer<kLanes> answer;
  const std::array<double, 6> start = missing_wrench(grasp, grasp.bias);
  assemble<kLanes>(grasp, grasp.bias + combine(grasp, start), work);
  work.z.resize(work.q.size());
  const LcpReport lcp =
      solve_lcp({work.M.topRows(work.q.size()), work.q}, usual_pivot_budget(work.q.size()), work.lcp, work.z);
  answer.iterations = lcp.pivots;
  if (lcp.status == LcpStatus::kBudgetSpent) return answer;

  answer.status = lcp.status == LcpStatus::kSolved ? GraspStatus::kOptimal : GraspStatus::kInfeasible;
  const LaneForces<kLanes> push = combine_rows(grasp, work.z);
  // f = pi (A'z - c) + G^+ W^d
  const LaneForces<kLanes> pushed = grasp.bias + push;
  answer.f = pushed + combine(grasp, missing_wrench(grasp, pushed));
  find_multiplier(start, reduced_wrench(grasp, push), answer);
  return answer;
}

// ------------------------------------------------------------------------------------------- what all answers go
// through

template <int kLanes>
LaneForces<kLanes> nearest_inside(FrictionCone cone, const Cones<kLanes>& cones, const LaneForces<kLanes>& f) {
  return cone == FrictionCone::kPyramid ? nearest_in_pyramids(cones, f) : nearest_in_cones(cones, f);
}

/// Returns the force nearest to f that contact i allows, world axes.
Vector3d nearest_inside(const GraspProblem& problem, Index i, const Vector3d& f) {
  const Matrix3d& frame = problem.contacts[i].axes;
  const Cones<1> cones(Lane<1>::Constant(problem.friction_of(i)));
  LaneForces<1> lane = (frame.transpose() * f).transpose().array();
  lane = nearest_inside<1>(problem.cone, cones, lane);
  return frame * lane.matrix().transpose();
}

/// Returns the work of unit forces at a contact on a twist.
Vector3d velocity(const GraspProblem& problem, const Vector6d& twist, Index i) {
  return twist.head<3>() + twist.tail<3>().cross(problem.contacts[i].point_m - problem.centre_m);
}

/// Returns |P_K(G'l)|.
double allowed_forces(const GraspProblem& problem, const Vector6d& twist) {
  double squares = 0.0;
  for (Index i = 0; i < std::ssize(problem.contacts); ++i) {
    squares += nearest_inside(problem, i, velocity(problem, twist, i)).squaredNorm();
  }
  return std::sqrt(squares);
}

/// Returns |f - P_K(Q'l + bias)|^2.
template <int kLanes>
double squared_distance_from_projection(const ReducedGrasp<kLanes>& grasp, FrictionCone cone,
                                        const Answer<kLanes>& answer) {
  const LaneForces<kLanes> pulled = grasp.bias + combine(grasp, answer.multiplier);
  return (answer.f - nearest_inside<kLanes>(cone, grasp.cones, pulled)).square().sum();
}

/// Returns the squared scale of errors in forces.
template <int kLanes>
double squared_size_of(const ReducedGrasp<kLanes>& grasp, const LaneForces<kLanes>& f) {
  return std::max(f.square().sum(), grasp.bias.square().sum());
}

/// Returns the grasp_kkt_error of a reduced problem.
template <int kLanes>
double kkt_error(const ReducedGrasp<kLanes>& grasp, FrictionCone cone, const Answer<kLanes>& answer) {
  const double error =
      std::max(squared_distance_from_projection(grasp, cone, answer), squared_norm(missing_wrench(grasp, answer.f)));
  return error == 0.0 ? 0.0 : std::sqrt(error / squared_size_of(grasp, answer.f));
}

/// Tests whether forces satisfy the laws, and are the least as far as the rounding of their multiplier allows a proof.
template <int kLanes>
bool is_optimal_to_rounding(const ReducedGrasp<kLanes>& grasp, FrictionCone cone, const Answer<kLanes>& answer) {
  const double trust = kTrust * std::sqrt(squared_size_of(grasp, answer.f));
  const double rounding = kMultiplierRounding * std::sqrt(squared_norm(answer.multiplier));
  const double trust_in_proof = trust + std::min(rounding, kMostRounding * std::sqrt(squared_size_of(grasp, answer.f)));
  const LaneForces<kLanes> inside = nearest_inside<kLanes>(cone, grasp.cones, answer.f);
  return squared_norm(missing_wrench(grasp, answer.f)) <= trust * trust &&
         (answer.f - inside).square().sum() <= trust * trust &&
         squared_distance_from_projection(grasp, cone, answer) <= trust_in_proof * trust_in_proof;
}

/// Returns the infeasibility_gap of a reduced problem.
template <int kLanes>
double gap_left(const ReducedGrasp<kLanes>& grasp, FrictionCone cone, const std::array<double, 6>& multiplier) {
  double power = 0.0;
  for (int k = 0; k < 6; ++k) power += multiplier[k] * grasp.w[k];
  if (!(power > 0.0)) return std::numeric_limits<double>::infinity();
  const LaneForces<kLanes> pulled = combine(grasp, multiplier);
  const LaneForces<kLanes> allowed = nearest_inside<kLanes>(cone, grasp.cones, pulled);
  // Rounding of it counts, too: at the border the work is no larger than that.
  const double hidden = std::numeric_limits<double>::epsilon() * std::sqrt(pulled.square().sum());
  return std::sqrt(squared_norm(grasp.w)) * (std::sqrt(allowed.square().sum()) + hidden) / power;
}

/// Checks an answer; returns a proved one.
template <int kLanes>
GraspReport hand_out(const ReducedGrasp<kLanes>& grasp, FrictionCone cone, const Answer<kLanes>& answer,
                     Eigen::Ref<Eigen::VectorXd> f) {
  GraspReport report;
  report.iterations = answer.iterations;
  if (answer.status == GraspStatus::kBudgetSpent) return report;
  report.multiplier = twist_of(grasp, answer.multiplier);
  if (answer.status == GraspStatus::kOptimal) {
    report.residual = kkt_error(grasp, cone, answer);
    if (report.residual <= kTrust) {
      report.status = GraspStatus::kOptimal;
      to_world(grasp, answer.f, f);
      return report;
    }
  }
  // Forces that grow out of reach lose their own proof to rounding, and their multiplier becomes one that there are
  // none.
  const double gap = gap_left(grasp, cone, answer.multiplier);
  if (gap * kOutOfReach <= 1.0) {
    report.status = GraspStatus::kInfeasible;
    report.residual = gap;
  } else if (answer.status == GraspStatus::kOptimal && is_optimal_to_rounding(grasp, cone, answer)) {
    report.status = GraspStatus::kOptimal;
    to_world(grasp, answer.f, f);
  }
  return report;
}

/// Reduces, solves by `solve_reduced`, checks. Inlined as a whole: forces stay in registers from one part to the next,
/// which saves a tenth of the time.
template <int kLanes, class Solve>
[[gnu::flatten]] GraspReport solve(const GraspProblem& problem, Solve solve_reduced, Eigen::Ref<Eigen::VectorXd> f) {
  ReducedGrasp<kLanes> grasp;
  Vector6d twist;
  switch (reduce(problem, grasp, twist)) {
    case Reduction::kDone:
      return hand_out<kLanes>(grasp, problem.cone, solve_reduced(grasp), f);
    case Reduction::kUnreachable: {
      const double gap = std::sqrt(squared_norm(grasp.w)) * allowed_forces(problem, twist) / problem.wrench.dot(twist);
      if (gap * kOutOfReach <= 1.0) return {GraspStatus::kInfeasible, 0, gap, twist};
      return {GraspStatus::kBudgetSpent, 0, gap, Vector6d::Zero()};
    }
    case Reduction::kNotFinite:
      break;
  }
  return {};
}

template <class Solve>
GraspReport solve_with(const GraspProblem& problem, Solve solve_reduced, Eigen::Ref<Eigen::VectorXd> f) {
  const Index n = std::ssize(problem.contacts);
  assert(n <= kMaxGraspContacts && f.size() == 3 * n);
  assert(problem.grips.empty() || std::ssize(problem.grips) == n);
  if (n == 0) {
    // Any motion along the wrench proves that nothing holds it.
    if (!problem.wrench.allFinite()) return {};
    if (problem.wrench.isZero(0.0)) return {GraspStatus::kOptimal, 0, 0.0, Vector6d::Zero()};
    return {GraspStatus::kInfeasible, 0, 0.0, problem.wrench};
  }
  return n <= 4 ? solve<4>(problem, solve_reduced, f) : solve<8>(problem, solve_reduced, f);
}

}  // namespace

GraspWorkspace::GraspWorkspace() : lcp(kMaxRows) {
  // Rows behind those in use are computed with, and not used.
  N.setZero();
}

void grasp_map(std::span<const GraspContact> contacts, const Vector3d& centre_m, Eigen::Ref<Eigen::MatrixXd> G) {
  assert(G.rows() == 6 && G.cols() == 3 * std::ssize(contacts));
  for (Index i = 0; i < std::ssize(contacts); ++i) {
    const Vector3d r = contacts[i].point_m - centre_m;
    G.block<3, 3>(0, 3 * i).setIdentity();
    G.block<3, 3>(3, 3 * i) << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  }
}

const char* grasp_method(FrictionCone cone) noexcept {
  return cone == FrictionCone::kPyramid ? "active set, pyramids" : "tangent planes and Newton, exact cones";
}

GraspReport solve_grasp_forces(const GraspProblem& problem, Eigen::Ref<Eigen::VectorXd> f) noexcept {
  const auto solve_reduced = [&]<int kLanes>(const ReducedGrasp<kLanes>& grasp) {
    if (problem.cone == FrictionCone::kPyramid) return solve_pyramid(grasp);
    Answer<kLanes> answer;
    const ConeResult found = solve_exact_cone(grasp, answer.f, answer.multiplier);
    answer.status = found.status;
    answer.iterations = found.iterations;
    return answer;
  };
  return solve_with(problem, solve_reduced, f);
}

GraspReport solve_grasp_forces_by_lemke(const GraspProblem& problem, GraspWorkspace& work,
                                        Eigen::Ref<Eigen::VectorXd> f) noexcept {
  assert(problem.cone == FrictionCone::kPyramid);
  const auto solve_reduced = [&]<int kLanes>(const ReducedGrasp<kLanes>& grasp) { return solve_lemke(grasp, work); };
  return solve_with(problem, solve_reduced, f);
}

namespace {

/// The problem as given, for checks: plain G about the contacts' centroid, in units of their mean distance from it, so
/// that ranks do not depend on units.
struct PlainGrasp {
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 3 * kMaxGraspContacts> G;
  Vector6d wrench;

  explicit PlainGrasp(const GraspProblem& problem) {
    const Index n = std::ssize(problem.contacts);
    Vector3d centroid = Vector3d::Zero();
    for (const GraspContact& contact : problem.contacts) centroid += contact.point_m / static_cast<double>(n);
    double scatter = 0.0;
    for (const GraspContact& contact : problem.contacts) scatter += (contact.point_m - centroid).squaredNorm();
    const double length_m = scatter > 0.0 ? std::sqrt(scatter / static_cast<double>(n)) : 1.0;
    G.resize(6, 3 * n);
    grasp_map(problem.contacts, centroid, G);
    G.bottomRows<3>() /= length_m;
    const Vector3d force = problem.wrench.head<3>();
    wrench.head<3>() = force;
    wrench.tail<3>() = (problem.wrench.tail<3>() - (centroid - problem.centre_m).cross(force)) / length_m;
  }

  /// Returns |G^+ w|.
  [[nodiscard]] double least_forces(const Vector6d& w) const {
    constexpr double kNoPower = 1e-10;  // As collinear contacts are told: see reduced_grasp.cpp.
    decltype(G) turned = G;
    Eigen::Matrix<double, 6, 6> U;
    orthogonalize_rows(turned, U);
    double largest = 0.0, squares = 0.0;
    for (Index i = 0; i < 6; ++i) largest = std::max(largest, turned.row(i).norm());
    for (Index i = 0; i < 6; ++i) {
      const double length = turned.row(i).norm();
      if (length > kNoPower * largest) squares += std::pow(U.col(i).dot(w) / length, 2);
    }
    return std::sqrt(squares);
  }
};

/// Returns |c|. Over the largest lambda the squares of equal ones are 1, and their sum has no rounding.
double size_of_bias(const GraspProblem& problem) {
  const Index n = std::ssize(problem.contacts);
  double largest_N = 0.0;
  for (Index i = 0; i < n; ++i) largest_N = std::max(largest_N, std::abs(problem.internal_force_of(i)));
  if (largest_N == 0.0) return 0.0;
  double squares = 0.0;
  for (Index i = 0; i < n; ++i) squares += std::pow(problem.internal_force_of(i) / largest_N, 2);
  return largest_N * std::sqrt(squares);
}

}  // namespace

double grasp_kkt_error(const GraspProblem& problem, const Vector6d& multiplier,
                       const Eigen::Ref<const Eigen::VectorXd>& f) noexcept {
  const Index n = std::ssize(problem.contacts);
  if (n == 0) return problem.wrench.isZero(0.0) ? 0.0 : std::numeric_limits<double>::infinity();
  double squares = 0.0;
  for (Index i = 0; i < n; ++i) {
    const Vector3d squeeze = problem.internal_force_of(i) * problem.contacts[i].axes.col(0);
    const Vector3d pulled = velocity(problem, multiplier, i) + squeeze;
    squares += (f.segment<3>(3 * i) - nearest_inside(problem, i, pulled)).squaredNorm();
  }
  const PlainGrasp grasp(problem);
  const double error = std::max(std::sqrt(squares), grasp.least_forces(grasp.G * f - grasp.wrench));
  const double size = std::max(f.norm(), size_of_bias(problem));
  return error == 0.0 ? 0.0 : error / size;
}

double infeasibility_gap(const GraspProblem& problem, const Vector6d& twist) noexcept {
  const double power = problem.wrench.dot(twist);
  if (!(power > 0.0)) return std::numeric_limits<double>::infinity();
  if (problem.contacts.empty()) return 0.0;
  const PlainGrasp grasp(problem);
  return grasp.least_forces(grasp.wrench) * allowed_forces(problem, twist) / power;
}

}  // namespace thenar
