#include "engine/compliance.h"

#include <algorithm>

#include "engine/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// u = rho u + (1 - rho) T sum_j k_ij w_j for kRows control points i from `first` on, T of the rest normal. All sums stay
/// in registers.
template <int kRows>
void deform_rows(const Pulp& pulp, double rho, Index first, PulpLoads& loads, Eigen::MatrixX3d& u) {
  using Lanes = Eigen::Array<double, kRows, 1>;
  Lanes x = Lanes::Zero(), y = x, z = x;
  for (const PulpLoads::Load& load : loads.loads) {
    const Lanes k = pulp.kernel.col(load.control_point).segment<kRows>(first);
    x += load.w.x() * k;
    y += load.w.y() * k;
    z += load.w.z() * k;
  }
  const auto put = [&](const Lanes& value, int axis) {
    loads.kernel_sum.col(axis).segment<kRows>(first) = value;
    return value;
  };
  const auto normal = [&](int axis) { return pulp.control_normals.col(axis).segment<kRows>(first).array(); };
  const Lanes along = (1.0 - rho) * (1.0 - pulp.tangential) * (normal(0) * x + normal(1) * y + normal(2) * z);
  const double across = (1.0 - rho) * pulp.tangential;
  const auto move = [&](const Lanes& sum, int axis) {
    auto u_axis = u.col(axis).segment<kRows>(first).array();
    u_axis = rho * u_axis + across * put(sum, axis) + along * normal(axis);
  };
  move(x, 0);
  move(y, 1);
  move(z, 2);
}

}  // namespace

PulpLoads::PulpLoads(const Model& model) {
  if (!model.deformable()) return;
  loads.reserve(model.max_contacts / kFingers);
  kernel_sum.setZero(model.pulps.front().controls(), 3);
}

void fill_kernels(const Model& model, Frame& frame) {
  fill_object_kernel(model, frame);
  if (!model.deformable()) return;
  for (int k = 0; k < kFingers; ++k) {
    const Index begin = frame.begin[k], end = frame.begin[k + 1];
    for (Index j = begin; j < end; ++j) {
      const auto k_j = model.pulps[k].kernel.col(frame.contacts[j].control_point);
      for (Index i = begin; i < end; ++i) {
        frame.kernel[k](i - begin, j - begin) = frame.softness[k] * k_j[frame.contacts[i].control_point];
      }
    }
  }
}

void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            PulpLoads& work, State& state) {
  const Pulp& pulp = model.pulps[k];
  const double rho = memory(pulp.material, model.scene.step_s);
  work.loads.clear();
  for (Index j = frame.begin[k]; j < frame.begin[k + 1]; ++j) {
    if (f[3 * j] <= 0.0) continue;
    const Vector3d w = now.pulp_tensors.middleRows<3>(3 * j).transpose() * f.segment<3>(3 * j);
    work.loads.push_back({frame.contacts[j].control_point, frame.softness[k] * w});
  }
  // T_i of the rest normal everywhere, then of the contact's own normal at the contacts, as in W.
  constexpr int kRows = 8;
  Eigen::MatrixX3d& u = state.u_m[k];
  Index first = 0;
  for (; first + kRows <= u.rows(); first += kRows) deform_rows<kRows>(pulp, rho, first, work, u);
  for (; first < u.rows(); ++first) deform_rows<1>(pulp, rho, first, work, u);
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    const Index c = frame.contacts[i].control_point;
    const Vector3d sum = work.kernel_sum.row(c).transpose(), n = now.E_F[i].col(0), N = pulp.control_normals.row(c);
    const Vector3d change = (1.0 - rho) * (1.0 - pulp.tangential) * (n.dot(sum) * n - N.dot(sum) * N);
    u.row(c) += change.transpose();
  }
}

}  // namespace thenar
