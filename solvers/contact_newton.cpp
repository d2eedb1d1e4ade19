// SPDX-License-Identifier: Apache-2.0
#include "solvers/contact_newton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "solvers/gauss_seidel.h"
#include "solvers/natural_map.h"
#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

// Springs stiffen from W's own compliance to where they change a result negligibly, in steps of a tenth at first; a
// step that fails in Newton's method is shortened to its square root, one that succeeds is squared.
constexpr double kSoftest = 1.0, kStiffest = 1e-10;
constexpr double kFirstStep = 0.1, kLongestStep = 0.01, kShortestStep = 0.93;
// Springs for the proximal iteration, and how often each is relaxed.
constexpr std::array<double, 4> kProximalSprings{1e-2, 1e-3, 1e-4, 1e-5};
constexpr int kRelaxations = 20;
// A stage only has to lead to the next one, but near the end it has to be right.
constexpr double kStageTolerance = 1e-4, kFineTolerance = 1e-10, kFineFrom = 1e-6;
constexpr int kStageSteps = 15, kLastSteps = 40, kHalvings = 12;
// rho of Alart and Curnier's map, over that of the residual. It moves the borders between Newton's pieces: where one
// cycles another often does not. In this order they solved most of the random families.
constexpr std::array<double, 3> kPushes{10.0, 1.0, 100.0};
constexpr double kLastPush = 3.0;
// Keeps a singular W from stopping a stage without springs; far below any W that counts.
constexpr double kRegularisation = 1e-14;
// Forces so many times larger than the problem's own are taken for infinite.
constexpr double kInfiniteForce = 1e9;

Rows rows_of(const VectorRef& v, Index i) { return {v[3 * i], v[3 * i + 1], v[3 * i + 2]}; }

/// Returns tr(W_ii)/3.
double mean_compliance(const MatrixRef& W, Index i) {
  return (W(3 * i, 3 * i) + W(3 * i + 1, 3 * i + 1) + W(3 * i + 2, 3 * i + 2)) / 3.0;
}

/// The problem with a spring of compliance eta tr(W_ii)/3 behind every contact, relaxed at the forces `centre`:
///     delta = W f + delta_free + eta tr(W_ii)/3 (f - centre).
/// The larger eta, the easier; with 0 it is the problem itself, as it is for any eta if `centre` solves it.
struct Stage {
  const ContactProblem& problem;
  VectorRef centre;
  double eta;
  double push;

  [[nodiscard]] Index contacts() const { return problem.mu.size(); }
  [[nodiscard]] double spring(Index i) const { return eta * mean_compliance(problem.W, i); }
  /// Returns rho; zero for a contact that no force moves.
  [[nodiscard]] double rho(Index i) const {
    const double compliance = (1.0 + eta) * mean_compliance(problem.W, i);
    return compliance > 0.0 ? push / compliance : 0.0;
  }
};

void gaps(const Stage& stage, const VectorRef& f, VectorOut delta) {
  delta = stage.problem.delta_free;
  for (Index i = 0; i < stage.contacts(); ++i) {
    const auto f_i = f.segment<3>(3 * i);
    if (!f_i.isZero(0.0)) delta.noalias() += stage.problem.W.middleCols<3>(3 * i).lazyProduct(f_i);
    delta.segment<3>(3 * i) += stage.spring(i) * (f_i - stage.centre.segment<3>(3 * i));
  }
}

/// The error of one contact by Alart and Curnier's map, with x = f - rho delta:
///     e_n = f_n - max(0, x_n),    e_t = f_t - x_t scaled back to |x_t| <= mu max(0, x_n),
/// and the parts of its derivative: d e_n = rho d(delta_n), d e_t = df_t - mu c dx_n - G dx_t where it slides.
struct LocalError {
  Rows error;
  double rho;
  bool pressed = false;
  bool slides = false;
  double mu_c_1 = 0.0, mu_c_2 = 0.0;
  double G_11 = 1.0, G_12 = 0.0, G_22 = 1.0;

  /// Returns the part of the derivative by delta.
  [[nodiscard]] Rows along(const Rows& delta) const {
    return {rho * delta.n, rho * (mu_c_1 * delta.n + G_11 * delta.t1 + G_12 * delta.t2),
            rho * (mu_c_2 * delta.n + G_12 * delta.t1 + G_22 * delta.t2)};
  }
};

