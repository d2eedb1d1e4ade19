#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// What is known of a time: the state, and what the fingers were to do then.
struct Sensed {
  Snapshot snapshot;
  FingerForces desired_N;  ///< f^d of that time's control tick.
};

/// The last snapshots, for what is known late. It takes its memory when it is made.
class Afference {
 public:
  /// For the longest delay that the scene's control names; without one, and without touch, it is not needed.
  explicit Afference(const Model& model);
  /// Goes on as another of a model that differs in its steps or fingertips.
  Afference(const Model& model, const Model& old, const Afference& before);

  [[nodiscard]] bool is_needed() const { return !past_.empty(); }
  /// The next one; in place of the last if it is of the same tick.
  void add(const Snapshot& snapshot, const Eigen::VectorXd& desired_N);
  /// What the fingers are to do, once that is found.
  void set_desired(const Eigen::VectorXd& desired_N);
  /// The newest that is no newer than `tick`, or where there is none, the oldest.
  [[nodiscard]] const Sensed& at(std::int64_t tick) const;

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(past_, count_);
  }

 private:
  std::vector<Sensed> past_;  ///< A ring.
  std::size_t count_ = 0;     ///< Of all that were added.
};

/// So many ticks make up a delay.
[[nodiscard]] std::int64_t ticks_of(const Model& model, double delay_s);

}  // namespace thenar
