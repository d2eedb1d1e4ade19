// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solvers/muscles/stiff_model.h"

namespace thenar {

/// A candidate for the optimum with its multipliers. Z is scaled by `length_m`.
template <int kSize>
struct StiffCandidate {
  typename StiffModel<kSize>::Lanes x;
  std::array<double, kMaxJoints> l;
  SmallSymmetric Z;
  std::array<SmallSymmetric, kMaxStiffFingers> Y;
  double error = std::numeric_limits<double>::infinity();
};

/// Errors at which Newton's method stops.
struct NewtonEnd {
  double enough, trusted;  ///< Error at which it stops, and at which it may if rounding prevents less.
  double unseen = 0.0;     ///< See StiffNewton::run.
};

/// Newton's method on the conditions of an optimum,
///     x = clamp(H'l + <Z, dK_o> + sum <Y_k, dM_k>),  H x = tau,  Z = P_+(Z - c S),  Y_k = P_+(Y_k - c_k S_k),
/// with S = K_o - K_des, S_k = D_k + M_k - kappa I and P_+ the nearest positive semidefinite matrix. In the
/// eigenvectors e of Z - c S, of values m, S is zero between those of m > 0, Z between those of m < 0, and between the
/// two kinds Z_au = -c m_a / |m_u| S_au.
template <int kSize>
class StiffNewton {
 public:
  using Lanes = typename StiffModel<kSize>::Lanes;

  explicit StiffNewton(StiffModel<kSize>& model) : seed(unit_rows()), model_(model) {}

  /// Iterates from a candidate; true if it became the optimum. The result of a step from an error below `unseen` is not
  /// evaluated: its proof decides.
  bool run(StiffCandidate<kSize>& at, int steps, const NewtonEnd& end, int& iterations);

  SmallSymmetric seed;  ///< Orthonormal rows, best near the eigenvectors of the object's stiffness.

 private:
  // Most equations: of joints and of pairs of directions.
  static constexpr int kMostRows = 64;
  static constexpr int kStrip = 16;  // Equations that are eliminated at a time.
  static constexpr double kDirections = 1e-3;
  // Squares of each active direction with each joint, and with each inactive direction.
  static constexpr int kMostSquares = 6 * static_cast<int>(kMaxJoints) + 9 + 6 * kMaxStiffFingers;
  using Wide = Eigen::Array<double, kMostRows, 1>;

  /// A semidefinite condition at a point.
  struct Block {
    int finger = -1;  ///< -1: the object's.
    int size = 0, active = 0;
    double c = 1.0;
    SmallSymmetric E, X;           ///< Eigenvectors of Z - c S, the active first; their values on the diagonal.
    SmallSymmetric S;              ///< S on them.
    std::array<double, 6> weight;  ///< The values.
    // Joints' motions for each eigenvector, and for the active ones their derivatives by the forces: dM z - dB'e.
    std::array<std::array<double, kMaxJoints>, 6> z;
    std::array<std::array<Lanes, kMaxJoints>, 6> pull;
    std::array<std::array<int, 6>, 6> row;  ///< Equation of a pair of active ones; else the pair's square.
  };

  /// Returns c m_a / |m_u|. Where a direction is nearly of neither kind, it counts as active.
  static double kappa_of(const Block& block, int a, int u) {
    return block.c * block.weight[a] / std::max(-block.weight[u], 1e-8 * block.weight[a]);
  }
  void prepare(Block& block, const SmallSymmetric& S, const SmallSymmetric& Z, double c);
  void ask(Block& block, int a);
  Lanes slope(const Block& block, int a, int b) const;
  void evaluate(StiffCandidate<kSize>& at);
  bool step(StiffCandidate<kSize>& at);
  void add_block(Block& block);
  void add_curvature(const Block& block);
  template <int kFirst>
  bool factor(int k);
  bool eliminate(int rows, std::array<double, kMostRows>& lambda, Lanes& d);
  void update(const Block& block, const std::array<double, kMostRows>& lambda, const Lanes& d, SmallSymmetric& Z) const;
  void hold_bounds(Lanes& x);
  void add_square(double factor, const Lanes& w) {
    squares_[square_count_++] = std::sqrt(factor) * w;
    diagonal_ += factor * w.square();
  }
  void add_row(const Lanes& g, double residual) {
    slopes_[rows_] = g;
    residual_[rows_++] = residual;
  }

