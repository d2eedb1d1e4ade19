// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "solvers/contact_problem.h"
#include "solvers/natural_map.h"
#include "solvers/residual.h"

// Shared parts of the Gauss-Seidel solvers: the local step, fast sweeps over blocks of W, and stopping criteria.

namespace thenar {

/// Stopping criteria of a contact solve.
struct GaussSeidelSettings {
  double tolerance = 1e-6;      ///< Natural-map residual [no unit] at which a solve has converged; see residual.h.
  int max_sweeps = 200;         ///< Bounds the time of one call.
  double share_of_first = 1.0;  ///< Sweeps go on below the tolerance until the residual is this share of the first one.
  double least_share = 1.0;     ///< They never go on below this share of the tolerance.

  /// Returns the residual at which sweeps that begin with `first_residual` end.
  [[nodiscard]] double stop_at(double first_residual) const {
    return std::min(tolerance, std::max(share_of_first * first_residual, least_share * tolerance));
  }
};

/// Coefficients of a contact's local step, from its own block W_ii.
struct LocalStep {
  double per_nn;    ///< 1 / W_nn; 0 where no force moves the gap.
  double t1n, t2n;  ///< W_t1n, W_t2n.
  double per_tt;    ///< 2 / (W_t1t1 + W_t2t2).
  double rho;       ///< Scale of the contact in the residual.
};

/// Computes the local step from the block's entries; rho is NaN unless they are finite with a nonnegative diagonal.
inline LocalStep local_step(double nn, double t1n, double t2n, double t1t1, double t2t2) {
  const double trace = nn + t1t1 + t2t2;
  const bool valid = nn >= 0.0 && t1t1 >= 0.0 && t2t2 >= 0.0 && std::isfinite(trace + t1n + t2n);
  const double per_nn = nn > 0.0 ? 1.0 / nn : 0.0;
  // A contact that no tangential force moves: any positive step leads its friction to the limit.
  const double per_tt = t1t1 + t2t2 > 0.0 ? 2.0 / (t1t1 + t2t2) : per_nn;
  return {per_nn, t1n, t2n, per_tt, valid ? rho_of_trace(trace) : std::numeric_limits<double>::quiet_NaN()};
}

/// Takes one step of a contact towards its laws, with the others fixed: the normal force closes the gap, then the
/// tangential force undoes the remaining slip as far as friction allows. Only an exact solution stays unchanged.
inline Rows update_force(const LocalStep& W, double mu, const Rows& delta, const Rows& f) {
  const double change = -W.per_nn * delta.n;
  const double f_n = f.n + change;
  if (!(f_n > 0.0)) return {0.0, 0.0, 0.0};
  const double slip_1 = delta.t1 + W.t1n * change;
  const double slip_2 = delta.t2 + W.t2n * change;
  return inside_cone({f_n, f.t1 - W.per_tt * slip_1, f.t2 - W.per_tt * slip_2}, mu);
}

/// The scale and solvability of a problem, found before its first sweep.
struct Admission {
  double scale_N = 0.0;  ///< Scale of the residual; NaN if the problem is invalid or its scale does not fit a double.
  bool no_solution = false;  ///< True if a closed contact cannot be opened by any force.
};

/// Checks a problem by the contacts' local steps, and scales the first guess into the cones.
template <typename Local, typename Problem>
Admission admit(const Local& local, const Problem& problem, Eigen::Ref<Eigen::VectorXd> f) {
  const Eigen::Ref<const Eigen::VectorXd>&delta_free = problem.delta_free, &mu = problem.mu;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!mu.allFinite() || !f.allFinite() || !delta_free.allFinite()) return {kNone};
  const double touching = touching_m(delta_free);
  Admission admission;
  double squared = 0.0;
  bool moves = false;
  for (Eigen::Index i = 0; i < mu.size(); ++i) {
    const LocalStep W = local(i);
    if (!(W.rho >= 0.0) || !(mu[i] >= 0.0)) return {kNone};
    squared += (W.rho * delta_free.segment<3>(3 * i)).squaredNorm();
    moves = moves || (W.rho > 0.0 && !delta_free.segment<3>(3 * i).isZero(0.0));
    const bool movable = W.per_nn > 0.0;
    if (!movable && delta_free[3 * i] < -touching) admission.no_solution = true;
    set_rows(f, i, movable ? inside_cone(rows_of(f, i), mu[i]) : Rows{0.0, 0.0, 0.0});
  }
  admission.scale_N = judged_scale_N(std::sqrt(squared), moves);
  return admission;
}