LocalError local_error(const Stage& stage, Index i, const VectorRef& f, const VectorRef& delta) {
  const Rows f_i = rows_of(f, i), delta_i = rows_of(delta, i);
  const double rho = stage.rho(i), mu = stage.problem.mu[i];
  const double x_n = f_i.n - rho * delta_i.n;
  if (rho == 0.0 || !(x_n > 0.0)) return {f_i, rho};

  const double x_1 = f_i.t1 - rho * delta_i.t1, x_2 = f_i.t2 - rho * delta_i.t2;
  const double limit = mu * x_n, x_t = std::sqrt(x_1 * x_1 + x_2 * x_2);
  LocalError local{{rho * delta_i.n, rho * delta_i.t1, rho * delta_i.t2}, rho, true};
  if (x_t <= limit) return local;
  const double c_1 = x_1 / x_t, c_2 = x_2 / x_t, part = limit / x_t;
  local.error.t1 = f_i.t1 - part * x_1;
  local.error.t2 = f_i.t2 - part * x_2;
  local.slides = true;
  local.mu_c_1 = mu * c_1;
  local.mu_c_2 = mu * c_2;
  local.G_11 = part * (1.0 - c_1 * c_1);
  local.G_12 = -part * c_1 * c_2;
  local.G_22 = part * (1.0 - c_2 * c_2);
  return local;
}

double error_N(const Stage& stage, const VectorRef& f, const VectorRef& delta) {
  double sum = 0.0;
  for (Index i = 0; i < stage.contacts(); ++i) {
    const Rows e = local_error(stage, i, f, delta).error;
    sum += e.n * e.n + e.t1 * e.t1 + e.t2 * e.t2;
  }
  return std::sqrt(sum);
}

/// Solves A x = b by elimination with partial pivoting: A is spent, b becomes x. False if A is singular.
bool solve_in_place(Eigen::Ref<MatrixXd> A, VectorOut b) {
  constexpr Index kPanel = 8;  // Columns that are eliminated at once: their factors stay in registers and in L1.
  const Index n = A.rows();
  std::array<Index, kPanel> pivot{};
  for (Index k = 0; k < n; k += kPanel) {
    const Index width = std::min(kPanel, n - k), rest = n - k - width;
    for (Index j = 0; j < width; ++j) {
      const Index c = k + j;
      Index largest = 0;
      const double size = A.col(c).tail(n - c).cwiseAbs().maxCoeff(&largest);
      if (!(size > 0.0) || !std::isfinite(size)) return false;
      pivot[j] = c + largest;
      A.row(c).segment(k, width).swap(A.row(pivot[j]).segment(k, width));
      auto below = A.col(c).tail(n - c - 1);
      below /= A(c, c);
      for (Index m = c + 1; m < k + width; ++m) A.col(m).tail(n - c - 1).noalias() -= A(c, m) * below;
    }
    const auto eliminate = [&](auto&& column) {
      for (Index j = 0; j < width; ++j) std::swap(column[k + j], column[pivot[j]]);
      for (Index j = 0; j < width; ++j) {
        for (Index m = j + 1; m < width; ++m) column[k + m] -= A(k + m, k + j) * column[k + j];
      }
      if (rest == 0) return;
      const Eigen::Matrix<double, kPanel, 1> top = column.template segment<kPanel>(k);
      column.tail(rest).noalias() -=
          A.block(k + kPanel, k, rest, kPanel).template middleCols<kPanel>(0).lazyProduct(top);
    };
    for (Index m = k + width; m < n; ++m) eliminate(A.col(m));
    eliminate(b);
  }
  for (Index k = n - 1; k >= 0; --k) {
    b[k] /= A(k, k);
    b.head(k).noalias() -= b[k] * A.col(k).head(k);
  }
  return b.allFinite();
}

