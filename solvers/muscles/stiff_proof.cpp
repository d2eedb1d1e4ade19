// SPDX-License-Identifier: Apache-2.0
#include "solvers/muscles/stiff_proof.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "solvers/muscles/stiff_model.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using VectorRef = Eigen::Ref<const VectorXd>;
using FingerWrenches = Eigen::Matrix<double, 6, kMaxStiffJoints>;
using FingerMotions = Eigen::Matrix<double, kMaxStiffJoints, 6, Eigen::RowMajor>;
/// One number for each pair of joints of one finger, in the order of the rows of `turn`.
using Pairs = std::array<double, 3 * kMaxJoints>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A muscle without a limit counts as able to pull this many times what is asked for.
constexpr double kOutOfReach = 1e6;
// Weights are sums of squares: negative parts below this share are rounding.
constexpr double kRounding = 1e-12;

int first_joint(const StiffMuscleProblem& p, int finger) {
  int first = 0;
  for (int k = 0; k < finger; ++k) first += p.joints[k];
  return first;
}

int first_pair(const StiffMuscleProblem& p, int finger) {
  int first = 0;
  for (int k = 0; k < finger; ++k) first += p.joints[k] * (p.joints[k] + 1) / 2;
  return first;
}

double tendon_of(const StiffMuscleProblem& p, Index j) {
  return p.tendon_N_per_m.size() > 0 ? 1.0 / p.tendon_N_per_m[j] : 0.0;
}

/// Returns B_k + s B_1k; columns beyond the finger's joints are zero.
FingerWrenches wrenches(const StiffMuscleProblem& p, int finger, double s) {
  const int first = first_joint(p, finger), n = p.joints[finger];
  FingerWrenches B = FingerWrenches::Zero();
  B.leftCols(n) = p.B.middleCols(first, n);
  if (p.squeeze != nullptr) B.leftCols(n) += s * p.squeeze->B.middleCols(first, n);
  return B;
}

/// Returns the weights of <X_k, dM_k> for each pair of joints, in both orders.
Pairs pair_weights(const StiffMuscleProblem& p, const std::array<FingerMatrix, kMaxStiffFingers>& X) {
  Pairs weights;
  int pair = 0;
  for (int k = 0; k < std::ssize(p.joints); ++k) {
    for (int i = 0; i < p.joints[k]; ++i) {
      for (int c = 0; c < i; ++c) weights[pair++] = X[k](i, c) + X[k](c, i);
      weights[pair++] = X[k](i, i);
    }
  }
  return weights;
}

/// Calls visit(pair, a_i a_c) for the pairs of joints about which a muscle has arms.
template <class Visit>
void for_each_arm_pair(const StiffMuscleProblem& p, Index muscle, const Visit& visit) {
  const double* arm = p.arm.col(muscle).data();
  int pair = 0;
  for (const int joints : p.joints) {
    for (int i = 0; i < joints; pair += ++i) {
      // Most muscles are of one finger.
      for (int c = 0; c <= i && arm[i] != 0.0; ++c) visit(pair + c, arm[i] * arm[c]);
    }
    arm += joints;
  }
}

/// The coefficients of sum_k <X_k, M_k> = alpha s_j + beta f_j of a muscle.
struct MuscleShare {
  double alpha = 0.0, beta = 0.0;
};

MuscleShare share_of(const StiffMuscleProblem& p, Index muscle, const Pairs& weights) {
  MuscleShare share;
  for_each_arm_pair(p, muscle, [&](int pair, double square) { share.alpha += weights[pair] * square; });
  share.beta = -p.turn.col(muscle).dot(Eigen::Map<const VectorXd>(weights.data(), p.turn.rows()));
  return share;
}

/// Computes M_k of all fingers, by pairs of joints.
Pairs muscle_parts(const StiffMuscleProblem& p, const VectorRef& f) {
  Pairs M;
  Eigen::Map<VectorXd> all(M.data(), p.turn.rows());
  all.setZero();
  for (Index j = 0; j < f.size(); ++j) {
    if (f[j] == 0.0) continue;
    const double spring = f[j] / (1.0 / p.fibre_per_m[j] + f[j] * tendon_of(p, j));
    all -= f[j] * p.turn.col(j);
    for_each_arm_pair(p, j, [&](int pair, double square) { M[pair] += spring * square; });
  }
  return M;
}

