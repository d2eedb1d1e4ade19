// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/compliance.h"

#include <algorithm>
#include <array>
#include <span>

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// u = rho u + (1 - rho) sum_j k_ij w_j for kRows control points i from `first` on. All sums stay in registers.
template <int kRows>
void deform_rows(const Pulp& pulp, double rho, Index first, const PulpLoads& loads, Eigen::MatrixX3d& u) {
  constexpr int kLanes = std::min(kRows, 8);
  using Lanes = Eigen::Array<float, kLanes, 1>;
  std::array<std::array<Lanes, 3>, kRows / kLanes> sums;
  for (auto& axes : sums) axes.fill(Lanes::Zero());
  for (const PulpLoads::Load& load : loads.loads) {
    const auto column = pulp.rounded_kernel.col(load.control_point);
    for (std::size_t part = 0; part < sums.size(); ++part) {
      const Lanes k = column.segment<kLanes>(first + kLanes * static_cast<Index>(part));
      for (int axis = 0; axis < 3; ++axis) sums[part][axis] += load.w[axis] * k;
    }
  }
  for (std::size_t part = 0; part < sums.size(); ++part) {
    for (int axis = 0; axis < 3; ++axis) {
      auto u_axis = u.col(axis).segment<kLanes>(first + kLanes * static_cast<Index>(part)).array();
      u_axis = rho * u_axis + (1.0 - rho) * sums[part][axis].template cast<double>();
    }
  }
}

}  // namespace

PulpLoads::PulpLoads(const Model& model) {
  if (!model.deformable()) return;
  const Index per_finger = model.max_contacts / model.fingers();
  loads.reserve(per_finger);
  u_m.setZero(3, per_finger);
}

void fill_kernels(const Model& model, Frame& frame) {
  fill_object_kernel(model, frame);
  if (!model.deformable()) return;
  for (int k = 0; k < model.fingers(); ++k) {
    const Pulp& pulp = model.pulps[k];
    const double softness = frame.softness[k];
    SurfaceCompliance& C = frame.compliance[k];
    const std::span<const FrameContact> contacts =
        std::span(frame.contacts).subspan(frame.begin[k], frame.begin[k + 1] - frame.begin[k]);
    for (Index j = 0; j < std::ssize(contacts); ++j) {
      const Index c_j = contacts[j].control_point;
      C.p_m.row(j) = contacts[j].area_m2 > 0.0 ? contacts[j].p_F : Vector3d(pulp.control_points_m.col(c_j));
      const double *const k_j = pulp.kernel.col(c_j).data(), *const a_j = pulp.a.col(c_j).data(),
                          *const b_j = pulp.b.col(c_j).data();
      C.set_column(j, std::ssize(contacts), [&](Index i) -> SurfaceCompliance::Entry {
        if (contacts[i].area_m2 > 0.0 || contacts[j].area_m2 > 0.0) {
          const auto patch = [&](Index of) { return PulpPatch{contacts[of].p_F, area_of(model, contacts[of])}; };
          const PulpCompliance own = pulp_compliance(pulp, patch(i), patch(j));
          return {softness * own.k, softness * own.a, softness * own.b};
        }
        const Index c_i = contacts[i].control_point;
        if (i == j && contacts[i].fades()) {
          const double own = softness / contacts[i].share;
          return {own * k_j[c_i], own * a_j[c_i], own * b_j[c_i]};
        }
        return {softness * k_j[c_i], softness * a_j[c_i], softness * b_j[c_i]};
      });
    }
  }
}

KeptCompliance::KeptCompliance(const Model& model)
    : begin_(model.fingers() + 1), control_points_(model.max_contacts), softness_(model.fingers()) {}

bool KeptCompliance::has_contacts_of(const Frame& frame) const {
  return list_ > 0 && frame.begin == begin_ &&
         std::equal(frame.contacts.begin(), frame.contacts.end(), control_points_.begin(),
                    [](const FrameContact& contact, Index c) { return contact.control_point == c; });
}

void KeptCompliance::update(const Model& model, Frame& frame) {
  const bool same = has_contacts_of(frame), was_whole = whole_;
  whole_ = !model.soft_object() && std::ranges::all_of(frame.contacts, [](const FrameContact& contact) {
    return !contact.fades() && !(contact.area_m2 > 0.0);
  });
  if (!same) {
    ++list_;
    begin_ = frame.begin;
    std::ranges::transform(frame.contacts, control_points_.begin(), &FrameContact::control_point);
  }
  if (!same || !whole_ || !was_whole || !std::ranges::equal(frame.softness, softness_)) ++edition_;
  softness_ = frame.softness;
  frame.list = list_;
  if (frame.compliance_edition == edition_) return;
  fill_kernels(model, frame);
  frame.compliance_edition = edition_;
}

void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            const Eigen::VectorXd& surface_motion, PulpLoads& work, State& state) {
  const Pulp& pulp = model.pulps[k];
  const double rho = retained_share(pulp.material, model.scene.step_s);
  const Index begin = frame.begin[k], contacts = frame.begin[k + 1] - begin;
  Eigen::MatrixX3d& u = state.u_m[k];
  work.loads.clear();
  for (Index i = 0; i < contacts; ++i) {
    const Index c = frame.contacts[begin + i].control_point;
    Matrix3d E_F = now.E_F[begin + i];
    const Vector3d moved = surface_motion.segment<3>(3 * (begin + i));
    // Its columns are orthogonal; of a contact that fades the first one's length is what the gap grows by.
    if (frame.contacts[begin + i].fades()) E_F.col(0) /= E_F.col(0).squaredNorm();
    work.u_m.col(i) = rho * now.points[begin + i].u_F + E_F * moved;
    const Vector3d f_i = f.segment<3>(3 * (begin + i));
    if (f_i[0] <= 0.0) continue;
    const Vector3d mean(1.0, pulp.tangential, pulp.tangential);
    work.loads.push_back({c, (frame.softness[k] * (E_F * mean.cwiseProduct(f_i))).cast<float>()});
  }
  Index first = 0;
  for (; first + 32 <= u.rows(); first += 32) deform_rows<32>(pulp, rho, first, work, u);
  for (; first + 8 <= u.rows(); first += 8) deform_rows<8>(pulp, rho, first, work, u);
  for (; first < u.rows(); ++first) deform_rows<1>(pulp, rho, first, work, u);
  for (Index i = 0; i < contacts; ++i) u.row(frame.contacts[begin + i].control_point) = work.u_m.col(i).transpose();
}

}  // namespace thenar
