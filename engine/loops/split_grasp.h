// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/latest_value.h"

namespace thenar {

/// Result of one contact step.
struct ContactStep {
  TickReport tick;
  std::int64_t acquire_ns = 0;  ///< Time to check for a new frame, and to take it. One clock reading is included.
  std::int64_t publish_ns = 0;  ///< Time to copy the snapshot and publish it, likewise.
};

/// Result of one control step.
struct ControlStep {
  ControlReport control;
  std::int64_t sequence = 0;       ///< Number of the frame that it made.
  std::int64_t snapshot_tick = 0;  ///< Tick of the snapshot that it used.
  bool published = false;          ///< False if the frame was not finite, and so is never used.
};

/// A grasp run by two threads of the caller's: one calls contact_step at 1 kHz or faster, another control_step at the
/// scene's control period. They exchange frames and snapshots through buffers that cannot block; neither ever waits
/// for the other. The model's step is the period of the first, its control period that of the second.
///
/// The constructor allocates all memory and makes frame 0, control included, so that the first contact step has a
/// drive. It throws std::runtime_error if that frame is not finite. It keeps a reference to the model. The functions of
/// `own` are called by the constructor and by control_step().
class SplitGrasp {
 public:
  explicit SplitGrasp(const Model& model) : SplitGrasp(model, State(model)) {}
  SplitGrasp(const Model& model, const State& start, const OwnControl& own = {});
  /// Continues another one, on a model that may have other fingertips and another step than `old`, the other's: with
  /// its state (carry_over), its controller's memory, and a new frame. Requires that neither loop runs.
  SplitGrasp(const Model& model, const Model& old, const SplitGrasp& before);

  /// Advances the state by one step, on the newest frame. For one thread. It does not allocate, lock, log, throw or
  /// call the system; an input that is not finite is ignored and reported.
  ContactStep contact_step(const TickInput& input = {}) noexcept;

  /// Runs one control tick on the newest snapshot, and publishes its frame. For one other thread. A frame that is not
  /// finite is withheld.
  ControlStep control_step();
  /// Returns those of the last control step [N]; empty without muscles. For the thread of control_step().
  [[nodiscard]] const Eigen::VectorXd& muscle_forces_N() const { return controller_.f_muscle; }

  // While neither loop runs:
  /// Applies changes of the model's scene: friction, internal force, tolerance, sweeps, control period and delay.
  void heed_scene() noexcept;
  /// Delays the use of frames by so many control steps, 0: none. The scene's control delay should agree, as drive and
  /// contact finding depend on it.
  void hold_frames_back(int periods);

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const Controller& controller() const { return controller_; }
  /// Return the workspaces, of the contact thread like the state.
  [[nodiscard]] const ContactMemory& memory() const { return memory_; }
  [[nodiscard]] const ContactScratch& scratch() const { return scratch_; }

  /// Returns the state, of the contact thread; other threads may read it when contact steps have ended.
  [[nodiscard]] const State& state() const { return state_; }
  /// Returns the result of the control tick of frame 0.
  [[nodiscard]] const ControlReport& first_control() const { return first_control_; }
  [[nodiscard]] const LatestValue<Frame>& frames() const { return frames_; }
  [[nodiscard]] const LatestValue<ContactSnapshot>& snapshots() const { return snapshots_; }

 private:
  const Model& model_;
  State state_;
  ContactMemory memory_;
  ContactScratch scratch_;
  Controller controller_;
  ControlReport first_control_;
  LatestValue<Frame> frames_;
  LatestValue<ContactSnapshot> snapshots_;
  std::vector<Frame> held_back_;    ///< A ring; sequence -1: none.
  std::size_t next_held_back_ = 0;  ///< The oldest.
};

}  // namespace thenar
