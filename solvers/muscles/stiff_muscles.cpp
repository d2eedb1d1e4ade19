// SPDX-License-Identifier: Apache-2.0
#include "solvers/muscles/stiff_muscles.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "solvers/muscles/stiff_newton.h"
#include "solvers/muscles/stiff_planes.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// An optimum is exact at this error, and trusted up to the second.
constexpr double kEnough = 1e-10;
constexpr double kTrusted = 1e-9;
constexpr double kProved = 2.0 * kTrusted;  // In the proof's own measure.
// Violations that the planes tolerate, relative to the demand: from the first Newton solves most problems; where it
// does not, from a later one.
constexpr std::array kLeft{3e-2, 1e-3, 1e-5, 1e-7};
constexpr int kNewtonSteps = 12;
// From the last period's optimum two are usual.
constexpr int kWarmSteps = 8;
// A step squares the error, times some number between 0.1 and 10: the result of one from here needs no evaluation.
constexpr double kUnseen = 6e-6;
// Where the ways to the last optima lead on, as a guess of the error there, by which directions are found.
constexpr double kGoingOn = 0.03;

template <int kSize>
class StiffSolver {
 public:
  using Lanes = typename StiffModel<kSize>::Lanes;

  StiffSolver(const StiffMuscleProblem& problem, StiffMuscleReport& report)
      : problem_(problem), report_(report), model_(problem), newton_(model_) {}

  /// Loads the last optimum; false if it is of another problem.
  bool resume(const StiffWarmStart& last);

  /// Solves from the loaded optimum; false if that fails.
  bool warm(double unseen) {
    return newton_.run(candidate_, kWarmSteps, {kEnough, kTrusted, unseen}, report_.iterations);
  }

  /// Tests whether forces found without regard to stiffness have enough of it.
  bool is_stiff(const Eigen::Ref<const VectorXd>& f) {
    Lanes x = Lanes::Zero();
    x.head(model_.muscles) = f.array();
    StiffPoint<kSize> point;
    point.look(model_, x);
    if (!point.is_definite || !is_positive(6, point.S, 0.0)) return false;
    for (int k = 0; k < model_.fingers; ++k) {
      if (!is_positive(model_.finger[k].joints, point.posture(model_, k), 0.0)) return false;
    }
    return true;
  }

  /// Solves without a start; true if the problem is decided: optimal, or infeasible.
  bool cold();

  void take_optimum(Eigen::Ref<VectorXd> found);
  void leave(StiffWarmStart& last) const;

 private:
  bool start(ActiveSet<kSize>& set, Lanes& x);
  std::array<double, kMaxJoints> joint_multipliers(const ActiveSet<kSize>& set, const Lanes& rest) const;
  void take_candidate(const StiffPlanes<kSize>& planes, const ActiveSet<kSize>& set, const Lanes& x);
  void take_proof(const StiffPlanes<kSize>& planes, const ActiveSet<kSize>& set);

  const StiffMuscleProblem& problem_;
  StiffMuscleReport& report_;
  StiffModel<kSize> model_;
  StiffNewton<kSize> newton_;
  StiffCandidate<kSize> candidate_;
  // rows = L basis for the rows that do not depend on others.
  std::array<std::array<double, kMaxJoints>, kMaxJoints> L_;
  std::array<int, kMaxJoints> joint_;
};

template <int kSize>
bool StiffSolver<kSize>::resume(const StiffWarmStart& last) {
  if (!last.is_set || last.variables != model_.variables || last.joints != model_.joints ||
      last.fingers != model_.fingers) {
    return false;
  }
  const double on = last.order > 0 ? 1.0 : 0.0, bent = last.order > 1 ? 1.0 : 0.0;
  candidate_.error = last.order > 0 ? kGoingOn : std::numeric_limits<double>::infinity();
  candidate_.x.setZero();
  candidate_.x.head(model_.variables) =
      (last.at.x + on * last.way.x + bent * last.bend.x).head(model_.variables).array();
  for (int i = 0; i < model_.joints; ++i) {
    candidate_.l[i] = last.at.l[i] + on * last.way.l[i] + bent * last.bend.l[i];
  }
  const auto widen = [&](const auto& from, const auto& way, const auto& bend, int n, SmallSymmetric& to) {
    for (int i = 0; i < 6; ++i) {
      to[i].setZero();
      for (int c = 0; i < n && c < n; ++c) to[i][c] = from(i, c) + on * way(i, c) + bent * bend(i, c);
    }
  };
  widen(last.at.Z, last.way.Z, last.bend.Z, 6, candidate_.Z);
  for (int k = 0; k < model_.fingers; ++k) {
    widen(last.at.Y[k], last.way.Y[k], last.bend.Y[k], model_.finger[k].joints, candidate_.Y[k]);
  }
  for (int i = 0; i < 6; ++i) {
    newton_.seed[i].setZero();
    newton_.seed[i].template head<6>() = last.basis.row(i).transpose().array();
  }
  return true;
}

