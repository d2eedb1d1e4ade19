#include "solvers/muscle_forces.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Rows of H are measured lever arms: what is left of one below this part of its length is rounding, not anatomy.
constexpr double kDependentRow = 1e-10;

/// Replaces H f = tau by Y f = t with orthonormal rows, by Gram-Schmidt on the rows of [H tau]. False if a row depends
/// on those before it and its torque does not.
bool orthonormalise(const Eigen::Ref<const MatrixXd>& H, const Eigen::Ref<const VectorXd>& tau, Eigen::Ref<RowMatrix> Y,
                    Eigen::Ref<VectorXd> t) {
  for (Index i = 0; i < H.rows(); ++i) {
    auto y = Y.row(i);
    y = H.row(i);
    t[i] = tau[i];
    const double length = y.norm();
    double torque_scale = std::abs(tau[i]);
    // Twice is enough: the second pass takes away what rounding left in the first.
    for (int pass = 0; pass < 2; ++pass) {
      for (Index j = 0; j < i; ++j) {
        const double part = y.dot(Y.row(j));
        y -= part * Y.row(j);
        t[i] -= part * t[j];
        torque_scale = std::max(torque_scale, std::abs(part * t[j]));
      }
    }
    const double left = y.norm();
    if (left > kDependentRow * length) {
      y /= left;
      t[i] /= left;
    } else if (std::abs(t[i]) <= kDependentRow * torque_scale) {
      y.setZero();
      t[i] = 0.0;
    } else {
      return false;
    }
  }
  return true;
}

double largest_error(const Eigen::Ref<const MatrixXd>& H, const Eigen::Ref<const VectorXd>& tau,
                     const Eigen::Ref<const VectorXd>& f) {
  double largest = 0.0;
  for (Index i = 0; i < H.rows(); ++i) largest = std::max(largest, std::abs(H.row(i).dot(f) - tau[i]));
  return largest;
}

MuscleStatus failure(LcpStatus status) {
  return status == LcpStatus::kInfeasible ? MuscleStatus::kInfeasible : MuscleStatus::kBudgetSpent;
}

}  // namespace

MuscleWorkspace::MuscleWorkspace(Index joints, Index muscles)
    : lcp(muscles), Y(joints, muscles), t(joints), pi(muscles, muscles), least(muscles), z(muscles) {}

MuscleReport solve_muscle_forces(const Eigen::Ref<const MatrixXd>& H, const Eigen::Ref<const VectorXd>& tau,
                                 MuscleWorkspace& work, Eigen::Ref<VectorXd> f) noexcept {
  const Index joints = H.rows();
  const Index muscles = H.cols();
  assert(joints <= work.Y.rows() && muscles <= work.Y.cols() && tau.size() == joints && f.size() == muscles);
  if (!H.allFinite() || !tau.allFinite()) return {};

  auto Y = work.Y.topLeftCorner(joints, muscles);
  auto t = work.t.head(joints);
  if (!orthonormalise(H, tau, Y, t)) return {MuscleStatus::kInfeasible, 0, 0.0};

  auto pi = work.pi.topLeftCorner(muscles, muscles);
  auto least = work.least.head(muscles);
  auto z = work.z.head(muscles);
  pi.noalias() = -Y.transpose().lazyProduct(Y);
  pi.diagonal().array() += 1.0;
  least.noalias() = Y.transpose().lazyProduct(t);
  const LcpReport lcp = solve_lcp(pi, least, usual_pivot_budget(muscles), work.lcp, z);
  if (lcp.status != LcpStatus::kSolved) return {failure(lcp.status), lcp.pivots, 0.0};

  f.noalias() = least + pi.lazyProduct(z);
  // Either f or z is zero; the rest is rounding.
  for (Index i = 0; i < muscles; ++i) f[i] = z[i] > 0.0 ? 0.0 : std::max(0.0, f[i]);
  return {MuscleStatus::kOptimal, lcp.pivots, largest_error(H, tau, f)};
}

}  // namespace thenar
