// SPDX-License-Identifier: Apache-2.0
#include "solvers/muscles/muscle_forces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "solvers/dual_active_set.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using MatrixRef = Eigen::Ref<const MatrixXd>;
using VectorRef = Eigen::Ref<const VectorXd>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Rows of H are measured lever arms: a remainder of one below this part of its length is rounding, not anatomy.
constexpr double kDependentRow = 1e-10;
// Rows that lose more than this part of their length to those before them are made orthogonal twice.
constexpr double kShortened = 0.1;
// Answers are trusted if they miss their proof by less; the active set's usually do by 1e-13.
constexpr double kTrust = 1e-7;
// A muscle counts as able to pull this many times what a single muscle would need for a joint.
constexpr double kOutOfReach = 1e6;

/// Joints and the muscles that cross them, by their numbers in H.
struct Block {
  std::array<int, kMaxJoints> joint;
  std::array<int, kMaxMuscles> muscle;
  int joints = 0, muscles = 0;
};

using Crossings = std::array<std::uint64_t, kMaxJoints>;

/// Returns the muscles with an arm on each joint, one bit each.
Crossings crossings_of(const MatrixRef& H) {
  Crossings crossings{};
  for (Index j = 0; j < H.cols(); ++j) {
    const double* const arms = H.col(j).data();
    const std::uint64_t bit = std::uint64_t{1} << j;
    for (Index i = 0; i < H.rows(); ++i) crossings[i] |= arms[i] != 0.0 ? bit : 0;
  }
  return crossings;
}

/// Takes the first of the remaining joints and all coupled with it.
Block take_block(const Crossings& crossings, std::uint64_t& joints_left) {
  std::uint64_t joints = joints_left & -joints_left;
  std::uint64_t muscles = crossings[std::countr_zero(joints)];
  for (std::uint64_t before = 0; before != joints;) {
    before = joints;
    for (std::uint64_t rest = joints_left & ~joints; rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      if ((crossings[i] & muscles) == 0) continue;
      joints |= std::uint64_t{1} << i;
      muscles |= crossings[i];
    }
  }
  joints_left &= ~joints;
  Block block;
  for (; joints != 0; joints &= joints - 1) block.joint[block.joints++] = std::countr_zero(joints);
  for (; muscles != 0; muscles &= muscles - 1) block.muscle[block.muscles++] = std::countr_zero(muscles);
  return block;
}

/// The constraints 0 <= x <= limit, two per entry: i and kSize + i.
template <int kSize>
struct Pulling {
  using Vector = typename ActiveSet<kSize>::Vector;

  const Vector& limit;
  bool is_limited;

  [[nodiscard]] Constraint<1> most_violated(const Vector& x, double tolerance) const {
    const double least = x.minCoeff();
    if (is_limited && least >= -tolerance) {
      const Vector slack = limit - x;
      const double least_slack = slack.minCoeff();
      const int i = find(slack, least_slack);
      return {kSize + i, least_slack, {i}, {-1.0}};
    }
    const int i = find(x, least);
    return {i, least, {i}, {1.0}};
  }

  // Looking the least up is faster than carrying its index through the search.
  static int find(const Vector& x, double least) {
    int i = 0;
    while (i < kSize - 1 && x[i] != least) ++i;
    return i;
  }
};

/// Adds u_j a_j of the limits in the set, times `factor`.
template <int kSize>
void add_push(const ActiveSet<kSize>& set, double factor, typename ActiveSet<kSize>::Vector& x) {
  for (int j = 0; j < set.active; ++j) {
    const int i = set.id[j];
    x[i < kSize ? i : i - kSize] += (i < kSize ? factor : -factor) * set.multiplier[j];
  }
}

/// The factors H = L Y with orthonormal rows Y, and L t = tau, of a block's rows that do not depend on earlier ones.
template <int kSize>
struct Equations {
  explicit Equations(ActiveSet<kSize>& basis) : set(basis) {}

  ActiveSet<kSize>& set;                           ///< Y is its basis.
  std::array<std::array<double, kSize>, kSize> L;  ///< Below the diagonal.
  std::array<double, kSize> over_diagonal;         ///< 1 / L(k, k)
  std::array<double, kSize> t;
  std::array<int, kSize> joint;  ///< Joint of each row.
  int rank = 0;

