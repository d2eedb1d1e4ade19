// SPDX-License-Identifier: Apache-2.0
#include "engine/results/force_chatter.h"

#include <algorithm>
#include <cmath>

namespace thenar {

namespace {

constexpr double kChatterWindow_s = 0.3;

/// The oldest frame that a chatter is looked for at, in ticks: beyond it a frame is held, and no loop goes through it.
std::size_t most_stride(const Scene& scene) {
  return 2 + static_cast<std::size_t>(std::ceil((4.0 * scene.control_period_s + scene.control_delay_s) / scene.step_s));
}

}  // namespace

ForceChatter::ForceChatter(const Model& model)
    : model_(model),
      forces_(static_cast<std::size_t>(std::ceil(kChatterWindow_s / model.scene.step_s)) + 1 +
              2 * most_stride(model.scene)) {}

void ForceChatter::add(const TickRecord& tick) {
  if (!tick.is_measured()) return;  // Forces of a grip that builds up are unsteady.
  Forces& now = forces_[kept_++ % forces_.size()];
  now.time_s = tick.time_s;
  now.normal_N = PerFinger<double>(model_.fingers());
  for (int k = 0; k < model_.fingers(); ++k) now.normal_N[k] = tick.force[k].normal_N;
  // A loop through the controller swings with the age that frames reach.
  oldest_frame_ = std::max(oldest_frame_, tick.contact.frame_age);
}

void ForceChatter::pause() {
  before_ = now();
  kept_ = 0;
}

double ForceChatter::now() const {
  const std::size_t frame = std::min(static_cast<std::size_t>(oldest_frame_) + 1, most_stride(model_.scene));
  return std::fmax(before_, std::fmax(at_stride(1), at_stride(frame)));
}

double ForceChatter::at_stride(std::size_t stride) const {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  if (kept_ == 0) return kNothing;
  const auto at = [&](std::size_t i) -> const Forces& { return forces_[i % forces_.size()]; };
  const std::size_t oldest = kept_ > forces_.size() ? kept_ - forces_.size() : 0;
  const double from_s = at(kept_ - 1).time_s - kChatterWindow_s - 1e-9;
  double worst = kNothing;
  for (int k = 0; k < model_.fingers(); ++k) {
    double turns = 0.0, sum = 0.0;
    for (std::size_t i = oldest + 2 * stride; i < kept_; ++i) {
      if (at(i).time_s < from_s) continue;
      const double now_N = at(i).normal_N[k];
      turns += 0.5 * std::abs(now_N - 2.0 * at(i - stride).normal_N[k] + at(i - 2 * stride).normal_N[k]);
      sum += now_N;
    }
    if (sum > 0.0) worst = std::fmax(worst, turns / sum);
  }
  return worst;
}

}  // namespace thenar