/// Takes Newton's step: forces of open contacts vanish, others solve their linearised laws. False if not finite.
bool newton_step(const Stage& stage, const VectorRef& f, const VectorRef& delta, AccurateWorkspace& work,
                 VectorOut step) {
  auto motion = work.motion.head(f.size());  // of the gaps, by the forces that go
  motion.setZero();
  work.active.clear();
  for (Index i = 0; i < stage.contacts(); ++i) {
    if (local_error(stage, i, f, delta).pressed) {
      work.active.push_back(i);
      continue;
    }
    auto step_i = step.segment<3>(3 * i);
    step_i = -f.segment<3>(3 * i);
    if (!step_i.isZero(0.0)) motion.noalias() += stage.problem.W.middleCols<3>(3 * i).lazyProduct(step_i);
  }

  const Index n = std::ssize(work.active);
  Eigen::Map<MatrixXd> J(work.jacobian.data(), 3 * n, 3 * n);
  auto right = work.right.head(3 * n);
  for (Index a = 0; a < n; ++a) {
    const Index i = work.active[a];
    const LocalError local = local_error(stage, i, f, delta);
    const auto set = [&](Index column, const Rows& rows) {
      J(3 * a, column) = rows.n;
      J(3 * a + 1, column) = rows.t1;
      J(3 * a + 2, column) = rows.t2;
    };
    for (Index b = 0; b < n; ++b) {
      for (Index k = 0; k < 3; ++k)
        set(3 * b + k, local.along(rows_of(stage.problem.W.col(3 * work.active[b] + k), i)));
    }
    const double spring = stage.spring(i);
    auto J_ii = J.block<3, 3>(3 * a, 3 * a);
    const std::array<Rows, 3> axis{{{spring, 0.0, 0.0}, {0.0, spring, 0.0}, {0.0, 0.0, spring}}};
    for (Index k = 0; k < 3; ++k) {
      const Rows rows = local.along(axis[k]);
      J_ii.col(k) += Eigen::Vector3d(rows.n, rows.t1, rows.t2);
    }
    if (local.slides) {
      J_ii.col(0).tail<2>() -= Eigen::Vector2d(local.mu_c_1, local.mu_c_2);
      J_ii.col(1).tail<2>() += Eigen::Vector2d(1.0 - local.G_11, -local.G_12);
      J_ii.col(2).tail<2>() += Eigen::Vector2d(-local.G_12, 1.0 - local.G_22);
    }
    J_ii.diagonal().array() += kRegularisation;
    const Rows moved = local.along(rows_of(motion, i));
    right.segment<3>(3 * a) << -local.error.n - moved.n, -local.error.t1 - moved.t1, -local.error.t2 - moved.t2;
  }
  if (!solve_in_place(J, right)) return false;
  for (Index a = 0; a < n; ++a) step.segment<3>(3 * work.active[a]) = right.segment<3>(3 * a);
  return true;
}

/// Applies Newton's method to one stage, from f to f; returns the remaining error [N].
double newton(const Stage& stage, double tolerance_N, int max_steps, AccurateWorkspace& work, VectorOut f, int& steps) {
  auto delta = work.delta.head(f.size());
  auto step = work.step.head(f.size());
  auto trial_f = work.trial_f.head(f.size());
  auto trial_delta = work.trial_delta.head(f.size());
  gaps(stage, f, delta);
  double error = error_N(stage, f, delta);
  for (int k = 0; k < max_steps && error > tolerance_N; ++k) {
    if (!newton_step(stage, f, delta, work, step)) return std::numeric_limits<double>::infinity();
    ++steps;
    const auto try_part = [&](double part) {
      trial_f = f + part * step;
      gaps(stage, trial_f, trial_delta);
      return error_N(stage, trial_f, trial_delta);
    };
    double part = 1.0, trial_error = try_part(part);
    for (int halving = 0; halving < kHalvings && !(trial_error < (1.0 - 1e-4 * part) * error); ++halving) {
      part *= 0.5;
      trial_error = try_part(part);
    }
    // Where no part of the step helps, the whole step leads to another piece of the map.
    if (!(trial_error < error)) trial_error = try_part(1.0);
    f = trial_f;
    delta = trial_delta;
    error = trial_error;
  }
  return error;
}

/// The shared state of the stages of one accurate solve.
struct Solve {
  const ContactProblem& problem;
  const AccurateSettings& settings;
  AccurateWorkspace& work;
  ContactSolution& best;  // so far
  AccurateReport report;
  double scale_N;  // of the residual

