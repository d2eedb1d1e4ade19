#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "engine/grasp/contact_tick.h"
#include "engine/grasp/control_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/results/monolithic.h"
#include "engine/results/problem_dump.h"
#include "engine/results/recording.h"

namespace thenar {

/// What happens to frames on their way from the control loop to the contact loop, beside the scene's control delay.
struct LockstepSettings {
  double jitter_s = 0.0;   ///< Each frame takes up to so much longer, uniformly at random.
  std::uint64_t seed = 1;  ///< Of the jitter.
  /// How much later than the scene expects does the frame of a snapshot at this time come. Nothing: it is in time.
  std::function<double(double time_s)> late_s = {};
  /// Sees each frame at the time of its snapshot and may change it; false: it is lost. Nothing: it passes.
  std::function<bool(double time_s, Frame& frame)> channel = {};
};

/// The two loops on a virtual clock and one thread: what the threads do, without their chance. A control tick at every
/// control period sees the state of its time, and its frame comes into use a control delay (and jitter) later; a frame
/// that is overtaken is dropped. Frame 0 is there before the first tick. The same inputs give the same bits.
class Lockstep {
 public:
  Lockstep(const Model& model, LockstepSettings settings = {});

  /// One contact tick, after a control tick if one is due.
  TickReport tick(const TickInput& input = {});

  State state;
  /// Of the last control tick.
  [[nodiscard]] const ControlReport& control() const { return control_; }
  [[nodiscard]] const Controller& controller() const { return controller_; }
  /// Whether a control tick ran just before the last contact tick.
  [[nodiscard]] bool controlled() const { return controlled_; }
  [[nodiscard]] const Frame& frame() const { return frame_; }
  [[nodiscard]] ContactWorkspace& workspace() { return work_; }

 private:
  struct Sent {
    double due_s;
    Frame frame;
  };
  void run_control(double now_s);
  void receive(double now_s);

  const Model& model_;
  LockstepSettings settings_;
  std::mt19937_64 random_;
  Controller controller_;
  ControlReport control_;
  bool controlled_ = false;
  std::vector<Sent> under_way_;
  Frame frame_;  // in use
  ContactWorkspace work_;
};

/// Runs a scene by Lockstep, as run_monolithic does in one loop.
[[nodiscard]] Recording run_lockstep(const Model& model, State& state, const LockstepSettings& settings = {},
                                     const Progress& progress = {}, ProblemDump* dump = nullptr,
                                     RecordingFile* film = nullptr);

}  // namespace thenar
