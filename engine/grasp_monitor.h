#pragma once

#include <array>
#include <optional>

#include "engine/recording.h"

namespace thenar {

/// From here on a run is measured: the grip has built up.
inline constexpr double kMeasuredFrom_s = 0.3;

/// Watches a run for the loss of its object: a finger that slips more than 2 mm, an object more than 10 mm or 20
/// degrees off its target, or fewer than two fingers loaded for 50 ms.
class GraspMonitor {
 public:
  explicit GraspMonitor(const Hand& hand) : hand_(hand) {}

  /// Takes the next tick of `step_s`; says if the object is lost, and by which finger's slip.
  std::optional<Loss> update(const TickRecord& tick, double step_s);

 private:
  [[nodiscard]] std::string slips() const;

  const Hand& hand_;
  std::array<double, kFingers> slip_m_{};  ///< Since kMeasuredFrom_s.
  std::array<double, kFingers> slip_from_start_m_{};
  std::array<std::optional<double>, kFingers> slips_since_s_;
  double unloaded_s_ = 0.0;  ///< How long fewer than two fingers have been loaded.
};

}  // namespace thenar
