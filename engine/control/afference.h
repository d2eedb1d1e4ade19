#pragma once

#include <cstdint>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// The last snapshots, for what is known late. It takes its memory when it is made.
class Afference {
 public:
  /// For the longest delay that the scene's control names; empty, and at() is not to be asked, without one.
  explicit Afference(const Model& model);

  [[nodiscard]] bool is_needed() const { return !past_.empty(); }
  /// The next one; of a later tick than the last.
  void add(const Snapshot& snapshot);
  /// The newest that is no newer than `tick`, or where there is none, the oldest.
  [[nodiscard]] const Snapshot& at(std::int64_t tick) const;
  /// Forgets all.
  void clear() { count_ = 0; }

 private:
  std::vector<Snapshot> past_;  ///< A ring.
  std::size_t count_ = 0;       ///< Of all that were added.
};

/// So many ticks make up a delay.
[[nodiscard]] std::int64_t ticks_of(const Model& model, double delay_s);

}  // namespace thenar