/// Computes the orthonormal rows of H f = tau and the least x; false if a dependent row's torque does not agree.
template <int kSize>
bool StiffSolver<kSize>::start(ActiveSet<kSize>& set, Lanes& x) {
  constexpr double kDependent = 1e-10;
  x.setZero();
  set.equalities = 0;
  for (int i = 0; i < model_.joints; ++i) {
    Lanes y = model_.row[i];
    const double length = std::sqrt(y.square().sum());
    double torque = model_.tau[i];
    const int rank = set.equalities;
    std::array<double, kMaxJoints> part{};
    for (int pass = 0; pass < 2; ++pass) {
      for (int k = 0; k < rank; ++k) {
        const double along = (y * set.basis[k]).sum();
        part[k] += along;
        y -= along * set.basis[k];
      }
    }
    for (int k = 0; k < rank; ++k) torque -= part[k] * (x * set.basis[k]).sum();
    const double left = std::sqrt(y.square().sum());
    if (left <= kDependent * length || rank == kSize) {
      if (std::abs(torque) > kDependent * (std::abs(model_.tau[i]) + length * std::sqrt(x.square().sum()))) {
        // Velocities of the joints that no muscle feels.
        for (int k = rank - 1; k >= 0; --k) {
          part[k] /= L_[k][k];
          for (int c = 0; c < k; ++c) part[c] -= L_[k][c] * part[k];
        }
        const double sign = torque > 0.0 ? 1.0 : -1.0;
        report_.multiplier.setZero();
        for (int k = 0; k < rank; ++k) report_.multiplier[joint_[k]] = -sign * part[k];
        report_.multiplier[i] = sign;
        report_.cause = StiffCause::kTorques;
        return false;
      }
      continue;
    }
    for (int k = 0; k < rank; ++k) L_[rank][k] = part[k];
    L_[rank][rank] = left;
    joint_[rank] = i;
    set.basis[rank] = y / left;
    x += (torque / left) * set.basis[rank];
    ++set.equalities;
  }
  return true;
}

/// Solves H'l = the part of `rest` in the span of the rows.
template <int kSize>
std::array<double, kMaxJoints> StiffSolver<kSize>::joint_multipliers(const ActiveSet<kSize>& set,
                                                                     const Lanes& rest) const {
  std::array<double, kMaxJoints> l{}, part{};
  for (int k = 0; k < set.equalities; ++k) part[k] = (rest * set.basis[k]).sum();
  for (int k = set.equalities - 1; k >= 0; --k) {
    part[k] /= L_[k][k];
    for (int c = 0; c < k; ++c) part[c] -= L_[k][c] * part[k];
    l[joint_[k]] = part[k];
  }
  return l;
}

template <int kSize>
void StiffSolver<kSize>::take_candidate(const StiffPlanes<kSize>& planes, const ActiveSet<kSize>& set, const Lanes& x) {
  candidate_.x = x;
  newton_.seed = planes.basis();
  Lanes rest = x;
  planes.add_push(set, -1.0, rest);
  candidate_.l = joint_multipliers(set, rest);
  for (SixWide& line : candidate_.Z) line.setZero();
  for (int k = 0; k < model_.fingers; ++k) {
    for (SixWide& line : candidate_.Y[k]) line.setZero();
  }
  for (int j = 0; j < set.active; ++j) {
    const auto* const plane = planes.plane(set.id[j]);
    if (plane == nullptr) continue;
    SmallSymmetric& Z = plane->finger < 0 ? candidate_.Z : candidate_.Y[plane->finger];
    for (int i = 0; i < 6; ++i) Z[i] += (set.multiplier[j] * plane->over_length * plane->e[i]) * plane->e;
  }
}

