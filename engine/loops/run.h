// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/picture.h"

namespace thenar {

/// Disturbances of frames between control loop and contact loop, besides the scene's control delay.
struct LockstepSettings {
  double jitter_s = 0.0;   ///< Largest extra delay of each frame, uniformly random.
  std::uint64_t seed = 1;  ///< Seed of the jitter.
  /// Extra delay of the frame of a snapshot at this time; empty: none.
  std::function<double(double time_s)> late_s = {};
  /// A function that may change each frame, at the time of its snapshot; false: it is lost. Empty: frames pass.
  std::function<bool(double time_s, Frame& frame)> channel = {};
};

/// A frame in transit from the control loop to the contact loop.
struct SentFrame {
  explicit SentFrame(const Model& model, double sent_s = 0.0) : due_s(sent_s), frame(model) {}

  double due_s;
  Frame frame;
};

/// The state of a run of a model between two ticks: all data to continue it. A copy continues as the original, bit for
/// bit, on the same model, with the same delays and jitter.
struct Run {
  explicit Run(const Model& model, const FramePolicy& policy = {}, std::uint64_t seed = 0)
      : state(model), memory(model, policy), frame(model), controller(model), random(seed) {}

  State state;
  ContactMemory memory;
  Frame frame;  ///< The frame in use.
  Controller controller;
  ControlReport report;     ///< Result of the last control tick.
  bool controlled = false;  ///< True if it ran just before the last contact tick.
  // In lockstep:
  std::mt19937_64 random;  ///< Source of the jitter.
  std::vector<SentFrame> under_way;
};

/// A run of a scene on one thread, tick by tick: a control tick every control period, and a contact tick every step.
/// The same inputs give the same bits.
///
/// In one loop, as in the paper, a frame is used as soon as it is made. In lockstep the two loops imitate threads on a
/// virtual clock, deterministically: a control tick sees the state of its time, and its frame is used a control delay
/// (and jitter) later; one that is overtaken is dropped. Frame 0 exists before the first tick.
struct GraspRun : Run {
  /// Makes a run in one loop. It keeps a reference to the model.
  explicit GraspRun(const Model& m) : GraspRun(m, {}, std::nullopt) {}
  /// Makes a run in lockstep.
  GraspRun(const Model& m, LockstepSettings settings) : GraspRun(m, split_policy(m.scene), std::move(settings)) {}
  GraspRun(const GraspRun&) = delete;
  GraspRun& operator=(const GraspRun&) = delete;

  /// Continues from the state of another run of the same model, delays and jitter.
  void go_on_as(const Run& other) { static_cast<Run&>(*this) = other; }

  /// Runs one control tick, if one is due, and then one contact tick.
  TickReport tick(const TickInput& input = {});
  /// Runs the first half of tick(): `controlled` tells whether a control tick was due.
  void control_if_due();
  /// Runs the second half of tick().
  TickReport contact(const TickInput& input = {});
  /// Runs a control tick on the present state.
  void control();

  [[nodiscard]] bool is_lockstep() const { return lockstep_.has_value(); }
  [[nodiscard]] double time_s() const { return static_cast<double>(state.tick) * model.scene.step_s; }

  const Model& model;
  ContactScratch work;

 private:
  GraspRun(const Model& m, const FramePolicy& policy, std::optional<LockstepSettings> settings);
  void send();
  void receive();

  std::optional<LockstepSettings> lockstep_;
};

/// A completed control tick.
struct ControlTick {
  double time_s;  ///< Time of its snapshot.
  const ControlReport& report;
  const Eigen::VectorXd& muscle_forces_N;  ///< Forces asked for. Invalid in a scene without muscles.
  const GraspRun* run = nullptr;           ///< The run at the snapshot; null with several threads.
};

/// A completed contact tick, as shown by every runner.
struct Tick {
  const Snapshot& after;  ///< State after it.
  const TickReport& contact;
  const ControlReport& control;            ///< Result of the last control tick; with several threads, of the frame's.
  const Eigen::VectorXd& muscle_forces_N;  ///< Forces that that control tick asked for; Snapshot::pull_N act.
  bool controlled = false;                 ///< True if that control tick ran just before it, or its frame is new.
  double display_s = 0.0;                  ///< Time to show the deformed fingertips: 60 times a second, else 0.
  const GraspRun* run = nullptr;           ///< The run; null with several threads.
  const Picture* picture = nullptr;        ///< Picture of it, if one was taken.
};

/// An observer of a run's ticks, in order. Each function returns true if the run is to continue.
class Watcher {
 public:
  virtual ~Watcher() = default;
  virtual bool see_control(const ControlTick&) { return true; }
  virtual bool see_tick(const Tick& tick) = 0;
};

/// Runs this number of contact ticks, or until a watcher ends it; a control tick at which a watcher ends it is the
/// last. With `shows`, in one loop, the deformed fingertips are computed at every sample 60 times a second, as for a
/// viewer.
void run_ticks(GraspRun& run, std::int64_t ticks, std::span<Watcher* const> watchers, bool shows = true);

}  // namespace thenar
