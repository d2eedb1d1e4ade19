// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>

#include "solvers/contact_sweeps.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

using Eigen::Index;

SurfaceCompliance::SurfaceCompliance(Index contacts) {
  const Index rows = 3 * contacts + SweepWorkspace::kPadding;
  p_m.setZero(contacts, 3);
  for (Eigen::MatrixXd* m : {&k, &a, &b}) m->setZero(contacts, contacts);
  for (Eigen::MatrixXf* m : {&normal_rows, &cross_rows, &bent_rows}) m->setZero(rows, contacts);
}

Eigen::Matrix3d SurfaceCompliance::entry(Index i, Index j, const Eigen::Matrix3d& E_i,
                                         const Eigen::Matrix3d& E_j) const {
  const Eigen::Vector3d r = p_m.row(i) - p_m.row(j);
  Eigen::Matrix3d C = k(i, j) * E_i.transpose() * E_j;
  const Eigen::Matrix3d bent = a(i, j) * E_i.transpose() * E_j + b(i, j) * E_i.transpose() * r * r.transpose() * E_j;
  C.bottomRightCorner<2, 2>() += bent.bottomRightCorner<2, 2>();
  return C;
}

bool SurfaceCompliance::is_finite(Index contacts) const {
  const auto finite = [&](const Eigen::MatrixXd& m) { return m.topLeftCorner(contacts, contacts).allFinite(); };
  return finite(k) && finite(a) && finite(b) && p_m.topRows(contacts).allFinite();
}

void add_compliance(const SurfaceCompliance& compliance, const GroupedDelassus::Axes& axes, Index first, double scale,
                    Eigen::Ref<Eigen::MatrixXd> W) {
  for (Index j = 0; 3 * j < W.cols(); ++j) {
    const Eigen::Matrix3d E_j = axes.middleRows<3>(3 * (first + j)).transpose();
    for (Index i = 0; 3 * i < W.rows(); ++i) {
      W.block<3, 3>(3 * i, 3 * j) +=
          scale * compliance.entry(i, j, axes.middleRows<3>(3 * (first + i)).transpose(), E_j);
    }
  }
}

void add_compliance(const SharedCompliance& compliance, Eigen::Ref<Eigen::MatrixXd> W) {
  for (Index j = 0; 3 * j < W.cols(); ++j) {
    const Eigen::Matrix3d T_j = compliance.scale * compliance.T->middleRows<3>(3 * j).transpose();
    for (Index i = 0; 3 * i < W.rows(); ++i)
      W.block<3, 3>(3 * i, 3 * j) += (*compliance.k)(i, j) * (compliance.T->middleRows<3>(3 * i) * T_j);
  }
}

}  // namespace thenar
