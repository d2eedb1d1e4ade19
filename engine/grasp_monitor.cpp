#include "engine/grasp_monitor.h"

#include <cstdio>
#include <numbers>

namespace thenar {

namespace {

constexpr double kLostSlip_m = 2e-3;
constexpr double kLostOffset_m = 10e-3;
constexpr double kLostTurn_rad = 20.0 * std::numbers::pi / 180.0;
constexpr double kLostUnloaded_s = 0.05;
constexpr double kNoticedSlip_m = 0.1e-3;  // Less than this is rim micro-slip, not a finger that slides.

template <typename... Values>
std::string text(const char* format, Values... values) {
  char line[160];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

}  // namespace

std::optional<Loss> GraspMonitor::update(const TickRecord& tick, double step_s) {
  int loaded = 0;
  for (int k = 0; k < kFingers; ++k) {
    loaded += tick.force[k].normal_N > 0.0 ? 1 : 0;
    slip_from_start_m_[k] += tick.contact.slip_m[k];
    if (tick.time_s >= kMeasuredFrom_s) slip_m_[k] += tick.contact.slip_m[k];
    if (!slips_since_s_[k] && slip_from_start_m_[k] > kNoticedSlip_m) slips_since_s_[k] = tick.time_s;
  }
  unloaded_s_ = loaded < 2 ? unloaded_s_ + step_s : 0.0;

  const double offset_m = (tick.position_m - tick.target_m).norm();
  std::string reason;
  for (int k = 0; k < kFingers; ++k) {
    if (reason.empty() && slip_m_[k] > kLostSlip_m) {
      reason = text("the %s slipped more than %.0f mm", hand_.fingertips[k].finger.c_str(), 1e3 * kLostSlip_m);
    }
  }
  if (reason.empty() && offset_m > kLostOffset_m) reason = text("the object is %.1f mm off its target", 1e3 * offset_m);
  if (reason.empty() && tick.rotation_error_rad > kLostTurn_rad) {
    reason =
        text("the object is turned %.0f degrees off its target", tick.rotation_error_rad * 180.0 / std::numbers::pi);
  }
  if (reason.empty() && unloaded_s_ > kLostUnloaded_s) {
    reason = text("fewer than two fingers carried load for %.0f ms", 1e3 * kLostUnloaded_s);
  }
  if (reason.empty()) return std::nullopt;
  return Loss{tick.time_s, reason + slips()};
}

std::string GraspMonitor::slips() const {
  std::string all;
  for (int k = 0; k < kFingers; ++k) {
    if (!slips_since_s_[k]) continue;
    all += text("%s %s slipped from %.3f s on (%.1f mm)", all.empty() ? ";" : ",", hand_.fingertips[k].finger.c_str(),
                *slips_since_s_[k], 1e3 * slip_from_start_m_[k]);
  }
  return all;
}

}  // namespace thenar
