// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/ledger.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

/// Elastic energy a step later of a body that was moved by u = rho u + (1 - rho) C f. With phi the force that holds u,
/// u = C phi and phi+ = rho phi + (1 - rho) f, energy is phi.u / 2, and only f.u at the loaded points is needed.
double elastic_energy(double energy_J, double rho, double f_u_before_J, double f_u_after_J) {
  return rho * rho * energy_J + 0.5 * (1.0 - rho) * (f_u_after_J + rho * f_u_before_J);
}

}  // namespace

void book_deformation(const Model& model, const Frame& frame, const ContactMemory& memory, const ContactScratch& work,
                      bool at_once, State& state, Ledger& ledger) {
  const auto kept = [&](const PulpMaterial& material) {
    return at_once ? 0.0 : retained_share(material, model.scene.step_s);
  };
  double object_before_J = 0.0, object_after_J = 0.0;
  for (int k = 0; k < model.fingers(); ++k) {
    double before_J = 0.0, after_J = 0.0;
    for (const PatchPoint& point : work.patches.of_finger(k)) {
      const Vector3d f_F = work.kinematics.E_F[point.contact] * memory.f.segment<3>(3 * point.contact);
      const ContactPoint& before = work.kinematics.points[point.contact];
      before_J += f_F.dot(before.u_F);
      after_J += f_F.dot(point.u_end_F);
      if (!at_once) state.forces[point.contact].held_J = 0.5 * f_F.dot(point.u_end_F);
      if (!model.soft_object()) continue;
      const Vector3d f_O = work.kinematics.E_O[point.contact] * memory.f.segment<3>(3 * point.contact);
      object_before_J += f_O.dot(before.u_O);
      object_after_J += f_O.dot(point.u_end_O);
    }
    // Kept as that of the pulp without load, whose compliance is no frame's.
    double& energy_J = state.pulp_energy_J[k];
    energy_J = elastic_energy(energy_J, kept(model.pulps[k].material), frame.softness[k] * before_J,
                              frame.softness[k] * after_J);
    ledger.deformation_J += after_J - before_J;
    ledger.stored_J += energy_J / frame.softness[k];
  }
  if (!model.soft_object()) return;
  state.object_energy_J =
      elastic_energy(state.object_energy_J, kept(*model.scene.object.compliance), object_before_J, object_after_J);
  ledger.deformation_J += object_after_J - object_before_J;
  ledger.stored_J += state.object_energy_J;
}

void book_environment(const Environment& environment, const ContactMemory& memory, const ContactScratch& work,
                      Ledger& ledger) {
  const EnvironmentWork done =
      environment_work(environment, work.environment, memory.solver.ground.f, memory.solver.ground.x);
  ledger.drive_J += done.moving_J;
  ledger.deformation_J += done.deformation_J;
  ledger.stored_J += done.stored_J;
  ledger.injected_J += done.injected_J;
  ledger.dissipated_J += done.dissipated_J;
  ledger.dropped_J += done.dropped_J;
}

}  // namespace thenar
