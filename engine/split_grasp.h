#pragma once

#include <cstdint>

#include "engine/contact_tick.h"
#include "engine/control_tick.h"
#include "engine/latest_value.h"
#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// What one contact step returns by value.
struct ContactStep {
  TickReport tick;
  std::int64_t acquire_ns = 0;  ///< Looking for a new frame, and taking it. One reading of the clock is included,
  std::int64_t publish_ns = 0;  ///< here too: copying the snapshot, and making it the newest one.
};

/// What one control step returns by value.
struct ControlStep {
  ControlReport control;
  std::int64_t sequence = 0;       ///< Of the frame that it published.
  std::int64_t snapshot_tick = 0;  ///< Of the snapshot that it used.
  bool published = false;          ///< False if the frame was not finite: the last one stays in use.
};

/// A grasp run by two threads of the caller's: one calls contact_step at 1 kHz or faster, another control_step at the
/// scene's control period. They exchange frames and snapshots through buffers that cannot block; neither ever waits
/// for the other. The model's step is the period of the first, its control period that of the second.
///
/// The constructor takes all memory and makes frame 0, control included, so that the first contact step has a drive. It
/// throws std::runtime_error if that frame is not finite. The model is referred to, not copied.
class SplitGrasp {
 public:
  explicit SplitGrasp(const Model& model) : SplitGrasp(model, State(model)) {}
  SplitGrasp(const Model& model, const State& start);

  /// Advances the state by one step, on the newest frame. For one thread. It does not allocate, lock, log, throw or call
  /// the system; an input that is not finite is left out, and the report says so.
  ContactStep contact_step(const TickInput& input = {}) noexcept;

  /// One control tick on the newest snapshot, and its frame published. For one other thread. A frame that is not finite
  /// is kept back.
  ControlStep control_step();
  /// Of the last control step [N]; empty without muscles. For the thread that makes them.
  [[nodiscard]] const Eigen::VectorXd& muscle_forces_N() const { return controller_.f_muscle; }

  /// Of the contact thread; other threads may read it when contact steps have ended.
  [[nodiscard]] const State& state() const { return state_; }
  /// What the control tick of frame 0 found.
  [[nodiscard]] const ControlReport& first_control() const { return first_control_; }
  [[nodiscard]] const LatestValue<Frame>& frames() const { return frames_; }
  [[nodiscard]] const LatestValue<Snapshot>& snapshots() const { return snapshots_; }

 private:
  const Model& model_;
  State state_;
  ContactWorkspace work_;
  Controller controller_;
  ControlReport first_control_;
  LatestValue<Frame> frames_;
  LatestValue<Snapshot> snapshots_;
};

}  // namespace thenar