/// Returns D_k + M_k, from M_k by pairs.
FingerMatrix finger_stiffness(const StiffMuscleProblem& p, int finger, const Pairs& M, double squeeze) {
  const int first = first_joint(p, finger), n = p.joints[finger];
  int pair = first_pair(p, finger);
  FingerMatrix P = FingerMatrix::Zero();
  for (int i = 0; i < n; ++i) {
    for (int c = 0; c <= i; ++c) {
      const double D_1 = p.squeeze != nullptr ? squeeze * p.squeeze->D(first + i, first + c) : 0.0;
      P(i, c) = P(c, i) = p.D(first + i, first + c) + D_1 + M[pair++];
    }
  }
  return P;
}

template <class Matrix>
SmallSymmetric widened(const Matrix& X, int n) {
  SmallSymmetric wide;
  for (int i = 0; i < n; ++i) {
    wide[i].setZero();
    for (int c = 0; c < n; ++c) wide[i][c] = X(i, c);
  }
  return wide;
}

/// Bounds the negative part of X's first n rows, over `scale`: rounded up to the next power of ten from 1e-12 on.
template <class Matrix>
double lacking(const Matrix& X, int n, double scale) {
  const SmallSymmetric wide = widened(X, n);
  if (is_positive(n, wide, 0.0)) return 0.0;
  for (double share = 1e-12; share < 1e3; share *= 10.0) {
    if (is_positive(n, wide, share * scale)) return share;
  }
  return kInfinity;
}

/// Returns X with rotations scaled by length_m.
Matrix6d on_length(const Matrix6d& X, double over_length) {
  Eigen::Matrix<double, 6, 1> arms;
  arms << 1.0, 1.0, 1.0, over_length, over_length, over_length;
  return arms.asDiagonal() * X * arms.asDiagonal();
}

struct Scales {
  double stiffness, posture;
};

Scales scales(const StiffMuscleProblem& p) {
  Scales s{on_length(p.K_des, 1.0 / p.length_m).cwiseAbs().maxCoeff(), 0.0};
  if (s.stiffness == 0.0) s.stiffness = on_length(p.A, 1.0 / p.length_m).cwiseAbs().maxCoeff();
  double largest = 0.0;
  for (int k = 0, first = 0; k < std::ssize(p.joints); first += p.joints[k++]) {
    largest = std::max(largest, p.D.block(first, first, p.joints[k], p.joints[k]).cwiseAbs().maxCoeff());
  }
  s.posture = std::max(std::abs(p.kappa), 1e-6 * largest);
  if (s.stiffness == 0.0) s.stiffness = 1.0;
  if (s.posture == 0.0) s.posture = 1.0;
  return s;
}

/// Returns |H f - tau - s tau_1|, for each joint as a force on its longest arm.
double torque_error_N(const StiffMuscleProblem& p, const VectorRef& f, double s) {
  double worst = 0.0;
  for (Index i = 0; i < p.H.rows(); ++i) {
    const double error = p.H.row(i).dot(f) - p.tau[i] - (p.squeeze != nullptr ? s * p.squeeze->tau[i] : 0.0);
    double longest = p.H.row(i).lpNorm<Eigen::Infinity>();
    if (p.squeeze != nullptr) {
      longest = std::max(longest, std::abs(p.squeeze->tau[i]) / std::sqrt(p.squeeze->weight));
    }
    if (error != 0.0) worst = std::max(worst, std::abs(error) / longest);
  }
  return worst;
}

/// Computes the distance of forces and internal force from the multipliers' optimum; W are the weights of dM_k.
double pull_error_N(const StiffMuscleProblem& p, const VectorRef& f, const StiffMuscleReport& report,
                    const std::array<FingerMatrix, kMaxStiffFingers>& W, double squeeze_pull) {
  double worst = 0.0;
  const Pairs weights = pair_weights(p, W);
  for (Index j = 0; j < f.size(); ++j) {
    const double soft = 1.0 / p.fibre_per_m[j], give = soft + f[j] * tendon_of(p, j);
    const MuscleShare share = share_of(p, j, weights);
    const double pull = p.H.col(j).dot(report.multiplier) + soft / (give * give) * share.alpha + share.beta;
    const double limit = p.limit.size() > 0 ? p.limit[j] : kInfinity;
    worst = std::max(worst, std::abs(f[j] - std::min(std::max(0.0, pull), limit)));
  }
  if (p.squeeze != nullptr) {
    const double wanted = std::clamp(squeeze_pull / p.squeeze->weight, p.squeeze->low, p.squeeze->high);
    worst = std::max(worst, std::sqrt(p.squeeze->weight) * std::abs(report.squeeze - wanted));
  }
  return worst;
}