  [[nodiscard]] bool solved() const { return report.solve.residual <= settings.tolerance; }
  [[nodiscard]] int steps(int most) const { return std::min(most, settings.max_steps - report.steps); }
  [[nodiscard]] VectorRef zero() const { return work.zero.head(best.f.size()); }
};

/// Keeps forces, clamped into their cones, if their residual in the problem itself is the least so far.
void keep_if_better(Solve& solve, const VectorRef& candidate) {
  auto f = solve.work.trial_f.head(candidate.size());
  auto delta = solve.work.trial_delta.head(candidate.size());
  for (Index i = 0; i < solve.problem.mu.size(); ++i) {
    const Rows inside = inside_cone(rows_of(candidate, i), solve.problem.mu[i]);
    f.segment<3>(3 * i) << inside.n, inside.t1, inside.t2;
  }
  if (!f.allFinite()) return;
  gaps({solve.problem, solve.zero(), 0.0, 1.0}, f, delta);
  const Residual residual = natural_map(solve.problem, f, delta);
  if (!(residual.norm < solve.report.solve.residual) || !delta.allFinite()) return;
  solve.best.f = f;
  solve.best.delta = delta;
  solve.report.solve.residual = residual.norm;
  solve.report.solve.residual_worst = residual.worst;
}

/// Solves one stage from `start` to f, with the first rho that reaches kStageTolerance, if any does.
bool solve_stage(Solve& solve, double eta, const VectorRef& centre, const VectorRef& start, double tolerance_N,
                 VectorOut f) {
  for (const double push : kPushes) {
    f = start;
    const Stage stage{solve.problem, centre, eta, push};
    const double error_N = newton(stage, tolerance_N, solve.steps(kStageSteps), solve.work, f, solve.report.steps);
    if (error_N <= kStageTolerance * solve.scale_N) return true;
  }
  return false;
}

/// Solves the stages from soft springs to none, each from the last one's forces.
void follow_stiffening_springs(Solve& solve) {
  auto f = solve.work.f.head(solve.best.f.size());
  auto last_good = solve.work.last_good.head(solve.best.f.size());
  last_good = solve.best.f;
  double eta = kSoftest, good_eta = kSoftest / kFirstStep, factor = kFirstStep;
  while (!solve.solved() && eta >= kStiffest && factor <= kShortestStep && solve.steps(1) > 0) {
    const double wanted_N = (eta < kFineFrom ? kFineTolerance : kStageTolerance) * solve.scale_N;
    const bool good = solve_stage(solve, eta, solve.zero(), last_good, wanted_N, f);
    keep_if_better(solve, f);
    if (good) {
      last_good = f;
      good_eta = eta;
      factor = std::max(kLongestStep, factor * factor);
    } else {
      factor = std::sqrt(factor);
    }
    eta = good_eta * factor;
  }
  if (solve.solved()) return;
  f = solve.best.f;
  const Stage last{solve.problem, solve.zero(), 0.0, kLastPush};
  newton(last, 0.3 * solve.settings.tolerance * solve.scale_N, solve.steps(kLastSteps), solve.work, f,
         solve.report.steps);
  keep_if_better(solve, f);
}

/// Applies the proximal point method [Rockafellar 1976]: springs that are repeatedly relaxed at the last forces have no
/// effect in the limit. It is slower than stiffening them, but every stage begins close to its solution.
void relax_springs(Solve& solve) {
  auto f = solve.work.f.head(solve.best.f.size());
  auto centre = solve.work.last_good.head(solve.best.f.size());
  for (const double eta : kProximalSprings) {
    centre = solve.best.f;
    for (int k = 0; k < kRelaxations && !solve.solved() && solve.steps(1) > 0; ++k) {
      if (!solve_stage(solve, eta, centre, centre, 0.01 * solve.settings.tolerance * solve.scale_N, f)) break;
      keep_if_better(solve, f);
      centre = f;
    }
  }
}

