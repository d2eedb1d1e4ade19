// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/pairing.h"

#include <cstdint>
#include <utility>

namespace thenar {

Pairing::Pairing(OnTick on_tick, OnControl on_control)
    : on_tick_(std::move(on_tick)), on_control_(std::move(on_control)) {}

void Pairing::add(const ContactSample& sample) {
  contact_.push_back(sample);
  give(false);
}

void Pairing::add(const ControlSample& sample) {
  if (sample.step.published) control_.push_back(sample);
  give(false);
}

void Pairing::give(bool all) {
  while (!contact_.empty() && !ended_) {
    const std::int64_t sequence = contact_.front().step.tick.sequence;
    const bool known =
        sequence <= in_use_.step.sequence || (!control_.empty() && control_.back().step.sequence >= sequence);
    if (!known && !all) return;
    // Before it is passed on: a record at which a receiver throws is not passed again.
    const ContactSample sample = std::move(contact_.front());
    contact_.pop_front();
    give(sample);
  }
}

void Pairing::give(const ContactSample& sample) {
  while (!control_.empty() && control_.front().step.sequence <= sample.step.tick.sequence) {
    in_use_ = std::move(control_.front());
    control_.pop_front();
    if (on_control_) on_control_(sample, in_use_);
  }
  ended_ = !on_tick_(sample, in_use_);
}

}  // namespace thenar