/// Computes (D_k + M_k)^-1 B_k'. False if D_k + M_k is not positive definite.
bool solve_finger(const FingerMatrix& P, int n, const FingerWrenches& B, FingerMotions& z) {
  // P = L D L', U = L D.
  using Rows = std::array<std::array<double, kMaxStiffJoints>, kMaxStiffJoints>;
  Rows L, U;
  std::array<double, kMaxStiffJoints> over;
  for (int i = 0; i < n; ++i) {
    double pivot = P(i, i);
    z.row(i) = B.col(i).transpose();
    for (int c = 0; c < i; ++c) {
      U[i][c] = P(i, c);
      for (int b = 0; b < c; ++b) U[i][c] -= U[i][b] * L[c][b];
      L[i][c] = U[i][c] * over[c];
      pivot -= U[i][c] * L[i][c];
      z.row(i) -= L[i][c] * z.row(c);
    }
    if (!(pivot > 0.0)) return false;
    over[i] = 1.0 / pivot;
  }
  for (int i = n - 1; i >= 0; --i) {
    z.row(i) *= over[i];
    for (int c = i + 1; c < n; ++c) z.row(i) -= L[c][i] * z.row(c);
  }
  z.bottomRows(kMaxStiffJoints - n).setZero();
  return true;
}

}  // namespace

FingerMatrix finger_stiffness(const StiffMuscleProblem& p, int finger, const VectorRef& f, double squeeze) noexcept {
  return finger_stiffness(p, finger, muscle_parts(p, f), squeeze);
}

bool object_stiffness(const StiffMuscleProblem& p, const VectorRef& f, double squeeze, Matrix6d& K_o) noexcept {
  const Pairs M = muscle_parts(p, f);
  K_o = p.A;
  if (p.squeeze != nullptr) K_o += squeeze * p.squeeze->A;
  for (int k = 0; k < std::ssize(p.joints); ++k) {
    FingerMotions z;
    const FingerWrenches B = wrenches(p, k, squeeze);
    if (!solve_finger(finger_stiffness(p, k, M, squeeze), p.joints[k], B, z)) {
      K_o.setConstant(std::numeric_limits<double>::quiet_NaN());
      return false;
    }
    K_o -= B.lazyProduct(z);
  }
  return true;
}

