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

/// What happens to frames on their way from the control loop to the contact loop, beside the scene's control delay.
struct LockstepSettings {
  double jitter_s = 0.0;   ///< Each frame takes up to so much longer, uniformly at random.
  std::uint64_t seed = 1;  ///< Of the jitter.
  /// How much later than the scene expects does the frame of a snapshot at this time come. Nothing: it is in time.
  std::function<double(double time_s)> late_s = {};
  /// Sees each frame at the time of its snapshot and may change it; false: it is lost. Nothing: it passes.
  std::function<bool(double time_s, Frame& frame)> channel = {};
};

/// A frame on its way from the control loop to the contact loop.
struct SentFrame {
  explicit SentFrame(const Model& model, double sent_s = 0.0) : due_s(sent_s), frame(model) {}

  double due_s;
  Frame frame;
};

/// A run of a model as it stands between two ticks: all that it needs to go on. A copy goes on as the original would,
/// bit for bit, on the same model, with the same delays and jitter.
struct Run {
  explicit Run(const Model& model, const FramePolicy& policy = {}, std::uint64_t seed = 0)
      : state(model), memory(model, policy), frame(model), controller(model), random(seed) {}

  State state;
  ContactMemory memory;
  Frame frame;  ///< In use.
  Controller controller;
  ControlReport report;     ///< Of the last control tick.
  bool controlled = false;  ///< It ran just before the last contact tick.
  // In lockstep:
  std::mt19937_64 random;  ///< Of the jitter.
  std::vector<SentFrame> under_way;
};

/// A scene's ticks on one thread, called one by one: a control tick every control period, and a contact tick every
/// step. The same inputs give the same bits.
///
/// In one loop, as the paper has it, a frame is in use as soon as it is made. In lockstep the two loops do on a virtual
/// clock what threads do, without their chance: a control tick sees the state of its time, and its frame comes into use
/// a control delay (and jitter) later; one that is overtaken is dropped. Frame 0 is there before the first tick.
struct GraspRun : Run {
  /// In one loop. The model is referred to.
  explicit GraspRun(const Model& m) : GraspRun(m, {}, std::nullopt) {}
  /// In lockstep.
  GraspRun(const Model& m, LockstepSettings settings) : GraspRun(m, split_policy(m.scene), std::move(settings)) {}
  GraspRun(const GraspRun&) = delete;
  GraspRun& operator=(const GraspRun&) = delete;

  /// Goes on as another of the same model, delays and jitter would.
  void go_on_as(const Run& other) { static_cast<Run&>(*this) = other; }

  /// One control tick, if one is due, and then one contact tick.
  TickReport tick(const TickInput& input = {});
  /// The first half of it: `controlled` says whether one was due.
  void control_if_due();
  /// The second.
  TickReport contact(const TickInput& input = {});
  /// A control tick on the state as it is.
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

/// A control tick that has been done.
struct ControlTick {
  double time_s;  ///< Of its snapshot.
  const ControlReport& report;
  const Eigen::VectorXd& muscle_forces_N;  ///< Not to be read in a scene without muscles.
  const GraspRun* run = nullptr;           ///< At the snapshot; null where other threads run.
};

/// A contact tick that has been done, as every runner shows it.
struct Tick {
  const Snapshot& after;  ///< The state that it left.
  const TickReport& contact;
  const ControlReport& control;            ///< Result of the last control tick; with several threads, of the frame's.
  const Eigen::VectorXd& muscle_forces_N;  ///< Forces of that control tick.
  bool controlled = false;                 ///< True if that control tick ran just before it, or its frame is new.
  double display_s = 0.0;                  ///< Time to show the deformed fingertips: 60 times a second, else 0.
  const GraspRun* run = nullptr;           ///< The run; null with several threads.
  const Picture* picture = nullptr;        ///< Picture of it, if one was taken.
};

/// Sees the ticks of a run, in order. Each returns whether the run is to go on.
class Watcher {
 public:
  virtual ~Watcher() = default;
  virtual bool see_control(const ControlTick&) { return true; }
  virtual bool see_tick(const Tick& tick) = 0;
};

/// So many contact ticks, or until a watcher ends it; a control tick that a watcher ends it after is the last. In one
/// loop the deformed fingertips are shown at every sample 60 times a second, as a viewer would need them; without
/// `shows` they are not.
void run_ticks(GraspRun& run, std::int64_t ticks, std::span<Watcher* const> watchers, bool shows = true);

}  // namespace thenar