/// Returns the weights of planes that are infeasible.
template <int kSize>
void StiffSolver<kSize>::take_proof(const StiffPlanes<kSize>& planes, const ActiveSet<kSize>& set) {
  Lanes rest = Lanes::Zero();
  planes.add_push(set, -1.0, rest);
  const auto l = joint_multipliers(set, rest);
  for (int i = 0; i < model_.joints; ++i) report_.multiplier[i] = l[i];
  report_.cause = StiffCause::kTorques;
  const double over_arm = 1.0 / problem_.length_m;
  for (int j = 0; j < set.active; ++j) {
    const auto* const plane = planes.plane(set.id[j]);
    if (plane == nullptr || !(set.multiplier[j] > 0.0)) continue;
    const double u = set.multiplier[j] * plane->over_length;
    if (plane->finger >= 0) {
      for (int i = 0; i < model_.finger[plane->finger].joints; ++i) {
        for (int c = 0; c < model_.finger[plane->finger].joints; ++c) {
          report_.Y[plane->finger](i, c) += u * plane->e[i] * plane->e[c];
        }
      }
      if (report_.cause == StiffCause::kTorques) report_.cause = StiffCause::kPosture;
      continue;
    }
    report_.cause = StiffCause::kStiffness;
    Eigen::Matrix<double, 6, 1> v = plane->e.matrix().template head<6>();
    v.tail<3>() *= over_arm;
    report_.Z += u * v * v.transpose();
    for (int k = 0; k < model_.fingers; ++k) {
      const double* const z = plane->z.data() + model_.finger[k].first;
      for (int i = 0; i < model_.finger[k].joints; ++i) {
        report_.motion[k].col(i) += u * z[i] * v;
        for (int c = 0; c < model_.finger[k].joints; ++c) report_.bend[k](i, c) += u * z[i] * z[c];
      }
    }
  }
}

template <int kSize>
bool StiffSolver<kSize>::cold() {
  ActiveSet<kSize> set;
  Lanes x;
  if (!start(set, x)) {
    report_.status = MuscleStatus::kInfeasible;
    return true;
  }
  StiffPlanes<kSize> planes(model_);
  bool resume = false;
  for (const double left : kLeft) {
    planes.left = left;
    const ActiveSetReport found = project(planes, set, x, 0.0, resume);
    resume = true;
    report_.iterations += found.changes;
    if (found.status == ActiveSetStatus::kBudgetSpent) return false;
    if (found.status == ActiveSetStatus::kInfeasible) {
      take_proof(planes, set);
      report_.status = MuscleStatus::kInfeasible;
      return true;
    }
    take_candidate(planes, set, x);
    if (newton_.run(candidate_, kNewtonSteps, {kEnough, kTrusted}, report_.iterations)) {
      report_.status = MuscleStatus::kOptimal;
      return true;
    }
  }
  return false;
}

template <int kSize>
void StiffSolver<kSize>::take_optimum(Eigen::Ref<VectorXd> found) {
  found = candidate_.x.head(model_.muscles).matrix();
  report_.status = MuscleStatus::kOptimal;
  if (model_.has_squeeze) report_.squeeze = candidate_.x[model_.muscles] / std::sqrt(problem_.squeeze->weight);
  for (int i = 0; i < model_.joints; ++i) report_.multiplier[i] = candidate_.l[i];
  const double over_arm = 1.0 / problem_.length_m;
  for (int i = 0; i < 6; ++i) {
    for (int c = 0; c < 6; ++c) {
      report_.Z(i, c) = candidate_.Z[i][c] * (i < 3 ? 1.0 : over_arm) * (c < 3 ? 1.0 : over_arm);
    }
  }
  for (int k = 0; k < model_.fingers; ++k) {
    for (int i = 0; i < kMaxStiffJoints; ++i) {
      for (int c = 0; c < kMaxStiffJoints; ++c) report_.Y[k](i, c) = candidate_.Y[k][i][c];
    }
  }
}

