// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/grouped_delassus.h"

namespace thenar {

/// A Delassus operator in factors that owns its parts.
struct FactoredContacts {
  std::vector<Eigen::Index> begin{0};
  GroupedDelassus::OwnJacobian J_own;
  Eigen::VectorXd J_fifth;
  GroupedDelassus::CommonJacobian J_common;
  double own_mobility = 0.0;
  GroupedDelassus::CommonMotion common_mobility = GroupedDelassus::CommonMotion::Zero();
  std::vector<SurfaceCompliance> compliance;
  GroupedDelassus::Axes axes;
  double compliance_scale = 1.0;
  Eigen::MatrixXd common_k;  ///< Of a common body that gives way; empty: it is rigid.
  GroupedDelassus::Axes common_T;
  double common_scale = 1.0;

  [[nodiscard]] GroupedDelassus operator_of() const {
    return {.begin = begin,
            .J_own = J_own,
            .J_fifth = J_fifth,
            .J_common = J_common,
            .own_mobility = own_mobility,
            .common_mobility = common_mobility,
            .compliance = compliance,
            .axes = axes,
            .compliance_scale = compliance_scale,
            .common_compliance =
                common_k.size() > 0 ? SharedCompliance{&common_k, &common_T, common_scale} : SharedCompliance{}};
  }

  [[nodiscard]] GroupedContactProblem problem(const Eigen::VectorXd& delta_free, const Eigen::VectorXd& mu) const {
    return {operator_of(), delta_free, mu};
  }

  [[nodiscard]] double bytes() const {
    Eigen::Index numbers = J_own.size() + J_fifth.size() + J_common.size() + common_mobility.size() + axes.size() +
                           common_k.size() + common_T.size();
    double bytes = 0.0;
    for (const SurfaceCompliance& C : compliance) {
      numbers += C.p_m.size() + C.k.size() + C.a.size() + C.b.size();
      bytes += static_cast<double>(sizeof(float) * (C.normal_rows.size() + C.cross_rows.size() + C.bent_rows.size()));
    }
    return bytes + static_cast<double>(sizeof(double)) * static_cast<double>(numbers);
  }

  [[nodiscard]] Eigen::MatrixXd dense() const {
    Eigen::MatrixXd W(3 * begin.back(), 3 * begin.back());
    operator_of().to_dense(W);
    return W;
  }
};

}  // namespace thenar
