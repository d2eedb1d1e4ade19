#pragma once

#include <array>
#include <optional>
#include <string>

#include "engine/recording.h"

namespace thenar {

/// Less slip than this is micro-slip at a patch's rim, not a finger that slides.
inline constexpr double kNoticedSlip_m = 0.1e-3;

/// Watches a run for the loss of its object: a finger that slips more than 2 mm, an object more than 10 mm or 20
/// degrees off its target, or fewer than two fingers loaded for 50 ms.
class GraspMonitor {
 public:
  explicit GraspMonitor(const Hand& hand) : hand_(hand) {}

  /// Takes the next tick, of `step_s`. Says if the object is lost, and which
  /// fingers slipped since when.
  std::optional<Loss> update(double step_s, const TickRecord& tick);

 private:
  void add_slips(const TickRecord& tick);
  [[nodiscard]] std::string reason(const TickRecord& tick) const;
  [[nodiscard]] std::string slips() const;

  const Hand& hand_;
  std::array<double, kFingers> slip_m_{};
  std::array<std::optional<double>, kFingers> slips_since_s_;
  bool measured_ = false;
  double unloaded_s_ = 0.0;  ///< How long fewer than two fingers have been loaded.
};

}  // namespace thenar
