// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/muscles/stiff_problem.h"

namespace thenar {

/// Six numbers padded to whole registers.
using SixWide = Eigen::Array<double, 8, 1>;

/// A symmetric matrix of up to six rows.
using SmallSymmetric = std::array<SixWide, 6>;

/// Diagonalises a symmetric matrix X, given on the orthonormal rows of E, by Jacobi's rotations until the entries off
/// the diagonal are rounding, or below `left` or a `part` of the least value if that is negative. Out: eigenvectors in
/// the rows of E, values on X's diagonal.
inline void diagonalise(int n, double left, SmallSymmetric& X, SmallSymmetric& E, double part = 0.0) noexcept {
  constexpr double kRounding = 1e-15;
  constexpr int kMostSweeps = 12;
  std::array<std::array<double, 6>, 6> x;  // Scalars, for numbers that are stored one by one load slowly as vectors.
  for (int i = 0; i < n; ++i) {
    for (int c = 0; c < n; ++c) x[i][c] = X[i][c];
  }
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double largest = 0.0, least = 0.0, off = 0.0;
    for (int p = 0; p < n; ++p) {
      largest = std::max(largest, std::abs(x[p][p]));
      least = std::min(least, x[p][p]);
      for (int q = p + 1; q < n; ++q) off = std::max(off, std::abs(x[p][q]));
    }
    const double enough = std::max({left, -part * least, kRounding * largest});
    if (!(off > enough)) break;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) {
        if (std::abs(x[p][q]) <= 0.1 * enough) continue;
        const double theta = 0.5 * (x[q][q] - x[p][p]) / x[p][q];
        const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        x[p][p] -= t * x[p][q];
        x[q][q] += t * x[p][q];
        x[p][q] = 0.0;
        for (int i = 0; i < n; ++i) {
          if (i == p || i == q) continue;
          double& a = i < p ? x[i][p] : x[p][i];
          double& b = i < q ? x[i][q] : x[q][i];
          const double turned = c * a - s * b;
          b = s * a + c * b;
          a = turned;
        }
        const SixWide turned = c * E[p] - s * E[q];
        E[q] = s * E[p] + c * E[q];
        E[p] = turned;
      }
    }
  }
  for (int i = 0; i < n; ++i) X[i][i] = x[i][i];
}

/// Returns e' S e'' for rows of E.
inline double between(int n, const SixWide& a, const SmallSymmetric& S, const SixWide& b) noexcept {
  SixWide S_b = SixWide::Zero();
  for (int i = 0; i < n; ++i) S_b += b[i] * S[i];
  return (a * S_b).sum();
}

/// Returns E S E'.
inline SmallSymmetric turned(int n, const SmallSymmetric& S, const SmallSymmetric& E) noexcept {
  SmallSymmetric X;
  for (int b = 0; b < n; ++b) {
    SixWide S_b = SixWide::Zero();
    for (int i = 0; i < n; ++i) S_b += E[b][i] * S[i];
    X[b].setZero();
    for (int a = 0; a < n; ++a) X[b][a] = (E[a] * S_b).sum();
  }
  return X;
}

/// Tests whether S + shift I is positive definite, by its Cholesky factor.
inline bool is_positive(int n, SmallSymmetric S, double shift) noexcept {
  for (int k = 0; k < n; ++k) {
    const double pivot = S[k][k] + shift;
    if (!(pivot > 0.0)) return false;
    for (int i = k + 1; i < n; ++i) S[i] -= (S[i][k] / pivot) * S[k];
  }
  return true;
}

inline SmallSymmetric unit_rows() noexcept {
  SmallSymmetric E;
  for (int i = 0; i < 6; ++i) {
    E[i].setZero();
    E[i][i] = 1.0;
  }
  return E;
}

/// A problem in lanes, one per muscle, then one for the internal force s times the root of its weight. The six rows are
/// scaled by `length_m`, and A includes -K_des.
template <int kSize>
struct StiffModel {
  using Lanes = Eigen::Array<double, kSize, 1>;
  static constexpr int kPairs = 3 * static_cast<int>(kMaxJoints);

  struct Finger {
    int first, joints, pair;
  };

  int muscles = 0, variables = 0, joints = 0, fingers = 0, pairs = 0;
  std::array<Finger, kMaxStiffFingers> finger;
  Lanes lower, upper;
  std::array<Lanes, kMaxJoints> row;  ///< row.x = tau
  std::array<double, kMaxJoints> tau;
  std::array<Lanes, kPairs> stiff;  ///< a a'
  std::array<Lanes, kPairs> turn;   ///< G, then -D_1.
  std::array<Lanes, kPairs> dP;     ///< s' a a' - G at the last point; constant without tendons.
  Lanes soft, tendon;               ///< s = x / (soft + tendon x)
  Lanes ddk;                        ///< s'' at the last point.
  bool has_tendons = false, has_squeeze = false;
  SmallSymmetric A, A_1;
  std::array<SixWide, kMaxJoints> B, B_1;  ///< One row per joint.
  std::array<double, kPairs> D;
  double kappa = 0.0;
  double stiffness_scale = 0.0, posture_scale = 0.0;

