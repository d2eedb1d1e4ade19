// SPDX-License-Identifier: Apache-2.0
#include "engine/control/afference.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/carry_over.h"

namespace thenar {

std::int64_t ticks_of(const Model& model, double delay_s) { return std::llround(delay_s / model.scene.step_s); }

Afference::Afference(const Model& model) {
  if (!model.scene.control) return;
  const ControlSettings& control = *model.scene.control;
  const double delay_s =
      std::max(control.feedback_delay_s, model.feels() ? model.scene.fingertips->touch->delay_s : 0.0);
  if (delay_s <= 0.0 && !model.feels()) return;
  // One per tick: the control rate may change during a run.
  past_.assign(static_cast<std::size_t>(ticks_of(model, delay_s)) + 2,
               {State(model), FingerForces::Zero(3, model.fingers())});
}

Afference::Afference(const Model& model, const Model& old, const Afference& before) : Afference(model) {
  if (past_.empty()) return;
  for (std::size_t i = before.count_ - std::min(before.count_, before.past_.size()); i < before.count_; ++i) {
    const Sensed& sensed = before.past_[i % before.past_.size()];
    add(sensed.snapshot, sensed.desired_N.reshaped());
    past_[(count_ - 1) % past_.size()].snapshot.tick = same_time(old, sensed.snapshot.tick, model);
  }
}

void Afference::add(const Snapshot& snapshot, const Eigen::VectorXd& desired_N) {
  const bool again = count_ > 0 && past_[(count_ - 1) % past_.size()].snapshot.tick == snapshot.tick;
  if (!again) ++count_;
  past_[(count_ - 1) % past_.size()].snapshot = snapshot;
  set_desired(desired_N);
}

void Afference::set_desired(const Eigen::VectorXd& desired_N) {
  FingerForces& newest = past_[(count_ - 1) % past_.size()].desired_N;
  newest = desired_N.reshaped(3, newest.cols());
}

const Sensed& Afference::at(std::int64_t tick) const {
  const std::size_t oldest = count_ - std::min(count_, past_.size());
  for (std::size_t i = count_; i > oldest + 1; --i) {
    if (const Sensed& past = past_[(i - 1) % past_.size()]; past.snapshot.tick <= tick) return past;
  }
  return past_[oldest % past_.size()];
}

}  // namespace thenar
