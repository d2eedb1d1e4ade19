// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/split_grasp.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "engine/grasp/carry_over.h"
#include "engine/loops/realtime.h"

namespace thenar {

namespace {

bool is_finite(const FrameContact& contact) {
  return contact.p_F.allFinite() && contact.s_O.allFinite() && contact.n_O.allFinite() && contact.E_F.allFinite() &&
         contact.lean_O.allFinite() && std::isfinite(contact.lean_m_per_N) && std::isfinite(contact.press) &&
         contact.share > 0.0 && contact.t_O.allFinite() && std::isfinite(contact.curvature_per_m) &&
         std::isfinite(contact.ring_curvature_per_m);
}

/// Tests whether the contact side may use the frame: a number that is not finite would remain in the state.
bool is_finite(const Model& model, const Frame& frame) {
  if (!frame.torque_Nm.allFinite() || !frame.wrench.allFinite() || !frame.X_WO.matrix().allFinite()) return false;
  for (int k = 0; k < model.fingers(); ++k) {
    const Eigen::Index contacts_k = frame.begin[k + 1] - frame.begin[k];
    if (!frame.X_WF[k].matrix().allFinite()) return false;
    if (model.deformable() && !frame.compliance[k].is_finite(contacts_k)) return false;
  }
  return std::all_of(frame.contacts.begin(), frame.contacts.end(),
                     [](const FrameContact& contact) { return is_finite(contact); });
}

}  // namespace

SplitGrasp::SplitGrasp(const Model& model, const State& start, const OwnControl& own)
    : model_(model),
      state_(start_of_run(start)),
      memory_(model, split_policy(model.scene)),
      scratch_(model),
      controller_(model),
      frames_(model),
      snapshots_(static_cast<const ContactSnapshot&>(state_)) {
  state_.forces.reserve(model.max_contacts);  // A copied state has lost its spare room.
  controller_.own = own;
  const ControlStep first = control_step();
  if (!first.published) throw std::runtime_error("the first frame of the grasp is not finite");
  first_control_ = first.control;
}

SplitGrasp::SplitGrasp(const Model& model, const Model& old, const SplitGrasp& before)
    : model_(model),
      state_(carry_over(old, before.state_, model)),
      memory_(model, split_policy(model.scene)),
      scratch_(model),
      controller_(before.controller_),
      frames_(model),
      snapshots_(static_cast<const ContactSnapshot&>(state_)) {
  controller_.search = ContactSearch(model);
  controller_.compliance = KeptCompliance(model);
  controller_.afference = Afference(model, old, before.controller_.afference);
  controller_.last_tick = same_time(old, controller_.last_tick, model);
  const ControlStep first = control_step();
  if (!first.published) throw std::runtime_error("the frame after the change is not finite");
  first_control_ = first.control;
  hold_frames_back(static_cast<int>(before.held_back_.size()));
}

void SplitGrasp::heed_scene() noexcept {
  memory_.policy = split_policy(model_.scene);
  scratch_.mu.setConstant(model_.scene.contact.friction);
}

void SplitGrasp::hold_frames_back(int periods) {
  if (periods == static_cast<int>(held_back_.size())) return;
  if (!held_back_.empty()) {
    // The newest on its way comes into use at once: the one in use would be too old before the next one is due.
    Frame& newest = held_back_[(next_held_back_ + held_back_.size() - 1) % held_back_.size()];
    if (newest.sequence >= 0) {
      std::swap(frames_.draft(), newest);
      frames_.publish();
    }
  }
  held_back_.assign(periods, Frame(model_));
  for (Frame& frame : held_back_) frame.contacts.reserve(model_.max_contacts);  // A copy has no spare room.
  next_held_back_ = 0;
}

ContactStep SplitGrasp::contact_step(const TickInput& input) noexcept {
  ContactStep step;
  const std::int64_t start_ns = steady_now_ns();
  frames_.take();
  step.acquire_ns = steady_now_ns() - start_ns;
  step.tick = contact_tick(model_, frames_.current(), memory_, scratch_, state_, input);
  const std::int64_t end_ns = steady_now_ns();
  snapshots_.draft() = state_;
  snapshots_.publish();
  step.publish_ns = steady_now_ns() - end_ns;
  return step;
}

ControlStep SplitGrasp::control_step() {
  ControlStep step;
  snapshots_.take();
  if (!held_back_.empty() && held_back_[next_held_back_].sequence >= 0) {
    std::swap(frames_.draft(), held_back_[next_held_back_]);
    frames_.publish();
  }
  Frame& frame = held_back_.empty() ? frames_.draft() : held_back_[next_held_back_];
  step.control = control_tick(model_, snapshots_.current(), controller_, frame);
  step.sequence = frame.sequence;
  step.snapshot_tick = frame.tick;
  step.published = is_finite(model_, frame);
  if (held_back_.empty()) {
    if (step.published) frames_.publish();
  } else {
    if (!step.published) frame.sequence = -1;
    next_held_back_ = (next_held_back_ + 1) % held_back_.size();
  }
  return step;
}

}  // namespace thenar
