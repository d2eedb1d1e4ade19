// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/picture.h"

#include <memory>
#include <optional>
#include <vector>

namespace thenar {

namespace {

/// Returns those of the last tick; before the first one there are none.
void take_touches(const ContactMemory& memory, const ContactScratch& work, std::vector<ShownTouch>& touches) noexcept {
  touches.clear();
  const EnvironmentContacts& around = work.environment;
  for (std::size_t i = 0; i < around.found.size(); ++i) {
    const Eigen::Vector3d& f = memory.solver.ground.f[i];
    if (!(f[0] > 0.0)) continue;
    const auto E_W = around.contacts[i].J.leftCols<3>().transpose();
    touches.push_back({around.found[i].body, around.found[i].at.p_m, E_W.col(0), E_W * f});
  }
}

}  // namespace

std::size_t most_touches(const Scene& scene) {
  if (!scene.environment) return 0;
  const std::optional<Solid> exact = solid_of(scene.object.shape);
  const TouchingSolid object = exact ? TouchingSolid(*exact) : TouchingSolid(std::shared_ptr<const SampledSolid>());
  std::size_t most = 0;
  for (const EnvironmentBody& body : scene.environment->bodies) most += most_contacts(object, body.shape);
  return most;
}

Picture::Picture(const Model& model) : step_s(model.scene.step_s) {
  snapshot.q = model.scene.posture;
  snapshot.X_WO = model.scene.object.X_WO;
  if (model.scene.has_muscles()) snapshot.pull_N.setZero(std::ssize(model.scene.hand.muscles));
  for (const Pulp& pulp : model.pulps) u_m.emplace_back(Eigen::MatrixX3d::Zero(pulp.controls(), 3));
  contacts.reserve(model.max_contacts);
  touches.reserve(most_touches(model.scene));
}

void take_picture(const State& state, const ContactMemory& memory, const ContactScratch& work,
                  Picture& picture) noexcept {
  picture.snapshot = state;
  for (std::size_t k = 0; k < state.u_m.size(); ++k) picture.u_m[k] = state.u_m[k];
  picture.contacts.clear();
  for (const ContactForce& contact : state.forces) {
    // The state's forces are those of the tick's contacts, in their order.
    const std::size_t i = picture.contacts.size();
    const Eigen::Matrix3d& E_W = work.kinematics.E_W[i];
    picture.contacts.push_back({contact.finger, contact.control_point, work.kinematics.c_W[i], E_W.col(0),
                                E_W * contact.f_C, contact.f_C[0], contact.f_C.tail<2>().norm(), contact.share});
  }
  take_touches(memory, work, picture.touches);
  for (const PatchPoint& point : work.patches.points) {
    const auto i = static_cast<std::size_t>(point.contact);
    if (i < picture.contacts.size()) picture.contacts[i].slip_m_per_s = point.d_W.norm() / picture.step_s;
  }
}

}  // namespace thenar