  explicit StiffModel(const StiffMuscleProblem& problem);

  void linearise(const Lanes& x) {
    const Lanes give = soft + tendon * x;
    const Lanes dk = soft / give.square();
    ddk = -2.0 * tendon * dk / give;
    for (int p = 0; p < pairs; ++p) dP[p] = dk * stiff[p] - turn[p];
  }

 private:
  void load_fingers(const StiffMuscleProblem& problem);
  void load_squeeze(const StiffSqueeze& squeeze, const Eigen::Array<double, 6, 1>& arms);
};

/// The stiffness at a point x.
template <int kSize>
struct StiffPoint {
  using Lanes = typename StiffModel<kSize>::Lanes;

  std::array<std::array<double, kMaxStiffJoints>, kMaxJoints> P, L;  ///< D_k + M_k, and its Cholesky factor.
  std::array<double, kMaxJoints> over_pivot;                         ///< 1 / L(i, i)
  std::array<SixWide, kMaxJoints> B, W;                              ///< B_k', and L^-1 B_k'.
  SmallSymmetric S;                                                  ///< K_o - K_des
  bool is_definite = false;  ///< True if all P are positive definite; else W and S are not set.

  void look(StiffModel<kSize>& model, const Lanes& x);

  [[nodiscard]] SmallSymmetric posture(const StiffModel<kSize>& model, int k) const {
    const auto& finger = model.finger[k];
    SmallSymmetric S_k;
    for (int i = 0; i < 6; ++i) S_k[i].setZero();
    for (int i = 0; i < finger.joints; ++i) {
      for (int c = 0; c <= i; ++c) S_k[i][c] = S_k[c][i] = P[finger.first + i][c];
      S_k[i][i] -= model.kappa;
    }
    return S_k;
  }

  /// Computes z = P^-1 B' e of all joints.
  void motion(const StiffModel<kSize>& model, const SixWide& e, double* z) const {
    for (int k = 0; k < model.fingers; ++k) {
      const auto& finger = model.finger[k];
      for (int i = finger.joints - 1; i >= 0; --i) {
        double rest = (W[finger.first + i] * e).sum();
        for (int c = i + 1; c < finger.joints; ++c) rest -= L[finger.first + c][i] * z[finger.first + c];
        z[finger.first + i] = rest * over_pivot[finger.first + i];
      }
    }
  }
};

/// Adds y' dM_k y'' of finger k to g.
template <int kSize>
void add_bend(const StiffModel<kSize>& model, int k, const double* y, const double* y_2,
              typename StiffModel<kSize>::Lanes& g) noexcept {
  int p = model.finger[k].pair;
  for (int i = 0; i < model.finger[k].joints; ++i) {
    for (int c = 0; c < i; ++c) g += (y[i] * y_2[c] + y[c] * y_2[i]) * model.dP[p++];
    g += (y[i] * y_2[i]) * model.dP[p++];
  }
}

/// Returns e' dK_o e'' for directions with their motions z.
template <int kSize>
typename StiffModel<kSize>::Lanes stiffness_slope(const StiffModel<kSize>& model, const SixWide& e, const double* z,
                                                  const SixWide& e_2, const double* z_2) noexcept {
  typename StiffModel<kSize>::Lanes g = StiffModel<kSize>::Lanes::Zero();
  for (int k = 0; k < model.fingers; ++k) {
    add_bend(model, k, z + model.finger[k].first, z_2 + model.finger[k].first, g);
  }
  if (model.has_squeeze) {
    double slope = between(6, e, model.A_1, e_2);
    for (int i = 0; i < model.joints; ++i) slope -= (model.B_1[i] * (z[i] * e_2 + z_2[i] * e)).sum();
    g[model.muscles] += slope;
  }
  return g;
}

template <int kSize>
StiffModel<kSize>::StiffModel(const StiffMuscleProblem& problem) {
  muscles = static_cast<int>(problem.H.cols());
  joints = static_cast<int>(problem.H.rows());
  has_squeeze = problem.squeeze != nullptr;
  variables = muscles + (has_squeeze ? 1 : 0);
  lower.setZero();
  upper.setConstant(std::numeric_limits<double>::infinity());
  if (problem.limit.size() > 0) upper.head(muscles) = problem.limit;
  soft.setOnes();
  soft.head(muscles) = problem.fibre_per_m.array().inverse();
  tendon.setZero();
  if (problem.tendon_N_per_m.size() > 0) tendon.head(muscles) = problem.tendon_N_per_m.array().inverse();
  has_tendons = (tendon != 0.0).any();
  ddk.setZero();
  for (int i = 0; i < joints; ++i) {
    row[i].setZero();
    for (int j = 0; j < muscles; ++j) row[i][j] = problem.H(i, j);
    tau[i] = problem.tau[i];
  }
  Eigen::Array<double, 6, 1> arms;
  arms << 1.0, 1.0, 1.0, Eigen::Array3d::Constant(1.0 / problem.length_m);
  double wanted = 0.0, at_hand = 0.0;
  for (int i = 0; i < 6; ++i) {
    A[i].setZero();
    A_1[i].setZero();
    A[i].template head<6>() = arms[i] * arms * (problem.A.col(i) - problem.K_des.col(i)).array();
    wanted = std::max(wanted, (arms[i] * arms * problem.K_des.col(i).array()).abs().maxCoeff());
    at_hand = std::max(at_hand, (arms[i] * arms * problem.A.col(i).array()).abs().maxCoeff());
  }
  stiffness_scale = wanted > 0.0 ? wanted : at_hand > 0.0 ? at_hand : 1.0;
  for (int i = 0; i < joints; ++i) {
    B[i].setZero();
    B_1[i].setZero();
    B[i].template head<6>() = arms * problem.B.col(i).array();
  }
  load_fingers(problem);
  if (has_squeeze) load_squeeze(*problem.squeeze, arms);
  linearise(Lanes::Zero());
}