  /// Adds the row of a joint, y. False if it depends on the others and its torque does not agree with theirs; then
  /// `part` and `torque_left` hold what of it is left on which side.
  bool add(int number, typename ActiveSet<kSize>::Vector y, double tau, std::array<double, kSize>& part,
           double& torque_left) {
    const double length_squared = y.square().sum();
    double left_squared = length_squared;
    for (int k = 0; k < rank; ++k) part[k] = 0.0;
    for (int pass = 0; pass < 2 && (pass == 0 || left_squared < kShortened * kShortened * length_squared); ++pass) {
      // All products first: they do not wait for each other.
      std::array<double, kSize> along;
      for (int k = 0; k < rank; ++k) along[k] = (y * set.basis[k]).sum();
      for (int k = 0; k < rank; ++k) {
        part[k] += along[k];
        y -= along[k] * set.basis[k];
      }
      left_squared = y.square().sum();
    }
    torque_left = tau;
    for (int k = 0; k < rank; ++k) torque_left -= part[k] * t[k];
    if (rank < kSize && left_squared > kDependentRow * kDependentRow * length_squared) {
      const double over_left = 1.0 / std::sqrt(left_squared);
      set.basis[rank] = over_left * y;
      for (int k = 0; k < rank; ++k) L[rank][k] = part[k];
      over_diagonal[rank] = over_left;
      t[rank] = over_left * torque_left;
      joint[rank++] = number;
      return true;
    }
    double torque_scale = std::abs(tau);
    for (int k = 0; k < rank; ++k) torque_scale = std::max(torque_scale, std::abs(part[k] * t[k]));
    return std::abs(torque_left) <= kDependentRow * torque_scale;
  }

  /// Solves L' l = v for the rows.
  void solve_transposed(std::array<double, kSize>& v) const {
    for (int k = rank - 1; k >= 0; --k) {
      v[k] *= over_diagonal[k];
      for (int i = 0; i < k; ++i) v[i] -= L[k][i] * v[k];
    }
  }
};

/// Solves one block of the problem; adds to f, and to the certificate l.
template <int kSize>
MuscleStatus solve_block(const Block& block, const MuscleProblem& problem, std::array<double, kMaxMuscles>& f,
                         MuscleReport& report) {
  using Vector = typename ActiveSet<kSize>::Vector;
  ActiveSet<kSize> set;
  Equations<kSize> equations(set);
  // All rows first: numbers stored one by one are slow to be had as a vector at once.
  std::array<Vector, kMaxJoints> rows;
  for (int i = 0; i < block.joints; ++i) {
    rows[i].setZero();
    for (int j = 0; j < block.muscles; ++j) rows[i][j] = problem.H(block.joint[i], block.muscle[j]);
  }
  std::array<double, kSize> part;
  for (int i = 0; i < block.joints; ++i) {
    const int joint = block.joint[i];
    double torque_left = 0.0;
    if (equations.add(joint, rows[i], problem.tau[joint], part, torque_left)) continue;
    // Velocities of the joints at which no muscle changes its length, and the torques do work.
    const double sign = torque_left > 0.0 ? 1.0 : -1.0;
    report.multiplier.setZero();
    equations.solve_transposed(part);
    for (int k = 0; k < equations.rank; ++k) report.multiplier[equations.joint[k]] = -sign * part[k];
    report.multiplier[joint] = sign;
    return MuscleStatus::kInfeasible;
  }

  set.equalities = equations.rank;
  Vector x = Vector::Zero();
  for (int k = 0; k < equations.rank; ++k) x += equations.t[k] * set.basis[k];
  Vector limit = Vector::Constant(kInfinity);
  for (int j = 0; j < block.muscles; ++j) limit[j] = problem.limit_of(block.muscle[j]);
  const ActiveSetReport found = project<kSize>(Pulling<kSize>{limit, problem.limit.size() > 0}, set, x);
  report.iterations += found.changes;
  if (found.status == ActiveSetStatus::kBudgetSpent) return MuscleStatus::kBudgetSpent;

  // x = Y' (L' l) + what holds idle muscles at 0, and others at their limits.
  const bool optimal = found.status == ActiveSetStatus::kOptimal;
  Vector rest = optimal ? x : Vector(Vector::Zero());
  add_push(set, -1.0, rest);
  for (int k = 0; k < equations.rank; ++k) part[k] = (rest * set.basis[k]).sum();
  equations.solve_transposed(part);
  if (!optimal) report.multiplier.setZero();
  for (int k = 0; k < equations.rank; ++k) report.multiplier[equations.joint[k]] = part[k];
  if (!optimal) return MuscleStatus::kInfeasible;

  x = x.max(0.0).min(limit);
  for (int j = 0; j < set.active; ++j) {  // The rest is rounding.
    const int i = set.id[j];
    x[i < kSize ? i : i - kSize] = i < kSize ? 0.0 : limit[i - kSize];
  }
  for (int j = 0; j < block.muscles; ++j) f[block.muscle[j]] = x[j];
  return MuscleStatus::kOptimal;
}