/// Keeps a proved optimum as the next start.
template <int kSize>
void StiffSolver<kSize>::leave(StiffWarmStart& last) const {
  const bool follows = last.is_set && last.variables == model_.variables && last.joints == model_.joints &&
                       last.fingers == model_.fingers;
  const auto keep = [&](const auto& now, auto&& at, auto&& way, auto&& bend) {
    if (follows) {
      bend = now - at - way;
      way = now - at;
    } else {
      way.setZero();
      bend.setZero();
    }
    at = now;
  };
  const auto n = model_.variables;
  const Eigen::Matrix<double, kSize, 1> x = candidate_.x.matrix();
  last.order = 0;
  if (follows) {
    const double far = (x.head(n) - last.at.x.head(n)).squaredNorm();
    const double along = (x.head(n) - last.at.x.head(n) - last.way.x.head(n)).squaredNorm();
    const double bent = (x.head(n) - last.at.x.head(n) - last.way.x.head(n) - last.bend.x.head(n)).squaredNorm();
    if (along < 0.25 * far) last.order = 1;
    if (bent < 0.25 * std::min(far, along)) last.order = 2;
  }
  keep(x.head(n), last.at.x.head(n), last.way.x.head(n), last.bend.x.head(n));
  const auto m = model_.joints;
  keep(Eigen::Map<const VectorXd>(candidate_.l.data(), m), last.at.l.head(m), last.way.l.head(m), last.bend.l.head(m));
  Matrix6d Z;
  for (int i = 0; i < 6; ++i) {
    Z.row(i) = candidate_.Z[i].matrix().template head<6>().transpose();
    last.basis.row(i) = newton_.seed[i].matrix().template head<6>().transpose();
  }
  keep(Z, last.at.Z, last.way.Z, last.bend.Z);
  for (int k = 0; k < model_.fingers; ++k) keep(report_.Y[k], last.at.Y[k], last.way.Y[k], last.bend.Y[k]);
  last.variables = n;
  last.joints = model_.joints;
  last.fingers = model_.fingers;
}

bool is_usable(const StiffMuscleProblem& p) {
  // No sum of zeros has a number that is none.
  const auto finite = [](const auto& m) {
    double sum = 0.0;
    for (Index c = 0; c < m.cols(); ++c) sum += (0.0 * m.col(c).array()).sum();
    return sum == 0.0;
  };
  if (!finite(p.H) || !finite(p.tau) || !finite(p.arm) || !finite(p.turn) || !finite(p.fibre_per_m) || !finite(p.A) ||
      !finite(p.B) || !finite(p.D) || !finite(p.K_des) || !std::isfinite(p.kappa) || !std::isfinite(p.length_m)) {
    return false;
  }
  if (!(p.limit.array() >= 0.0).all() || !(p.tendon_N_per_m.array() > 0.0).all()) return false;
  if (!(p.fibre_per_m.array() > 0.0).all() || !(p.length_m > 0.0)) return false;
  if (p.squeeze == nullptr) return true;
  const StiffSqueeze& s = *p.squeeze;
  return finite(s.tau) && finite(s.A) && finite(s.B) && finite(s.D) && s.low <= s.high && s.weight > 0.0 &&
         std::isfinite(s.low) && std::isfinite(s.weight);
}

/// Checks the proof of an answer, of an optimum up to this error.
void finish(const StiffMuscleProblem& problem, const Eigen::Ref<const VectorXd>& found, double trusted,
            StiffMuscleReport& report, Eigen::Ref<VectorXd> f) {
  bool is_proved = false;
  if (report.status == MuscleStatus::kOptimal) {
    report.residual = stiff_kkt_error(problem, found, report);
    is_proved = report.residual <= trusted;
    if (is_proved) f = found;
  } else if (report.status == MuscleStatus::kInfeasible) {
    report.residual = stiff_infeasibility_gap(problem, report);
    is_proved = report.residual < 1.0;
  }
  if (!is_proved) report.status = MuscleStatus::kBudgetSpent;
}

void clear(const StiffMuscleProblem& problem, StiffMuscleReport& report) {
  report.multiplier.setZero(problem.H.rows());
  report.Z.setZero();
  for (std::size_t k = 0; k < problem.joints.size(); ++k) {
    report.Y[k].setZero();
    report.motion[k].setZero();
    report.bend[k].setZero();
  }
}

/// Solves from the last optimum; false if that fails.
template <int kSize>
bool solve_warm(const StiffMuscleProblem& problem, const StiffWarmStart& last, StiffSolver<kSize>& solver,
                StiffMuscleReport& report, Eigen::Ref<VectorXd> found, Eigen::Ref<VectorXd> f) {
  if (!solver.resume(last)) return false;
  for (const double unseen : {kUnseen, 0.0}) {
    if (!solver.warm(unseen)) break;
    solver.take_optimum(found);
    finish(problem, found, unseen > 0.0 ? kTrusted : kProved, report, f);
    if (report.status == MuscleStatus::kOptimal) return true;
  }
  clear(problem, report);
  return false;
}

