// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/live_contact.h"

namespace thenar {

using Eigen::Index;

SolvedTick::SolvedTick(const Model& model)
    : frame(model),
      kinematics(model),
      delta_free(3 * model.max_contacts),
      mu(model.max_contacts),
      f_first(3 * model.max_contacts),
      f(3 * model.max_contacts) {
  ground.reserve(most_touches(model.scene));
  ground_N.reserve(ground.capacity());
}

LiveContact::LiveContact(const Model& model, LatestValue<LiveInput>& live_inputs, LiveHands& live_hands)
    : inputs(live_inputs), hands(live_hands), pictures(model), problems(model) {}

TickInput LiveContact::input(const State& state, std::int64_t now_ns, std::int64_t& stamp_ns) noexcept {
  inputs.take();
  const LiveInput& newest = inputs.current();
  stamp_ns = newest.number != number ? newest.stamp_ns : 0;
  number = newest.number;
  return hands.next(newest, state, now_ns);
}

bool LiveContact::show(const SplitGrasp& grasp) noexcept {
  if (tap != nullptr) tap->keep(grasp.state(), grasp.memory(), grasp.scratch(), hands.pull());
  // Relaxed: it orders nothing else.
  if (!watched.load(std::memory_order_relaxed)) return false;
  const ContactMemory& memory = grasp.memory();
  const ContactScratch& work = grasp.scratch();
  if (grasp.state().tick % problem_ticks == 0) {
    SolvedTick& draft = problems.draft();
    draft.frame = grasp.frames().current();
    const Index n = draft.frame.size();
    draft.kinematics = work.kinematics;
    draft.mobility = work.mobility;
    draft.delta_free.head(3 * n) = work.delta_free.head(3 * n);
    draft.mu.head(n) = work.mu.head(n);
    draft.f_first.head(3 * n) = work.f_first.head(3 * n);
    draft.f.head(3 * n) = memory.f.head(3 * n);
    const std::vector<GroundContact>& ground = work.environment.contacts;
    draft.ground.assign(ground.begin(), ground.end());
    draft.ground_N.assign(memory.solver.ground.f.begin(), memory.solver.ground.f.begin() + std::ssize(ground));
    draft.x_free = memory.solver.ground.x - memory.solver.common_motion.head<6>();
    problems.publish();
  }
  if (grasp.state().tick % picture_ticks != 0) return false;
  take_picture(grasp.state(), memory, work, pictures.draft());
  pictures.draft().pull = hands.pull();
  pictures.publish();
  return true;
}

}  // namespace thenar