/// Memory of fast Gauss-Seidel solves for up to `contacts` contacts in `groups` groups, allocated once; and the problem
/// in the form of the sweeps: each group's part of W as a dense block in single precision, and the coupling of groups
/// through a body that all of them touch, in factors or in blocks of whole columns.
///
/// Single precision halves the data that a sweep reads, and its time. It holds only changes since the gaps were last
/// computed in double precision. That is done again whenever the residual has fallen by three digits or stalls, and
/// before any residual is reported: no tolerance is out of its reach.
struct SweepWorkspace {
  static constexpr int kWindow = 5;  ///< Differences in the acceleration: 3 cost some more sweeps, 10 save few.
  static constexpr int kCommon = 8;  ///< Degrees of freedom of the common body, 6, padded.
  static constexpr int kOwn = 4;     ///< Degrees of freedom of a group's own body.
  /// A group's rows are a multiple of this: a cache line of floats, and whole vector registers of any kind.
  static constexpr Eigen::Index kPadding = 16;
  using GroupRows = Eigen::Map<Eigen::VectorXf, Eigen::AlignedMax>;
  using Columns = Eigen::Matrix<float, Eigen::Dynamic, kWindow>;
  using Common = Eigen::Matrix<float, kCommon, 1>;

  explicit SweepWorkspace(Eigen::Index contacts, Eigen::Index groups = 1);

  /// The contacts begin .. end - 1. They have `rows` padded rows from `row` on; their block has `span` rows from
  /// `first` on: their own rows, or those of all groups.
  struct Group {
    Eigen::Index begin, end, row, rows, first, span, block;
  };

  /// Makes contacts begin[k] .. begin[k + 1) group k. whole: blocks are whole columns of W. body: a last group without
  /// contacts has the common body's own rows, in which `moved` tells its motion; where J_common of these is 1.
  void lay_out(std::span<const Eigen::Index> begin, bool whole = false, bool body = false);
  /// Returns W's columns of a group's contacts in the rows of its span; the caller fills them and their padding.
  auto block(const Group& group) {
    return Eigen::Map<Eigen::MatrixXf, Eigen::AlignedMax>(blocks.data() + group.block, group.span,
                                                          3 * (group.end - group.begin));
  }

  std::vector<Group> groups;
  std::vector<LocalStep> local;  ///< Local step of each contact, filled by the caller.
  Eigen::VectorXf blocks;
  bool coupled = false;  ///< True if groups are coupled, by J_common J_common'.
  /// True if the contacts are those of the last sweeps, and W is nearly theirs: filled by the caller. Then differences
  /// of the last sweeps are a first guess of how changes come about, as in quasi-Newton methods for coupled problems
  /// that keep those of earlier steps [Degroote, Bathe, Vierendeels 2009].
  bool goes_on = false;
  /// Columns of which blocks are made, then J_common, both times the roots of the mobilities; its padding holds a fifth
  /// column for blocks. Rows are those of the groups, with zero padding.
  Eigen::Matrix<float, Eigen::Dynamic, kOwn + kCommon> J;

  // State of the sweeps, in the groups' rows.
  Eigen::VectorXf moved;   ///< Changes of the gaps since they were computed.
  Eigen::VectorXf change;  ///< Changes of the forces by the last sweep.
  /// Motion of the common body in a sweep, up to each group's end.
  Eigen::Matrix<float, kCommon, Eigen::Dynamic> common_after;

  // State of the acceleration: the last result, and the differences of results and their changes between sweeps.
  Eigen::VectorXf change_last, moved_last;
  Eigen::VectorXd f_last;
  Columns d_change, d_moved, d_f;
  Eigen::Matrix<double, kWindow, kWindow> gram;
  std::int64_t differences = 0;  ///< Since the last restart; the newest is in column (differences - 1) % kWindow.
  bool has_last = false;         ///< True if there is a last result.
  double least_change = 0.0;
};

/// Resets the sweeps' state, for gaps that were just computed; without the differences where the workspace goes on.
void start_sweeps(SweepWorkspace& work);

/// Updates the force of each contact in turn; returns the 2-norm of the changes [N].
double sweep(const Eigen::Ref<const Eigen::VectorXd>& mu, const Eigen::Ref<const Eigen::VectorXd>& delta,
             SweepWorkspace& work, Eigen::Ref<Eigen::VectorXd> f);

/// Adds a motion of the common body, in the coordinates of J_common, to the contacts' gaps.
void move_body(const SweepWorkspace::Common& motion, SweepWorkspace& work);

/// Takes Anderson's step after a sweep [Anderson 1965; Walker, Ni 2011]: combines the last results so that their
/// changes nearly cancel, which at least halves the number of sweeps. It restarts where changes grow. The next sweep
/// returns contacts that it moves out of their cones.
void accelerate(double change_N, SweepWorkspace& work, Eigen::Ref<Eigen::VectorXd> f);

/// Computes the residual of f with the gaps of the sweeps.
Residual sweep_residual(const SweepWorkspace& work, const Eigen::Ref<const Eigen::VectorXd>& mu,
                        const Eigen::Ref<const Eigen::VectorXd>& f, const Eigen::Ref<const Eigen::VectorXd>& delta,
                        double scale_N);

/// Resets the changes of gaps after delta was recomputed.
void gaps_are_exact(SweepWorkspace& work);

