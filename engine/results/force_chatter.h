// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/results/recording.h"

namespace thenar {

/// The chatter of the fingers' forces, see Verdict, over the last ticks in which the fingers held the object.
class ForceChatter {
 public:
  explicit ForceChatter(const Model& model);

  void add(const TickRecord& tick);
  /// Begins anew: the fingers let go. What was before is remembered.
  void pause();
  /// Returns the largest so far of what was before a pause, and now. NaN where no finger was loaded.
  [[nodiscard]] double now() const;

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(forces_, kept_, before_, oldest_frame_);
  }

 private:
  struct Forces {
    double time_s = 0.0;
    PerFinger<double> normal_N;

    template <typename Archive>
    void members(Archive& a) {
      a(time_s, normal_N);
    }
  };

  /// Returns it for forces that are `stride` ticks apart.
  [[nodiscard]] double at_stride(std::size_t stride) const;

  const Model& model_;
  std::vector<Forces> forces_;  ///< Forces of the last ticks, as far back as it looks: a ring.
  std::size_t kept_ = 0;
  double before_ = std::numeric_limits<double>::quiet_NaN();
  std::int64_t oldest_frame_ = 0;
};

}  // namespace thenar