template <int kSize>
void StiffModel<kSize>::load_fingers(const StiffMuscleProblem& problem) {
  fingers = static_cast<int>(std::ssize(problem.joints));
  kappa = problem.kappa;
  int first = 0;
  double largest = 0.0;
  std::array<Lanes, kMaxJoints> arms;
  for (int i = 0; i < joints; ++i) {
    arms[i].setZero();
    for (int j = 0; j < muscles; ++j) arms[i][j] = problem.arm(i, j);
  }
  for (int k = 0; k < fingers; ++k) {
    finger[k] = {first, problem.joints[k], pairs};
    for (int i = 0; i < problem.joints[k]; ++i) {
      for (int c = 0; c <= i; ++c, ++pairs) {
        stiff[pairs] = arms[first + i] * arms[first + c];
        turn[pairs].setZero();
        for (int j = 0; j < muscles; ++j) turn[pairs][j] = problem.turn(pairs, j);
        D[pairs] = problem.D(first + i, first + c);
        largest = std::max(largest, std::abs(D[pairs]));
      }
    }
    first += problem.joints[k];
  }
  posture_scale = std::max(std::abs(kappa), 1e-6 * largest);
  if (!(posture_scale > 0.0)) posture_scale = 1.0;
}

template <int kSize>
void StiffModel<kSize>::load_squeeze(const StiffSqueeze& squeeze, const Eigen::Array<double, 6, 1>& arms) {
  const double root = std::sqrt(squeeze.weight), part = 1.0 / root;
  lower[muscles] = squeeze.low * root;
  upper[muscles] = squeeze.high * root;
  for (int i = 0; i < 6; ++i) A_1[i].template head<6>() = part * arms[i] * arms * squeeze.A.col(i).array();
  for (int i = 0; i < joints; ++i) {
    row[i][muscles] = -part * squeeze.tau[i];
    B_1[i].template head<6>() = part * arms * squeeze.B.col(i).array();
  }
  for (int k = 0; k < fingers; ++k) {
    int p = finger[k].pair;
    for (int i = 0; i < finger[k].joints; ++i) {
      for (int c = 0; c <= i; ++c) turn[p++][muscles] = -part * squeeze.D(finger[k].first + i, finger[k].first + c);
    }
  }
}

template <int kSize>
[[gnu::flatten]] void StiffPoint<kSize>::look(StiffModel<kSize>& model, const Lanes& x) {
  if (model.has_tendons) model.linearise(x);
  const double s = model.has_squeeze ? x[model.muscles] : 0.0;
  const Lanes spring = model.has_tendons ? Lanes(x / (model.soft + model.tendon * x)) : Lanes(Lanes::Zero());
  is_definite = true;
  for (int k = 0; k < model.fingers; ++k) {
    const auto& finger = model.finger[k];
    for (int i = 0, p = finger.pair; i < finger.joints; ++i) {
      const int at = finger.first + i;
      for (int c = 0; c <= i; ++c, ++p) {
        P[at][c] = model.D[p] +
                   (model.has_tendons ? (spring * model.stiff[p] - x * model.turn[p]).sum() : (x * model.dP[p]).sum());
      }
      for (int c = 0; c <= i; ++c) {
        double rest = P[at][c];
        for (int b = 0; b < c; ++b) rest -= L[at][b] * L[finger.first + c][b];
        if (c < i) L[at][c] = rest * over_pivot[finger.first + c];
        if (c < i) continue;
        if (!(rest > 0.0)) is_definite = false;
        L[at][i] = std::sqrt(rest);
        over_pivot[at] = 1.0 / L[at][i];
      }
    }
  }
  if (!is_definite) return;
  S = model.A;
  for (int i = 0; model.has_squeeze && i < 6; ++i) S[i] += s * model.A_1[i];
  for (int k = 0; k < model.fingers; ++k) {
    const auto& finger = model.finger[k];
    for (int i = 0; i < finger.joints; ++i) {
      const int at = finger.first + i;
      B[at] = model.has_squeeze ? SixWide(model.B[at] + s * model.B_1[at]) : model.B[at];
      SixWide w = B[at];
      for (int c = 0; c < i; ++c) w -= L[at][c] * W[finger.first + c];
      W[at] = over_pivot[at] * w;
      for (int r = 0; r < 6; ++r) S[r] -= W[at][r] * W[at];
    }
  }
}

}  // namespace thenar
