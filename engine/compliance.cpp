#include "engine/compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

void fill_compliance(const Model& model, Frame& frame) {
  if (!model.deformable()) return;
  for (int k = 0; k < kFingers; ++k) {
    const Pulp& pulp = model.pulps[k];
    const Vector3d S(1.0, pulp.tangential, pulp.tangential);
    for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
      const FrameContact& cj = frame.contacts[j];
      const Matrix3d E_j_S = frame.softness[k] * cj.E_F * S.asDiagonal();
      for (Index i = frame.begin[k]; i <= j; ++i) {
        const FrameContact& ci = frame.contacts[i];
        const Matrix3d C_ij =
            pulp.kernel(ci.control_point, cj.control_point) * (S.asDiagonal() * (ci.E_F.transpose() * E_j_S));
        const Index row = 3 * (i - frame.begin[k]), column = 3 * (j - frame.begin[k]);
        frame.compliance[k].block<3, 3>(row, column) = C_ij;
        frame.compliance[k].block<3, 3>(column, row) = C_ij.transpose();
      }
    }
  }
}

void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            Eigen::MatrixX3d& kernel_sum, State& state) {
  const Pulp& pulp = model.pulps[k];
  const double rho = memory(pulp.material, model.scene.step_s);
  auto& sum = kernel_sum;  // of k_ij T_j f_j over the contacts j
  sum.setZero();
  for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
    if (f[3 * j] <= 0.0) continue;
    const Matrix3d& E_F = now.E_F[j];
    const Vector3d w = frame.softness[k] * (pulp.tensor(E_F.col(0)) * (E_F * f.segment<3>(3 * j)));
    sum.noalias() += pulp.kernel.col(frame.contacts[j].control_point) * w.transpose();
  }
  auto& u = state.u_m[k];
  const auto& N = pulp.control_normals;
  const double a = pulp.tangential;
  // T_i of the rest normal everywhere, then of the contact's own normal at the contacts, as in W.
  u = rho * u +
      (1.0 - rho) * (a * sum + (1.0 - a) * ((N.array() * sum.array()).rowwise().sum().matrix().asDiagonal() * N));
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    const Index c = frame.contacts[i].control_point;
    const Matrix3d change = pulp.tensor(now.E_F[i].col(0)) - pulp.tensor(N.row(c).transpose());
    u.row(c) += (1.0 - rho) * (sum.row(c) * change);
  }
}

}  // namespace thenar