MuscleStatus solve_block_of_any_size(const Block& block, const MuscleProblem& problem,
                                     std::array<double, kMaxMuscles>& f, MuscleReport& report) {
  if (block.muscles <= 8) return solve_block<8>(block, problem, f, report);
  if (block.muscles <= 16) return solve_block<16>(block, problem, f, report);
  if (block.muscles <= 24) return solve_block<24>(block, problem, f, report);
  return solve_block<kMaxMuscles>(block, problem, f, report);
}

/// Checks the proof of an answer: sets the residual, and withdraws an answer that fails, as with non-finite input.
MuscleReport finish(const MuscleProblem& problem, const VectorRef& found, MuscleReport report, Eigen::Ref<VectorXd> f) {
  bool proved = false;
  if (report.status == MuscleStatus::kInfeasible) {
    report.residual = muscle_infeasibility_gap(problem, report.multiplier);
    proved = report.residual < 1.0;
  } else if (report.status == MuscleStatus::kOptimal) {
    report.residual = muscle_kkt_error(problem, report.multiplier, found);
    proved = report.residual <= kTrust;
    if (proved) f = found;
  }
  if (!proved) report.status = MuscleStatus::kBudgetSpent;
  return report;
}

}  // namespace

MuscleReport solve_muscle_forces(const MuscleProblem& problem, Eigen::Ref<VectorXd> f) noexcept {
  const Index joints = problem.H.rows(), muscles = problem.H.cols();
  assert(joints <= kMaxJoints && muscles <= kMaxMuscles && problem.tau.size() == joints && f.size() == muscles);
  assert(problem.limit.size() == 0 || problem.limit.size() == muscles);
  MuscleReport report;
  report.multiplier.setZero(joints);
  report.status = MuscleStatus::kOptimal;  // A problem without joints.
  const Crossings crossings = crossings_of(problem.H);
  std::array<double, kMaxMuscles> found{};
  std::uint64_t joints_left = (std::uint64_t{1} << joints) - 1;
  while (joints_left != 0) {
    const Block block = take_block(crossings, joints_left);
    report.status = solve_block_of_any_size(block, problem, found, report);
    if (report.status != MuscleStatus::kOptimal) break;
  }
  return finish(problem, Eigen::Map<const VectorXd>(found.data(), muscles), report, f);
}

double muscle_kkt_error(const MuscleProblem& problem, const VectorRef& l, const VectorRef& f) noexcept {
  using JointVector = MuscleReport::JointVector;
  JointVector torque = -problem.tau;
  JointVector longest = JointVector::Zero(torque.size());
  double error_N = 0.0;
  double largest_N = 0.0;
  for (Index j = 0; j < problem.H.cols(); ++j) {
    const auto arms = problem.H.col(j);
    const double limit = problem.limit_of(j);
    if (std::isnan(limit)) return kInfinity;
    const double wanted = std::min(std::max(0.0, arms.dot(l)), limit);
    error_N = std::max(error_N, std::abs(f[j] - wanted));
    largest_N = std::max(largest_N, std::abs(f[j]));
    torque += f[j] * arms;
    longest = longest.cwiseMax(arms.cwiseAbs());
  }
  // Every entry of H has been in a sum, and 0 times infinity is not a number either.
  if (!torque.allFinite() || !l.allFinite()) return kInfinity;
  for (Index i = 0; i < torque.size(); ++i) {
    if (torque[i] != 0.0) error_N = std::max(error_N, std::abs(torque[i]) / longest[i]);
  }
  return error_N > 0.0 ? error_N / largest_N : 0.0;
}