template <int kSize>
void solve_in_lanes(const StiffMuscleProblem& problem, StiffWarmStart* last, StiffMuscleReport& report,
                    Eigen::Ref<VectorXd> f) {
  std::array<double, kMaxMuscles> memory;
  Eigen::Map<VectorXd> found(memory.data(), problem.H.cols());
  StiffSolver<kSize> solver(problem, report);
  if (last != nullptr && solve_warm(problem, *last, solver, report, found, f)) {
    solver.leave(*last);
    return;
  }
  if (last != nullptr) last->is_set = false;
  if (problem.squeeze == nullptr) {
    const MuscleReport alone = solve_muscle_forces({problem.H, problem.tau, problem.limit}, found);
    report.iterations += alone.iterations;
    report.multiplier = alone.multiplier;
    const bool is_enough = alone.status == MuscleStatus::kOptimal && solver.is_stiff(found);
    if (alone.status == MuscleStatus::kInfeasible || is_enough) {
      report.status = alone.status;
      report.cause = is_enough ? StiffCause::kNone : StiffCause::kTorques;
      finish(problem, found, kProved, report, f);
      return;
    }
    report.multiplier.setZero();
  }
  if (solver.cold() && report.status == MuscleStatus::kOptimal) solver.take_optimum(found);
  finish(problem, found, kProved, report, f);
  if (last == nullptr || report.status != MuscleStatus::kOptimal) return;
  solver.leave(*last);
  last->is_set = true;
}

StiffMuscleReport solve(const StiffMuscleProblem& problem, StiffWarmStart* last, Eigen::Ref<VectorXd> f) {
  const Index muscles = problem.H.cols();
  assert(problem.H.rows() <= kMaxJoints && muscles <= kMaxMuscles && problem.tau.size() == problem.H.rows());
  assert(f.size() == muscles);
  StiffMuscleReport report;
  clear(problem, report);
  if (!is_usable(problem)) return report;
  const Index variables = muscles + (problem.squeeze != nullptr ? 1 : 0);
  if (variables <= 24) {
    solve_in_lanes<24>(problem, last, report, f);
  } else if (variables <= 40) {
    solve_in_lanes<40>(problem, last, report, f);
  } else {
    solve_in_lanes<static_cast<int>(kMaxMuscles) + 8>(problem, last, report, f);
  }
  return report;
}

}  // namespace

StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem, Eigen::Ref<VectorXd> f) noexcept {
  return solve(problem, nullptr, f);
}

StiffMuscleReport solve_stiff_muscles(const StiffMuscleProblem& problem, StiffWarmStart& last,
                                      Eigen::Ref<VectorXd> f) noexcept {
  return solve(problem, &last, f);
}

StiffLack find_stiff_lack(const StiffMuscleProblem& p) noexcept {
  constexpr double kAccurate = 1e-3;
  Eigen::Matrix<double, 6, 1> unit;
  unit << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(p.length_m * p.length_m);
  std::array<double, kMaxMuscles> memory;
  Eigen::Map<VectorXd> f(memory.data(), p.H.cols());
  // The lack with reduced stiffness and postures.
  const auto lack_below = [&](double less, double less_bent, StiffLack& lack) {
    Matrix6d K_des = p.K_des;
    K_des.diagonal() -= less * unit;
    const StiffMuscleProblem relaxed{p.H,
                                     p.tau,
                                     p.limit,
                                     p.joints,
                                     p.arm,
                                     p.turn,
                                     p.fibre_per_m,
                                     p.tendon_N_per_m,
                                     p.A,
                                     p.B,
                                     p.D,
                                     K_des,
                                     p.kappa - less_bent,
                                     p.squeeze,
                                     p.length_m};
    const StiffMuscleReport report = solve(relaxed, nullptr, f);
    if (report.status != MuscleStatus::kInfeasible || report.cause == StiffCause::kTorques) return StiffCause::kNone;
    lack = stiff_lack(relaxed, report);
    lack.lacking_N_per_m += less;
    lack.lacking_Nm_per_rad += less_bent;
    return report.cause;
  };
  StiffLack best;
  const StiffCause cause = lack_below(0.0, 0.0, best);
  if (cause == StiffCause::kNone) return best;
  const bool is_posture = cause == StiffCause::kPosture;
  double low = is_posture ? best.lacking_Nm_per_rad : best.lacking_N_per_m;
  double high = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 100 && !(high <= (1.0 + kAccurate) * low); ++k) {
    const double middle = std::isinf(high) ? 2.0 * low : 0.5 * (low + high);
    StiffLack lack;
    if (lack_below(is_posture ? 0.0 : middle, is_posture ? middle : 0.0, lack) == cause) {
      best = lack;
      low = std::max(middle, is_posture ? lack.lacking_Nm_per_rad : lack.lacking_N_per_m);
    } else {
      high = middle;
    }
  }
  return best;
}

}  // namespace thenar