  StiffModel<kSize>& model_;
  StiffPoint<kSize> point_;
  std::array<Block, kMaxStiffFingers + 1> blocks_;
  int block_count_ = 0;
  Lanes pull_;   ///< H'l + <Z, dK_o> + ..
  Lanes shift_;  ///< Steps to the bounds of variables that are held there.
  std::array<int, kSize> free_;
  int free_count_ = 0;
  // hessian = diagonal + sum of squares w w'; its diagonal has both.
  std::array<Lanes, kMostSquares> squares_;
  int square_count_ = 0;
  Lanes curve_, diagonal_;
  std::array<Lanes, kMostRows> slopes_;
  std::array<Lanes, kSize> hessian_;   ///< Rows of the free variables, from the diagonal on.
  std::array<double, kSize> inverse_;  ///< Inverses of its pivots.
  std::array<Wide, kSize> equations_;  ///< By variables; the last column is the gradient.
  std::array<double, kMostRows> residual_;
  Lanes gradient_;
  int rows_ = 0;
  double last_error_ = 1.0;
};

template <int kSize>
void StiffNewton<kSize>::prepare(Block& block, const SmallSymmetric& S, const SmallSymmetric& Z, double c) {
  const int n = block.size;
  block.c = c;
  SmallSymmetric X, E = unit_rows();
  for (int i = 0; i < 6; ++i) X[i] = Z[i] - c * S[i];
  if (block.finger < 0) {
    E = seed;
    X = turned(n, X, E);
  }
  double trace = 0.0;
  for (int i = 0; i < n; ++i) trace += Z[i][i];
  // Newton's step needs its directions as well as it is going to end.
  diagonalise(n, kDirections * std::min(1.0, last_error_ * last_error_) * trace, X, E);
  if (block.finger < 0) seed = E;
  block.active = 0;
  std::array<int, 6> order;
  for (int i = 0; i < n; ++i) {
    if (X[i][i] > 0.0) order[block.active++] = i;
  }
  for (int i = 0, at = block.active; i < n; ++i) {
    if (!(X[i][i] > 0.0)) order[at++] = i;
  }
  for (int i = 0; i < n; ++i) {
    block.E[i] = E[order[i]];
    block.weight[i] = X[order[i]][order[i]];
  }
  block.S = turned(n, S, block.E);
  for (int i = 0; i < n; ++i) {
    auto& z = block.z[i];
    if (block.finger < 0) {
      point_.motion(model_, block.E[i], z.data());
    } else {
      for (int k = 0; k < n; ++k) z[model_.finger[block.finger].first + k] = block.E[i][k];
    }
  }
}

/// Computes `pull` of an active direction.
template <int kSize>
void StiffNewton<kSize>::ask(Block& block, int a) {
  const auto& z = block.z[a];
  auto& pull = block.pull[a];
  for (int k = 0; k < model_.fingers; ++k) {
    if (block.finger >= 0 && block.finger != k) continue;
    const auto& finger = model_.finger[k];
    for (int i = 0, p = finger.pair; i < finger.joints; ++i) {
      Lanes& own = pull[finger.first + i];
      own.setZero();
      for (int c = 0; c < i; ++c, ++p) {
        own += z[finger.first + c] * model_.dP[p];
        pull[finger.first + c] += z[finger.first + i] * model_.dP[p];
      }
      own += z[finger.first + i] * model_.dP[p++];
    }
  }
  if (!model_.has_squeeze || block.finger >= 0) return;
  for (int i = 0; i < model_.joints; ++i) pull[i][model_.muscles] -= (model_.B_1[i] * block.E[a]).sum();
}

/// Returns e_a' dS e_b for an active a.
template <int kSize>
typename StiffNewton<kSize>::Lanes StiffNewton<kSize>::slope(const Block& block, int a, int b) const {
  Lanes g = Lanes::Zero();
  const bool is_finger = block.finger >= 0;
  const int first = is_finger ? model_.finger[block.finger].first : 0;
  const int count = is_finger ? model_.finger[block.finger].joints : model_.joints;
  for (int i = first; i < first + count; ++i) g += block.z[b][i] * block.pull[a][i];
  if (model_.has_squeeze && !is_finger) {
    double more = between(6, block.E[a], model_.A_1, block.E[b]);
    for (int i = 0; i < model_.joints; ++i) more -= block.z[a][i] * (model_.B_1[i] * block.E[b]).sum();
    g[model_.muscles] += more;
  }
  return g;
}

/// Computes stiffness, directions and error of the candidate; makes its Z and Y positive semidefinite.
template <int kSize>
void StiffNewton<kSize>::evaluate(StiffCandidate<kSize>& at) {
  last_error_ = std::isfinite(at.error) ? at.error : 1.0;
  at.error = std::numeric_limits<double>::infinity();
  at.x = at.x.max(model_.lower).min(model_.upper);
  point_.look(model_, at.x);
  if (!point_.is_definite) return;
  const double effort = std::max(at.x.square().sum(), 1e-300);
  const double largest = std::sqrt(at.x.square().maxCoeff()) + 1e-300;
  double error = 0.0;
  block_count_ = 0;
  pull_.setZero();
  for (int i = 0; i < model_.joints; ++i) {
    pull_ += at.l[i] * model_.row[i];
    const double longest = model_.row[i].abs().maxCoeff();
    const double left = std::abs((model_.row[i] * at.x).sum() - model_.tau[i]);
    if (left > 0.0) error = std::max(error, left / (longest * largest));
  }
  for (int k = -1; k < model_.fingers; ++k) {
    Block& block = blocks_[block_count_];
    block.finger = k;
    block.size = k < 0 ? 6 : model_.finger[k].joints;
    SmallSymmetric& Z = k < 0 ? at.Z : at.Y[k];
    const SmallSymmetric S = k < 0 ? point_.S : point_.posture(model_, k);
    const double scale = k < 0 ? model_.stiffness_scale : model_.posture_scale;
    double trace = 0.0;
    for (int i = 0; i < block.size; ++i) trace += Z[i][i];
    if (trace <= 0.0 && is_positive(block.size, S, 0.0)) {
      for (SixWide& line : Z) line.setZero();
      continue;
    }
    prepare(block, S, Z, trace > 0.0 ? trace / scale : 0.1 * effort / (scale * scale));
    for (SixWide& line : Z) line.setZero();
    for (int a = 0; a < block.size; ++a) {
      if (a < block.active) {
        for (int i = 0; i < block.size; ++i) Z[i] += (block.weight[a] * block.E[a][i]) * block.E[a];
        ask(block, a);
        pull_ += block.weight[a] * slope(block, a, a);
        error = std::max(error, block.weight[a] * std::abs(block.S[a][a]) / effort);
      }
      error = std::max(error, -block.S[a][a] / scale);
    }
    ++block_count_;
  }
  const Lanes off = (at.x - pull_.max(model_.lower).min(model_.upper)).abs();
  error = std::max(error, off.maxCoeff() / largest);
  at.error = std::isfinite(error) && at.x.isFinite().all() ? error : std::numeric_limits<double>::infinity();
}

/// Adds the equations of pairs of active directions, and the terms that couple Z between the two kinds to S.
template <int kSize>
void StiffNewton<kSize>::add_block(Block& block) {
  for (int a = 0; a < block.active; ++a) {
    for (int b = a; b < block.size; ++b) {
      const Lanes g = slope(block, a, b);
      if (b < block.active) {
        block.row[a][b] = rows_;
        const double twice = a == b ? 1.0 : 2.0;
        add_row(twice * g, twice * block.S[a][b]);
        continue;
      }
      const double kappa = 2.0 * kappa_of(block, a, b);
      block.row[a][b] = square_count_;
      add_square(kappa, g);
      gradient_ += (kappa * block.S[a][b]) * g;
    }
  }
  add_curvature(block);
}

/// Adds -<Z, d2K_o> or -<Y, d2M>.
template <int kSize>
void StiffNewton<kSize>::add_curvature(const Block& block) {
  for (int a = 0; a < block.active; ++a) {
    const double weight = block.weight[a];
    const auto& z = block.z[a];
    if (model_.has_tendons) {
      Lanes square = Lanes::Zero();
      for (int k = 0; k < model_.fingers; ++k) {
        if (block.finger >= 0 && block.finger != k) continue;
        const auto& finger = model_.finger[k];
        for (int i = 0, p = finger.pair; i < finger.joints; ++i) {
          for (int c = 0; c <= i; ++c, ++p) {
            square += (c < i ? 2.0 : 1.0) * (z[finger.first + i] * z[finger.first + c]) * model_.stiff[p];
          }
        }
      }
      curve_ -= weight * model_.ddk * square;
    }
    if (block.finger >= 0) continue;
    for (int k = 0; k < model_.fingers; ++k) {
      const auto& finger = model_.finger[k];
      std::array<Lanes, kMaxStiffJoints> q;
      for (int i = 0; i < finger.joints; ++i) {
        const int at = finger.first + i;
        q[i] = block.pull[a][at];
        for (int c = 0; c < i; ++c) q[i] -= point_.L[at][c] * q[c];
        q[i] *= point_.over_pivot[at];
        add_square(2.0 * weight, q[i]);
      }
    }
  }
}

/// Factorises the free variables' rows of the hessian from the k-th on, the next of which is among the lanes kFirst to
/// kFirst + 3. A row stays in registers until it is done.
template <int kSize>
template <int kFirst>
[[gnu::flatten]] bool StiffNewton<kSize>::factor(int k) {
  if constexpr (kFirst < kSize) {
    constexpr int kLeft = kSize - kFirst;
    for (; k < free_count_ && free_[k] < kFirst + 4; ++k) {
      const int v = free_[k];
      Eigen::Array<double, kLeft, 1> row = Eigen::Array<double, kLeft, 1>::Zero();
      for (int i = 0; i < square_count_; ++i) row += squares_[i][v] * squares_[i].template tail<kLeft>();
      for (int i = 0; i < k; ++i) {
        const Lanes& before = hessian_[free_[i]];
        row -= (before[v] * inverse_[i]) * before.template tail<kLeft>();
      }
      hessian_[v].template tail<kLeft>() = row;
      hessian_[v][v] += curve_[v];
      if (!(hessian_[v][v] > 0.0)) return false;
      inverse_[k] = 1.0 / hessian_[v][v];
    }
    return factor<kFirst + 4>(k);
  }
  return true;
}

/// Solves for the step d and the multipliers of
///     hessian d + gradient = J' lambda,  J d = -residual.
template <int kSize>
[[gnu::flatten]] bool StiffNewton<kSize>::eliminate(int rows, std::array<double, kMostRows>& lambda, Lanes& d) {
  constexpr double kDependent = 1e-13;
  using Strip = Eigen::Array<double, kStrip, 1>;
  if (!factor<0>(0)) return false;
  std::array<Wide, kMostRows> M;  // From its diagonal on.
  for (int at = 0; at <= rows; at += kStrip) {
    for (int k = 0; k < free_count_; ++k) {
      Strip row = equations_[free_[k]].template segment<kStrip>(at);
      for (int i = 0; i < k; ++i) {
        const int before = free_[i];
        row -= (hessian_[before][free_[k]] * inverse_[i]) * equations_[before].template segment<kStrip>(at);
      }
      equations_[free_[k]].template segment<kStrip>(at) = row;
    }
  }
  for (int r = 0; r < rows; ++r) {
    for (int at = r / kStrip * kStrip; at <= rows; at += kStrip) {
      Strip row = Strip::Zero();
      for (int k = 0; k < free_count_; ++k) {
        const Wide& equations = equations_[free_[k]];
        row += (equations[r] * inverse_[k]) * equations.template segment<kStrip>(at);
      }
      M[r].template segment<kStrip>(at) = row;
    }
  }
  // M lambda = -residual + J hessian^-1 gradient.
  std::array<double, kMostRows> over;
  for (int r = 0; r < rows; ++r) {
    M[r][rows] -= residual_[r];
    const double whole = M[r][r];
    for (int at = r / kStrip * kStrip; at <= rows; at += kStrip) {
      Strip row = M[r].template segment<kStrip>(at);
      for (int i = 0; i < r; ++i) row -= (M[i][r] * over[i]) * M[i].template segment<kStrip>(at);
      M[r].template segment<kStrip>(at) = row;
    }
    // A row that depends on those before it, or has no free variable, has no part.
    over[r] = M[r][r] > kDependent * whole ? 1.0 / M[r][r] : 0.0;
  }
  for (int k = rows - 1; k >= 0; --k) {
    double rest = M[k][rows];
    for (int i = k + 1; i < rows; ++i) rest -= M[k][i] * lambda[i];
    lambda[k] = rest * over[k];
  }
  d.setZero();
  for (int k = free_count_ - 1; k >= 0; --k) {
    const Wide& equations = equations_[free_[k]];
    double rest = -equations[rows];
    for (int r = 0; r < rows; ++r) rest += equations[r] * lambda[r];
    const int v = free_[k];
    for (int i = k + 1; i < free_count_; ++i) rest -= hessian_[v][free_[i]] * d[free_[i]];
    d[v] = rest * inverse_[k];
  }
  return d.isFinite().all();
}

template <int kSize>
void StiffNewton<kSize>::update(const Block& block, const std::array<double, kMostRows>& lambda, const Lanes& d,
                                SmallSymmetric& Z) const {
  for (SixWide& line : Z) line.setZero();
  const auto add = [&](int a, int b, double value) {
    for (int i = 0; i < block.size; ++i) {
      Z[i] += (value * block.E[a][i]) * block.E[b];
      if (a != b) Z[i] += (value * block.E[b][i]) * block.E[a];
    }
  };
  for (int a = 0; a < block.active; ++a) {
    for (int b = a; b < block.active; ++b) add(a, b, lambda[block.row[a][b]]);
    for (int b = block.active; b < block.size; ++b) {
      // The square is the root of 2 kappa times the slope.
      const double kappa = kappa_of(block, a, b), root = std::sqrt(2.0 * kappa);
      add(a, b, -kappa * block.S[a][b] - 0.5 * root * (squares_[block.row[a][b]] * d).sum());
    }
  }
}

/// Fixes variables at bounds that the step by pull and curvature alone would cross.
template <int kSize>
void StiffNewton<kSize>::hold_bounds(Lanes& x) {
  const Lanes wanted = x + (pull_ - x) / diagonal_;
  shift_ = x;
  free_count_ = 0;
  for (int j = 0; j < model_.variables; ++j) {
    if (wanted[j] <= model_.lower[j]) {
      x[j] = model_.lower[j];
    } else if (wanted[j] >= model_.upper[j]) {
      x[j] = model_.upper[j];
    } else {
      free_[free_count_++] = j;
    }
  }
  shift_ = x - shift_;
}

template <int kSize>
bool StiffNewton<kSize>::step(StiffCandidate<kSize>& at) {
  rows_ = square_count_ = 0;
  curve_.setOnes();
  diagonal_.setZero();
  gradient_.setZero();
  int pairs = 0;
  for (int b = 0; b < block_count_; ++b) pairs += blocks_[b].active * (blocks_[b].active + 1) / 2;
  if (model_.joints + pairs + 1 > kMostRows) return false;
  for (int i = 0; i < model_.joints; ++i) {
    add_row(model_.row[i], (model_.row[i] * at.x).sum() - model_.tau[i]);
  }
  for (int b = 0; b < block_count_; ++b) add_block(blocks_[b]);
  diagonal_ += curve_;
  gradient_ += at.x;
  hold_bounds(at.x);
  if ((shift_ != 0.0).any()) {
    for (int r = 0; r < rows_; ++r) residual_[r] += (slopes_[r] * shift_).sum();
    for (int i = 0; i < square_count_; ++i) gradient_ += (squares_[i] * shift_).sum() * squares_[i];
  }
  for (int k = 0; k < free_count_; ++k) {
    const int j = free_[k];
    for (int r = 0; r < rows_; ++r) equations_[j][r] = slopes_[r][j];
    equations_[j][rows_] = gradient_[j];
    for (int r = rows_ + 1; r % kStrip != 0; ++r) equations_[j][r] = 0.0;
  }
  std::array<double, kMostRows> lambda;
  Lanes d;
  if (!eliminate(rows_, lambda, d)) return false;
  for (int i = 0; i < model_.joints; ++i) at.l[i] = lambda[i];
  at.x += d;
  d += shift_;
  for (int b = 0; b < block_count_; ++b) {
    const Block& block = blocks_[b];
    update(block, lambda, d, block.finger < 0 ? at.Z : at.Y[block.finger]);
  }
  return true;
}

template <int kSize>
bool StiffNewton<kSize>::run(StiffCandidate<kSize>& at, int steps, const NewtonEnd& end, int& iterations) {
  evaluate(at);
  StiffCandidate<kSize> best = at;
  const double first = at.error;
  for (int k = 0; k < steps && at.error > end.enough; ++k) {
    ++iterations;
    const bool is_last = at.error <= end.unseen;
    if (!std::isfinite(at.error) || !step(at)) break;
    if (is_last) {
      at.x = at.x.max(model_.lower).min(model_.upper);
      return true;
    }
    evaluate(at);
    if (at.error < best.error) best = at;
    // Where it does not converge directly, planes are faster.
    if (k > 0 && !(at.error < first)) break;
    // Only rounding is left.
    if (best.error <= end.trusted && at.error > 0.1 * best.error && at.error != best.error) break;
  }
  at = best;
  return at.error <= end.trusted;
}

}  // namespace thenar