double muscle_infeasibility_gap(const MuscleProblem& problem, const VectorRef& l) noexcept {
  const MatrixRef& H = problem.H;
  const VectorRef& tau = problem.tau;
  const double wanted = tau.dot(l);
  if (!(wanted > 0.0)) return kInfinity;
  if (H.cols() == 0) return 0.0;  // H has no data to take rows of.
  double least_N = 0.0;           // Least force that some joint needs.
  for (Index i = 0; i < H.rows(); ++i) {
    const double arm = H.row(i).lpNorm<Eigen::Infinity>();
    if (arm > 0.0) least_N = std::max(least_N, std::abs(tau[i]) / arm);
  }
  double possible = 0.0;
  for (Index j = 0; j < H.cols(); ++j) {
    const double limit = problem.limit_of(j);
    possible += std::max(0.0, H.col(j).dot(l)) * (std::isinf(limit) ? kOutOfReach * least_N : limit);
  }
  return std::isnan(possible) ? kInfinity : possible / wanted;
}

MuscleLack muscle_lack(const MuscleProblem& problem, const VectorRef& l) noexcept {
  MuscleLack lack;
  double possible = 0.0, largest = 0.0, rate_of_largest = 0.0;
  for (Index j = 0; j < problem.H.cols(); ++j) {
    const auto arms = problem.H.col(j);
    const double rate = arms.dot(l), limit = problem.limit_of(j);
    // Smaller values are rounding of zero, as is the work of muscles without limits.
    if (!(rate > kDependentRow * arms.norm() * l.norm()) || !std::isfinite(limit)) continue;
    possible += limit * rate;
    if (limit * rate < largest || (lack.muscle >= 0 && limit * rate == 0.0)) continue;
    lack.muscle = static_cast<int>(j);
    largest = limit * rate;
    rate_of_largest = rate;
  }
  if (lack.muscle >= 0) lack.needed_N = (problem.tau.dot(l) - (possible - largest)) / rate_of_largest;
  return lack;
}

namespace {

/// Replaces H f = tau by Y f = t with orthonormal rows, H = L Y and tau = L t, by Gram-Schmidt. Rows that depend on
/// those before them are zero in Y. Stops at one whose torque does not agree with theirs, with the remainder in t.
Index orthonormalise(const MuscleProblem& problem, MuscleWorkspace& work) {
  const MatrixRef& H = problem.H;
  auto Y = work.Y.topLeftCorner(H.rows(), H.cols());
  work.L.setZero();
  for (Index i = 0; i < H.rows(); ++i) {
    auto y = Y.row(i);
    y = H.row(i);
    double& t = work.t[i];
    t = problem.tau[i];
    const double length = y.norm();
    double torque_scale = std::abs(t);
    // Twice is enough: the second pass takes away what rounding left in the first.
    for (int pass = 0; pass < 2; ++pass) {
      for (Index k = 0; k < i; ++k) {
        const double along = y.dot(Y.row(k));
        y -= along * Y.row(k);
        t -= along * work.t[k];
        work.L(i, k) += along;
        torque_scale = std::max(torque_scale, std::abs(along * work.t[k]));
      }
    }
    const double left = y.norm();
    if (left > kDependentRow * length) {
      y /= left;
      t /= left;
      work.L(i, i) = left;
      continue;
    }
    y.setZero();
    if (std::abs(t) > kDependentRow * torque_scale) return i;
    t = 0.0;
  }
  return H.rows();
}

/// Solves L' l = v for the first rows that depend on no others; l is 0 for the rest.
void solve_transposed(const MuscleWorkspace& work, Index rows, MuscleReport::JointVector& v) {
  for (Index k = rows - 1; k >= 0; --k) {
    for (Index i = k + 1; i < rows; ++i) v[k] -= work.L(i, k) * v[i];
    v[k] = work.L(k, k) > 0.0 ? v[k] / work.L(k, k) : 0.0;
  }
}

}  // namespace

MuscleWorkspace::MuscleWorkspace(Index joints, Index muscles)
    : lcp(2 * muscles),
      Y(joints, muscles),
      L(joints, joints),
      t(joints),
      pi(muscles, muscles),
      least(muscles),
      z(muscles),
      M(2 * muscles, 2 * muscles),
      q(2 * muscles),
      zy(2 * muscles) {}

