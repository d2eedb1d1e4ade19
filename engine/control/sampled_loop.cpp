// SPDX-License-Identifier: Apache-2.0
#include "engine/control/sampled_loop.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The loop over a whole period: x <- X x + old c_(q+1) + now c_q, c_q the command of q periods ago.
class PeriodMap {
 public:
  explicit PeriodMap(const SampledLoop& loop)
      : loop_(loop),
        plant_(loop.A.rows()),
        memory_(loop.Ac.rows()),
        command_(loop.B.cols()),
        under_way_((loop.delay + loop.steps - 1) / loop.steps) {
    const int late = loop.delay % loop.steps;
    X_ = MatrixXd::Identity(plant_, plant_);
    old_ = now_ = MatrixXd::Zero(plant_, command_);
    for (int step = 0; step < loop.steps; ++step) {
      MatrixXd& in_use = step < late ? old_ : now_;
      X_ = (loop.A * X_).eval();
      old_ = (loop.A * old_).eval();
      now_ = (loop.A * now_).eval();
      in_use += loop.B;
    }
    is_late_ = late > 0;
  }

  [[nodiscard]] Index size() const { return plant_ + memory_ + under_way_ * command_; }
  [[nodiscard]] Index plant() const { return plant_; }
  /// Returns the number of periods for which a command acts or is under way.
  [[nodiscard]] int reach() const { return static_cast<int>(under_way_) + 1; }

  /// Advances a state by a period. The newest of the commands under way is the first.
  void advance(VectorXd& all) const {
    const VectorXd x = all.head(plant_), z = all.segment(plant_, memory_);
    const VectorXd command = loop_.Cc * z + loop_.Dc * x;
    // Commands of 0, 1, ... periods ago; the oldest two of the list are in use.
    const auto ago = [&](Index periods) -> VectorXd {
      return periods == 0 ? command : all.segment(plant_ + memory_ + (periods - 1) * command_, command_);
    };
    const Index oldest = under_way_;
    VectorXd next = X_ * x + now_ * ago(is_late_ ? oldest - 1 : oldest);
    if (is_late_) next += old_ * ago(oldest);
    all.head(plant_) = next;
    all.segment(plant_, memory_) = loop_.Ac * z + loop_.Bc * x;
    for (Index i = under_way_; i-- > 0;) all.segment(plant_ + memory_ + i * command_, command_) = ago(i);
  }

 private:
  const SampledLoop& loop_;
  Index plant_, memory_, command_, under_way_;
  bool is_late_ = false;
  MatrixXd X_, old_, now_;
};

/// A Ritz value's size, and its vector in the basis.
struct Ritz {
  double power = 0.0;
  Eigen::VectorXcd y;
};

/// Returns the largest one that shows in the first `seen` numbers of the plant's state; `basis` is the plant's part of
/// the basis. None: zero.
Ritz largest_seen(const MatrixXd& H, const MatrixXd& basis, Index seen) {
  constexpr double kShows = 1e-8;
  Ritz largest{0.0, Eigen::VectorXcd::Zero(H.rows())};
  if (!H.allFinite()) return {std::numeric_limits<double>::infinity(), largest.y};
  const Eigen::EigenSolver<MatrixXd> solver(H);
  if (solver.info() != Eigen::Success) return {std::numeric_limits<double>::infinity(), largest.y};
  const Eigen::MatrixXcd vectors = solver.eigenvectors();
  for (Index i = 0; i < H.rows(); ++i) {
    const double power = std::abs(solver.eigenvalues()[i]);
    if (power <= largest.power) continue;
    const Eigen::VectorXcd state = basis * vectors.col(i);
    if (state.head(seen).norm() > kShows * state.norm()) largest = {power, vectors.col(i).normalized()};
  }
  return largest;
}

}  // namespace

SlowestPole slowest_pole(const SampledLoop& loop, Index seen) {
  constexpr double kAccuracy = 1e-10;
  const PeriodMap map(loop);
  const Index size = map.size();
  MatrixXd V = MatrixXd::Zero(size, std::min<Index>(size, 40) + 1), H = MatrixXd::Zero(V.cols(), V.cols());
  // No symmetry of a grasp may hide a mode from the first direction.
  for (Index i = 0; i < size; ++i) V(i, 0) = std::cos(1.0 + 7.0 * static_cast<double>(i * i + i));
  V.col(0).normalize();
  for (Index n = 1;; ++n) {
    VectorXd next = V.col(n - 1);
    for (int period = 0; period < map.reach(); ++period) map.advance(next);
    const double scale = next.norm();
    // Twice, for one orthogonalisation leaves rounding along what it removes.
    for (int pass = 0; pass < 2; ++pass) {
      for (Index j = 0; j < n; ++j) {
        const double along = V.col(j).dot(next);
        next -= along * V.col(j);
        H(j, n - 1) += along;
      }
    }
    const double rest = next.norm();
    const bool is_whole = n == size || !(rest > 1e-14 * scale);
    if (is_whole || n + 1 == V.cols()) {
      const Ritz ritz = largest_seen(H.topLeftCorner(n, n), V.topLeftCorner(map.plant(), n), seen);
      if (!std::isfinite(ritz.power)) return {ritz.power, Eigen::VectorXcd::Zero(map.plant())};
      if (is_whole || rest * std::abs(ritz.y[n - 1]) < kAccuracy * ritz.power) {
        SlowestPole pole{std::pow(ritz.power, 1.0 / map.reach()), V.topLeftCorner(map.plant(), n) * ritz.y};
        if (pole.state.norm() > 0.0) pole.state.normalize();
        return pole;
      }
      const Index room = std::min(size, 2 * n) + 1;
      V.conservativeResize(Eigen::NoChange, room);
      MatrixXd more = MatrixXd::Zero(room, room);
      more.topLeftCorner(H.rows(), H.cols()) = H;
      H = more;
    }
    H(n, n - 1) = rest;
    V.col(n) = next / rest;
  }
}

}  // namespace thenar
