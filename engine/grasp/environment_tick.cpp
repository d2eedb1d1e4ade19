// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/environment_tick.h"

#include <utility>

namespace thenar {

using Eigen::Vector3d;

namespace {

/// So many ticks from now.
Instant after(const Model& model, const State& state, std::int64_t ticks) {
  return instant(state.arm, static_cast<double>(state.tick + ticks) * model.scene.step_s);
}

}  // namespace

void look_around(const Model& model, const Mobility& mobility, const Vector6d& wrench, const State& state,
                 EnvironmentContacts& contacts, const std::optional<Vector6d>& after_motion) {
  if (contacts.pairs.empty()) return;
  const Scene& scene = model.scene;
  const double way_m =
      mobility.translation * wrench.head<3>().norm() + contacts.reach_m * mobility.rotation * wrench.tail<3>().norm();
  find_environment_contacts(*scene.environment, state.X_WO, after(model, state, 0), after(model, state, 1),
                            scene.contact.band_m + way_m, state.environment_forces, contacts, after_motion);
}

bool look_again(const Model& model, const Mobility& mobility, const Vector6d& wrench, const State& state,
                const Vector6d& x, ContactMemory& memory, ContactScratch& work) {
  constexpr double kNews_m = 5e-9;  // What a twentieth of a newton presses in, usually.
  if (memory.solver.ground_status != SolveStatus::kConverged) return false;  // These forces press in more than c f.
  if (!(may_miss_m(work.environment, x) > kNews_m)) return false;
  keep_forces(work.environment, memory.solver.ground.f, work.environment_again.then);
  look_around(model, mobility, wrench, state, work.environment_again, x);
  const double news_m = missed_m(*model.scene.environment, work.environment_again, x, work.environment_again.then);
  if (!(news_m > kNews_m)) return false;
  std::swap(work.environment, work.environment_again);
  return true;
}

std::optional<CommonGround> ground_of(const Model& model, const Mobility& mobility, const Vector6d& wrench,
                                      const EnvironmentContacts& contacts) {
  if (!model.scene.environment || contacts.pairs.empty()) return std::nullopt;
  CommonGround ground{{contacts.contacts, model.scene.environment->compliance_m_per_N, {}}, {}};
  ground.problem.mobility << Vector3d::Constant(mobility.translation), Vector3d::Constant(mobility.rotation);
  ground.x_free = ground.problem.mobility.cwiseProduct(wrench);
  return ground;
}

void keep_environment(const ContactMemory& memory, const ContactScratch& work, State& state,
                      EnvironmentReport& report) {
  report = environment_report(work.environment, memory.solver.ground.f, memory.solver.ground.x);
  keep_forces(work.environment, memory.solver.ground.f, state.environment_forces);
}

}  // namespace thenar
