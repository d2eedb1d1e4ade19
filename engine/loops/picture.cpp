#include "engine/loops/picture.h"

namespace thenar {

Picture::Picture(const Model& model) {
  snapshot.q = model.scene.posture;
  snapshot.X_WO = model.scene.object.X_WO;
  for (const Pulp& pulp : model.pulps) u_m.emplace_back(Eigen::MatrixX3d::Zero(pulp.controls(), 3));
  contacts.reserve(model.max_contacts);
}

void take_picture(const State& state, const ContactWorkspace& work, Picture& picture) noexcept {
  picture.snapshot = state;
  for (std::size_t k = 0; k < state.u_m.size(); ++k) picture.u_m[k] = state.u_m[k];
  picture.contacts.clear();
  for (const ContactForce& contact : state.forces) {
    // The state's forces are those of the tick's contacts, in their order.
    const std::size_t i = picture.contacts.size();
    const Eigen::Matrix3d& E_W = work.kinematics.E_W[i];
    picture.contacts.push_back(
        {contact.finger, contact.control_point, work.kinematics.c_W[i], E_W.col(0), E_W * contact.f_C});
  }
  for (const PatchPoint& point : work.patches.points) {
    const auto i = static_cast<std::size_t>(point.contact);
    if (i < picture.contacts.size()) picture.contacts[i].slip_m = point.d_W.norm();
  }
}

}  // namespace thenar
