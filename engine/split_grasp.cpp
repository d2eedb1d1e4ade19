#include "engine/split_grasp.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/realtime.h"

namespace thenar {

namespace {

bool is_finite(const FrameContact& contact) {
  return contact.p_F.allFinite() && contact.s_O.allFinite() && contact.n_O.allFinite() && contact.E_F.allFinite() &&
         std::isfinite(contact.curvature_per_m);
}

/// Whether the contact side may use the frame: one number that is not finite would be in the state for good.
bool is_finite(const Model& model, const Frame& frame) {
  if (!frame.torque_Nm.allFinite() || !frame.wrench.allFinite() || !frame.X_WO.matrix().allFinite()) return false;
  for (int k = 0; k < kFingers; ++k) {
    const Eigen::Index rows_k = 3 * (frame.begin[k + 1] - frame.begin[k]);
    if (!frame.X_WF[k].matrix().allFinite()) return false;
    if (model.deformable() && !frame.compliance[k].topLeftCorner(rows_k, rows_k).allFinite()) return false;
  }
  return std::all_of(frame.contacts.begin(), frame.contacts.end(),
                     [](const FrameContact& contact) { return is_finite(contact); });
}

}  // namespace

SplitGrasp::SplitGrasp(const Model& model, const State& start)
    : model_(model),
      state_(start_of_run(start)),
      work_(model, split_policy(model.scene)),
      controller_(model),
      frames_(model),
      snapshots_(static_cast<const Snapshot&>(state_)) {
  state_.forces.reserve(model.max_contacts);  // A copied state has lost its spare room.
  const ControlStep first = control_step();
  if (!first.published) throw std::runtime_error("the first frame of the grasp is not finite");
  first_control_ = first.control;
}

ContactStep SplitGrasp::contact_step(const TickInput& input) noexcept {
  ContactStep step;
  const std::int64_t start_ns = steady_now_ns();
  frames_.take();
  step.acquire_ns = steady_now_ns() - start_ns;
  step.tick = contact_tick(model_, frames_.current(), work_, state_, input);
  const std::int64_t end_ns = steady_now_ns();
  snapshots_.draft() = state_;
  snapshots_.publish();
  step.publish_ns = steady_now_ns() - end_ns;
  return step;
}

ControlStep SplitGrasp::control_step() {
  ControlStep step;
  snapshots_.take();
  Frame& frame = frames_.draft();
  step.control = control_tick(model_, snapshots_.current(), controller_, frame);
  step.sequence = frame.sequence;
  step.snapshot_tick = frame.tick;
  step.published = is_finite(model_, frame);
  if (step.published) frames_.publish();
  return step;
}

}  // namespace thenar