namespace {

/// Solves the LCP of f = pi (z - y) + least with a row for each muscle, and one for each finite limit. z receives the
/// difference z - y.
LcpReport solve_limited_lcp(const MuscleProblem& problem, MuscleWorkspace& work) {
  const Index muscles = problem.H.cols();
  std::array<Index, kMaxMuscles> limited{};
  Index limits = 0;
  for (Index j = 0; j < muscles; ++j) {
    if (!std::isinf(problem.limit_of(j))) limited[limits++] = j;
  }
  const Index rows = muscles + limits;
  auto M = work.M.topLeftCorner(rows, rows);
  auto q = work.q.head(rows);
  const auto side = [&](Index row) { return row < muscles ? row : limited[row - muscles]; };
  for (Index c = 0; c < rows; ++c) {
    for (Index r = 0; r < rows; ++r) {
      M(r, c) = ((r < muscles) == (c < muscles) ? 1.0 : -1.0) * work.pi(side(r), side(c));
    }
    q[c] = c < muscles ? work.least[c] : problem.limit[side(c)] - work.least[side(c)];
  }
  auto zy = work.zy.head(rows);
  const LcpReport report = solve_lcp({M, q}, usual_pivot_budget(rows), work.lcp, zy);
  work.z.head(muscles) = zy.head(muscles);
  for (Index k = 0; k < limits; ++k) work.z[limited[k]] -= zy[muscles + k];
  return report;
}

}  // namespace

MuscleReport solve_muscle_forces_by_lemke(const MuscleProblem& problem, MuscleWorkspace& work,
                                          Eigen::Ref<VectorXd> f) noexcept {
  const Index joints = problem.H.rows(), muscles = problem.H.cols();
  assert(joints <= work.Y.rows() && muscles <= work.Y.cols() && problem.tau.size() == joints && f.size() == muscles);
  MuscleReport report;
  auto& l = report.multiplier;
  l.setZero(joints);

  const Index contradiction = orthonormalise(problem, work);
  if (contradiction < joints) {
    // Velocities of the joints at which no muscle changes its length, and the torques do work.
    const double sign = work.t[contradiction] > 0.0 ? 1.0 : -1.0;
    l = -sign * work.L.row(contradiction).head(joints).transpose();
    solve_transposed(work, contradiction, l);
    l[contradiction] = sign;
    report.status = MuscleStatus::kInfeasible;
  } else {
    const auto Y = work.Y.topLeftCorner(joints, muscles);
    const auto t = work.t.head(joints);
    auto pi = work.pi.topLeftCorner(muscles, muscles);
    auto least = work.least.head(muscles);
    auto z = work.z.head(muscles);
    pi.noalias() = -Y.transpose().lazyProduct(Y);
    pi.diagonal().array() += 1.0;
    least.noalias() = Y.transpose().lazyProduct(t);
    const bool is_limited = problem.limit.size() > 0 && !problem.limit.array().isInf().all();
    const LcpReport lcp = is_limited ? solve_limited_lcp(problem, work)
                                     : solve_lcp({pi, least}, usual_pivot_budget(muscles), work.lcp, z);
    report.iterations = lcp.pivots;
    if (lcp.status == LcpStatus::kBudgetSpent) return report;
    // f = Y' (t - Y z) + z; and a ray z = Y' (Y z) >= 0 with z.least < 0.
    report.status = lcp.status == LcpStatus::kSolved ? MuscleStatus::kOptimal : MuscleStatus::kInfeasible;
    l.noalias() = -Y.lazyProduct(z);
    if (report.status == MuscleStatus::kOptimal) l += t;
    solve_transposed(work, joints, l);
    least += pi.lazyProduct(z);
    // Either f or z is zero, or f is at its limit; the rest is rounding.
    for (Index j = 0; j < muscles; ++j) {
      const double limit = problem.limit_of(j);
      least[j] = z[j] > 0.0 ? 0.0 : z[j] < 0.0 ? limit : std::min(std::max(0.0, least[j]), limit);
    }
  }
  return finish(problem, work.least.head(muscles), report, f);
}

}  // namespace thenar
