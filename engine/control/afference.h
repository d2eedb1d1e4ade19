// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Knowledge of one time: the state, and the desired forces of the fingers then.
struct Sensed {
  Snapshot snapshot;
  FingerForces desired_N;  ///< f^d of the control tick of that time.
};

/// The last snapshots, for delayed knowledge. Memory is allocated in the constructor.
class Afference {
 public:
  /// Makes room for the longest delay of the scene's control; without delay and touch it is not needed.
  explicit Afference(const Model& model);
  /// Continues another one, of a model that differs in its steps or fingertips.
  Afference(const Model& model, const Model& old, const Afference& before);

  [[nodiscard]] bool is_needed() const { return !past_.empty(); }
  /// Adds the next snapshot; replaces the last one if it is of the same tick.
  void add(const Snapshot& snapshot, const Eigen::VectorXd& desired_N);
  /// Sets the newest f^d, once it is found.
  void set_desired(const Eigen::VectorXd& desired_N);
  /// Returns the newest that is no newer than `tick`, or the oldest if there is none.
  [[nodiscard]] const Sensed& at(std::int64_t tick) const;

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(past_, count_);
  }

 private:
  std::vector<Sensed> past_;  ///< A ring buffer.
  std::size_t count_ = 0;     ///< Number of snapshots added.
};

/// Returns the number of ticks of a delay.
[[nodiscard]] std::int64_t ticks_of(const Model& model, double delay_s);

}  // namespace thenar
