#include "engine/grasp_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace thenar {

namespace {

constexpr double kLostSlip_m = 2e-3;
constexpr double kLostOffset_m = 10e-3;
constexpr double kLostTurn_rad = 20.0 * std::numbers::pi / 180.0;
constexpr double kLostUnloaded_s = 0.05;

}  // namespace

std::optional<Loss> GraspMonitor::update(double step_s, const TickRecord& tick) {
  add_slips(tick);
  const auto loaded =
      std::count_if(tick.force.begin(), tick.force.end(), [](const auto& f) { return f.normal_N > 0.0; });
  unloaded_s_ = loaded < 2 ? unloaded_s_ + step_s : 0.0;
  const std::string why = reason(tick);
  if (why.empty()) return std::nullopt;
  Loss loss{tick.time_s, tick.time_s, unloaded_s_ > kLostUnloaded_s ? LossCause::kUnloaded : LossCause::kOffTarget,
            why + slips()};
  for (const auto& since_s : slips_since_s_) {
    if (!since_s) continue;
    loss.since_s = std::min(loss.since_s, *since_s);
    loss.cause = LossCause::kSlipped;
  }
  return loss;
}

void GraspMonitor::add_slips(const TickRecord& tick) {
  // What fingers slip while they first touch is not theirs to answer for, unless the object is lost by it.
  if (tick.is_measured() && !measured_) {
    slip_m_.fill(0.0);
    slips_since_s_.fill(std::nullopt);
    measured_ = true;
  }
  for (int k = 0; k < kFingers; ++k) {
    slip_m_[k] += tick.contact.patch[k].slip_m;
    if (!slips_since_s_[k] && slip_m_[k] > kNoticedSlip_m) slips_since_s_[k] = tick.time_s;
  }
}

std::string GraspMonitor::reason(const TickRecord& tick) const {
  for (int k = 0; k < kFingers; ++k) {
    if (!measured_ || slip_m_[k] <= kLostSlip_m) continue;
    return fmt::format("the {} slipped more than {:g} mm", hand_.fingertips[k].finger, 1e3 * kLostSlip_m);
  }
  const double offset_m = (tick.position_m - tick.target_m).norm();
  // Written so that what is not a number is lost, too.
  if (!(offset_m <= kLostOffset_m)) return fmt::format("the object is {:.1f} mm off its target", 1e3 * offset_m);
  if (!(tick.rotation_error_rad <= kLostTurn_rad)) {
    const double turn_deg = tick.rotation_error_rad * 180.0 / std::numbers::pi;
    return fmt::format("the object is turned {:.0f} degrees off its target", turn_deg);
  }
  if (unloaded_s_ <= kLostUnloaded_s) return "";
  return fmt::format("fewer than two fingers carried load for {:.0f} ms", 1e3 * kLostUnloaded_s);
}

std::string GraspMonitor::slips() const {
  std::string all;
  for (int k = 0; k < kFingers; ++k) {
    if (!slips_since_s_[k]) continue;
    const Fingertip& tip = hand_.fingertips[k];
    // Beyond its radius nothing is left of a patch whose slip could be told.
    const std::string how_far =
        slip_m_[k] > tip.radius_m ? std::string("slid off") : fmt::format("{:.1f} mm", 1e3 * slip_m_[k]);
    all += fmt::format("{} {} slipped from {:.3f} s on ({})", all.empty() ? ";" : ",", tip.finger, *slips_since_s_[k],
                       how_far);
  }
  return all;
}

}  // namespace thenar