// A residual costs a third of a sweep. Between evaluations it is estimated from the last change; it is evaluated when
// it may be within this factor of the tolerance, or after this number of sweeps.
inline constexpr double kLookAt = 3.0;
inline constexpr int kLookAfter = 6;
// Single precision has seven digits, and the weights of the acceleration may cost some. Rounding may also stall a
// residual: large forces that balance one another leave few digits for the gaps.
inline constexpr double kExactEvery = 1e-3;
inline constexpr double kStalled = 0.8;

/// Completes the report of sweeps that ended with this residual: `solved` is their status if it keeps the tolerance.
inline SolveReport finish_sweeps(const Residual& residual, double tolerance, SolveStatus solved, SolveReport report,
                                 const ContactSolution& solution) {
  // Entries of W off its diagonal were not checked before: errors in them show here.
  if (!std::isfinite(residual.norm) || !solution.delta.allFinite() || !solution.f.allFinite()) {
    return not_finite(report.sweeps, solution);
  }
  report.residual = residual.norm;
  report.residual_worst = residual.worst;
  if (residual.norm <= tolerance) report.status = solved;
  return report;
}

/// Sweeps from f until the residual is where the settings stop, or stalls below the tolerance. The workspace is laid
/// out and filled; `gaps(f, delta)` computes delta = W f + delta_free in double precision; where W f is not linear,
/// `react(f, change_N)` corrects the gaps after each sweep, and returns true if it has refilled the workspace. Forces
/// may then act without any free motion: where the residual's scale is rounding beside `acting_N`, the size of the
/// forces known to act, this is the scale.
template <typename Problem, typename Gaps, typename React>
SolveReport iterate_sweeps(const Problem& problem, const GaussSeidelSettings& settings, SweepWorkspace& work,
                           const Gaps& gaps, const React& react, ContactSolution solution, double acting_N = 0.0) {
  constexpr double kRounding = 1e-9;
  const Eigen::Ref<const Eigen::VectorXd>& mu = problem.mu;
  Eigen::Ref<Eigen::VectorXd>&f = solution.f, &delta = solution.delta;
  Admission admission = admit([&](Eigen::Index i) { return work.local[i]; }, problem, f);
  if (!std::isfinite(admission.scale_N)) return not_finite(0, solution);
  if (admission.scale_N < kRounding * acting_N) admission.scale_N = acting_N;
  const SolveStatus solved = admission.no_solution ? SolveStatus::kNoSolution : SolveStatus::kConverged;
  // Without free motion no force is needed, and there is no scale to judge one by.
  if (admission.scale_N == 0.0) f.setZero();
  gaps(f, delta);
  if (admission.scale_N == 0.0) return {solved};

  const auto look = [&] { return sweep_residual(work, mu, f, delta, admission.scale_N); };
  start_sweeps(work);
  SolveReport report{SolveStatus::kBudgetSpent};
  Residual residual = look();
  const double stop_at = settings.stop_at(residual.norm);
  double exact_residual = residual.norm, per_change = 0.0;
  int last_look = 0;
  // A stalled sweep moves nothing and solves nothing: judge by the residual, never by the step.
  while (residual.norm > stop_at && report.sweeps < settings.max_sweeps) {
    const double change_N = sweep(mu, delta, work, f);
    const bool is_anew = react(f, change_N);
    ++report.sweeps;
    if (report.sweeps == 1) per_change = residual.norm / change_N;
    const bool last = report.sweeps == settings.max_sweeps;
    if (is_anew) {
      gaps(f, delta);
      start_sweeps(work);
      residual = look();
      exact_residual = residual.norm;
      per_change = residual.norm / change_N;
      last_look = report.sweeps;
      continue;
    }
    if (last || report.sweeps >= last_look + kLookAfter || !(per_change * change_N > kLookAt * stop_at)) {
      last_look = report.sweeps;
      const double stalled_at = kStalled * residual.norm;
      residual = look();
      if (last || residual.norm > stalled_at || residual.norm <= std::max(stop_at, kExactEvery * exact_residual)) {
        gaps(f, delta);
        gaps_are_exact(work);
        residual = look();
        exact_residual = residual.norm;
      }
      per_change = residual.norm / change_N;
      const bool is_stalled = report.sweeps > kLookAfter && residual.norm > stalled_at;
      if (last || residual.norm <= stop_at || (is_stalled && residual.norm <= settings.tolerance)) break;
    }
    accelerate(change_N, work, f);
  }
  return finish_sweeps(residual, settings.tolerance, solved, report, solution);
}

template <typename Problem, typename Gaps>
SolveReport iterate_sweeps(const Problem& problem, const GaussSeidelSettings& settings, SweepWorkspace& work,
                           const Gaps& gaps, ContactSolution solution) {
  return iterate_sweeps(
      problem, settings, work, gaps, [](const auto&, double) { return false; }, solution);
}

}  // namespace thenar