double stiff_kkt_error(const StiffMuscleProblem& p, const VectorRef& f, const StiffMuscleReport& report) noexcept {
  const double over = 1.0 / p.length_m, s = report.squeeze;
  const Scales scale = scales(p);
  Matrix6d K_o = p.A;
  double squeeze_pull = 0.0;
  if (p.squeeze != nullptr) {
    K_o += s * p.squeeze->A;
    squeeze_pull = report.Z.cwiseProduct(p.squeeze->A).sum() - p.squeeze->tau.dot(report.multiplier);
  }
  double effort = f.squaredNorm() + (p.squeeze != nullptr ? p.squeeze->weight * s * s : 0.0);
  double largest_N = f.cwiseAbs().maxCoeff();
  if (p.squeeze != nullptr) largest_N = std::max(largest_N, std::sqrt(p.squeeze->weight) * std::abs(s));
  effort = std::max(effort, 1e-300);

  double error = 0.0;
  const Pairs M = muscle_parts(p, f);
  std::array<FingerMatrix, kMaxStiffFingers> W;
  for (int k = 0; k < std::ssize(p.joints); ++k) {
    const int n = p.joints[k], first = first_joint(p, k);
    FingerMatrix P = finger_stiffness(p, k, M, s);
    const FingerWrenches B = wrenches(p, k, s);
    FingerMotions z;
    if (!solve_finger(P, n, B, z)) return kInfinity;
    K_o -= B.lazyProduct(z);
    const FingerMotions z_Z = z.lazyProduct(report.Z);
    W[k] = report.Y[k] + z_Z.lazyProduct(z.transpose());
    P.diagonal().head(n).array() -= p.kappa;
    error = std::max(error, lacking(P, n, scale.posture));
    if (!report.Y[k].isZero(0.0)) {
      error = std::max(error, lacking(report.Y[k], n, effort / scale.posture));
      error = std::max(error, std::abs(report.Y[k].cwiseProduct(P).sum()) / effort);
    }
    if (p.squeeze != nullptr) {
      squeeze_pull -= 2.0 * p.squeeze->B.middleCols(first, n).cwiseProduct(z_Z.transpose().leftCols(n)).sum();
      squeeze_pull += W[k].topLeftCorner(n, n).cwiseProduct(p.squeeze->D.block(first, first, n, n)).sum();
    }
  }
  const Matrix6d slack = K_o - p.K_des;
  error = std::max(error, lacking(on_length(slack, over), 6, scale.stiffness));
  if (!report.Z.isZero(0.0)) {
    error = std::max(error, lacking(on_length(report.Z, p.length_m), 6, effort / scale.stiffness));
    error = std::max(error, std::abs(report.Z.cwiseProduct(slack).sum()) / effort);
  }
  const double error_N = std::max(torque_error_N(p, f, s), pull_error_N(p, f, report, W, squeeze_pull));
  if (!std::isfinite(error_N) || !std::isfinite(error) || !f.allFinite()) return kInfinity;
  return error_N > 0.0 ? std::max(error, error_N / largest_N) : error;
}

namespace {

/// The sum of weighted conditions: largest value of its left side, and its need.
struct WeightedSum {
  double possible = 0.0, need = 0.0;
  std::uint64_t at_limit = 0;
};

/// Returns the force in 0 .. limit with the largest alpha s(f) + beta f.
double best_force(double alpha, double beta, double soft, double tendon, double limit) {
  if (tendon == 0.0 || alpha == 0.0 || beta >= 0.0) return alpha / soft + beta > 0.0 ? limit : 0.0;
  // s' = soft / (soft + f tendon)^2 = -beta / alpha.
  return std::clamp((std::sqrt(alpha * soft / -beta) - soft) / tendon, 0.0, limit);
}

/// Returns torques and stiffness as forces, the scale of muscles without limits.
double asked_N(const StiffMuscleProblem& p) {
  double asked = 0.0;
  for (Index i = 0; i < p.H.rows(); ++i) {
    const double arm = p.H.row(i).lpNorm<Eigen::Infinity>();
    if (arm > 0.0) asked = std::max(asked, std::abs(p.tau[i]) / arm);
  }
  const double stiffness = on_length(p.K_des, 1.0 / p.length_m).cwiseAbs().maxCoeff();
  return asked + stiffness / std::max(p.fibre_per_m.minCoeff(), 1e-300);
}

bool are_positive(const StiffMuscleProblem& p, const StiffMuscleReport& report) {
  using Big = Eigen::Matrix<double, 6 + kMaxStiffJoints, 6 + kMaxStiffJoints>;
  for (int k = 0; k < std::ssize(p.joints); ++k) {
    Big X;
    X << report.Z, report.motion[k], report.motion[k].transpose(), report.bend[k];
    // As units differ, each diagonal entry has its own scale.
    const Eigen::Matrix<double, 6 + kMaxStiffJoints, 1> size = X.diagonal().cwiseMax(0.0).cwiseSqrt();
    const double tiny = 1e-12 * size.maxCoeff();
    X = (X.array() / ((size.array() + tiny).matrix() * (size.array() + tiny).matrix().transpose()).array()).matrix();
    X.diagonal().array() += kRounding * 100.0;
    if (!size.isZero(0.0) && Eigen::LLT<Big>(X).info() != Eigen::Success) return false;
    const double trace = report.Y[k].trace();
    if (!report.Y[k].isZero(0.0) && !(lacking(report.Y[k], p.joints[k], trace) <= 100.0 * kRounding)) return false;
  }
  return true;
}

WeightedSum weighted_sum(const StiffMuscleProblem& p, const StiffMuscleReport& report) {
  WeightedSum sum;
  std::array<FingerMatrix, kMaxStiffFingers> W;
  const auto& l = report.multiplier;
  sum.need = p.tau.dot(l) - report.Z.cwiseProduct(p.A - p.K_des).sum();
  double slope = p.squeeze == nullptr ? 0.0 : report.Z.cwiseProduct(p.squeeze->A).sum() - p.squeeze->tau.dot(l);
  for (int k = 0; k < std::ssize(p.joints); ++k) {
    const int n = p.joints[k], first = first_joint(p, k);
    W[k] = report.bend[k] + report.Y[k];
    const auto W_k = W[k].topLeftCorner(n, n);
    const auto Q = report.motion[k].leftCols(n);
    sum.need += 2.0 * Q.cwiseProduct(p.B.middleCols(first, n)).sum() + p.kappa * report.Y[k].trace() -
                W_k.cwiseProduct(p.D.block(first, first, n, n)).sum();
    if (p.squeeze == nullptr) continue;
    slope += W_k.cwiseProduct(p.squeeze->D.block(first, first, n, n)).sum() -
             2.0 * Q.cwiseProduct(p.squeeze->B.middleCols(first, n)).sum();
  }
  const double asked = asked_N(p);
  const Pairs weights = pair_weights(p, W);
  for (Index j = 0; j < p.H.cols(); ++j) {
    const MuscleShare share = share_of(p, j, weights);
    const double alpha = share.alpha, beta = share.beta + p.H.col(j).dot(l);
    const double given = p.limit.size() > 0 ? p.limit[j] : kInfinity;
    const double limit = std::isinf(given) ? kOutOfReach * asked : given;
    const double soft = 1.0 / p.fibre_per_m[j], tendon = tendon_of(p, j);
    const double f = best_force(alpha, beta, soft, tendon, limit);
    const double part = alpha * f / (soft + f * tendon) + beta * f;
    sum.possible += std::max(0.0, part);
    if (f == limit && std::isfinite(given) && part > 1e-6 * std::abs(sum.need)) sum.at_limit |= std::uint64_t{1} << j;
  }
  if (p.squeeze != nullptr) {
    sum.need -= slope * p.squeeze->low;
    if (slope > 0.0) sum.possible += slope * (p.squeeze->high - p.squeeze->low);
  }
  return sum;
}

}  // namespace