/// Searches normal forces y >= 0 with W y = 0 and y.delta_free < 0. Any solution then has f.W y >= -y.delta_free, which
/// bounds |f| from below: the bound distinguishes a proof from rounding.
///
/// Without friction the forces of stiffening springs minimise a convex energy. Where that has no minimum they grow
/// along such a y, and so does, exactly, each step of springs that are repeatedly relaxed at the last forces.
bool find_certificate(Solve& solve) {
  // It has to be found also where the Newton steps of the solve are spent.
  constexpr int kSteps = 25, kDirections = 4;
  constexpr double kSpring = 1e-4;
  const Index n = solve.problem.mu.size();
  const ContactProblem frictionless{solve.problem.W, solve.problem.delta_free, solve.work.zero.head(n)};
  auto f = solve.work.f.head(3 * n);
  auto centre = solve.work.last_good.head(3 * n);
  f.setZero();
  for (double eta = kSoftest; eta >= kSpring; eta *= kFirstStep) {
    const Stage stage{frictionless, solve.zero(), eta, 1.0};
    newton(stage, kFineTolerance * solve.scale_N, kSteps, solve.work, f, solve.report.steps);
  }
  auto y = solve.work.certificate.head(n);
  auto motion = solve.work.motion.head(3 * n);
  for (int k = 0; k < kDirections; ++k) {
    centre = f;
    const Stage stage{frictionless, centre, kSpring, 1.0};
    newton(stage, kFineTolerance * solve.scale_N, kSteps, solve.work, f, solve.report.steps);
    for (Index i = 0; i < n; ++i) y[i] = std::max(0.0, f[3 * i] - centre[3 * i]);
    const double largest = y.maxCoeff();
    if (!(largest > 0.0) || !y.allFinite()) break;
    y /= largest;
    motion.setZero();
    double closed_m = 0.0;
    for (Index i = 0; i < n; ++i) {
      motion += y[i] * solve.problem.W.row(3 * i).transpose();
      closed_m -= y[i] * solve.problem.delta_free[3 * i];
    }
    if (closed_m > kInfiniteForce * solve.scale_N * motion.norm()) return true;
  }
  y.setZero();
  return false;
}

/// Marks closed contacts that no force opens in the certificate, each a proof of its own.
bool find_pressed_immovable(Solve& solve) {
  const double touching = touching_m(solve.problem.delta_free);
  bool found = false;
  for (Index i = 0; i < solve.problem.mu.size(); ++i) {
    if (solve.problem.W(3 * i, 3 * i) > 0.0 || solve.problem.delta_free[3 * i] >= -touching) continue;
    solve.work.certificate[i] = 1.0;
    found = true;
  }
  return found;
}

}  // namespace

AccurateWorkspace::AccurateWorkspace(Index contacts)
    : certificate(VectorXd::Zero(contacts)),
      sweeps(contacts),
      jacobian(3 * contacts, 3 * contacts),
      f(3 * contacts),
      last_good(3 * contacts),
      delta(3 * contacts),
      right(3 * contacts),
      step(3 * contacts),
      motion(3 * contacts),
      trial_f(3 * contacts),
      trial_delta(3 * contacts),
      zero(VectorXd::Zero(3 * contacts)) {
  active.reserve(contacts);
}

AccurateReport solve_contacts_accurately(const ContactProblem& problem, const AccurateSettings& settings,
                                         AccurateWorkspace& work, ContactSolution solution) noexcept {
  work.certificate.setZero();
  const GaussSeidelSettings first{.tolerance = settings.tolerance, .max_sweeps = settings.max_sweeps};
  const SolveReport swept = solve_contacts(problem, first, work.sweeps, solution);
  Solve solve{problem, settings, work, solution, {swept}, residual_scale_N(problem)};
  SolveReport& report = solve.report.solve;
  if (report.status == SolveStatus::kConverged || report.status == SolveStatus::kNotFinite) return solve.report;
  // A contact that is pressed and that no force opens is proof enough, whatever became of the others.
  if (find_pressed_immovable(solve)) {
    report.status = SolveStatus::kNoSolution;
    return solve.report;
  }

  follow_stiffening_springs(solve);
  if (!solve.solved() && find_certificate(solve)) {
    report.status = SolveStatus::kNoSolution;
    return solve.report;
  }
  relax_springs(solve);
  if (solve.solved()) report.status = SolveStatus::kConverged;
  return solve.report;
}

}  // namespace thenar