double stiff_infeasibility_gap(const StiffMuscleProblem& problem, const StiffMuscleReport& report) noexcept {
  if (!are_positive(problem, report)) return kInfinity;
  const WeightedSum sum = weighted_sum(problem, report);
  if (!(sum.need > 0.0) || !std::isfinite(sum.possible)) return kInfinity;
  return sum.possible / sum.need;
}

StiffLack stiff_lack(const StiffMuscleProblem& problem, const StiffMuscleReport& report) noexcept {
  StiffLack lack;
  const WeightedSum sum = weighted_sum(problem, report);
  lack.at_limit = sum.at_limit;
  const Matrix6d Z = on_length(report.Z, problem.length_m);
  const double deficit = std::max(0.0, sum.need - sum.possible);
  const auto main_direction = [](const auto& X, auto& direction) {
    const int n = static_cast<int>(X.rows());
    SmallSymmetric wide = widened(X, n), E = unit_rows();
    diagonalise(n, 0.0, wide, E);
    int most = 0;
    for (int i = 1; i < n; ++i) most = wide[i][i] > wide[most][most] ? i : most;
    for (int i = 0; i < n; ++i) direction[i] = E[most][i];
  };
  if (Z.trace() > 0.0) {
    main_direction(Z, lack.direction);
    lack.lacking_N_per_m = deficit / Z.trace();
  }
  double trace = 0.0, most = 0.0;
  for (int k = 0; k < std::ssize(problem.joints); ++k) {
    trace += report.Y[k].trace();
    if (report.Y[k].trace() <= most) continue;
    most = report.Y[k].trace();
    lack.finger = k;
    main_direction(report.Y[k], lack.bend);
  }
  if (trace > 0.0) lack.lacking_Nm_per_rad = deficit / trace;
  return lack;
}

}  // namespace thenar
