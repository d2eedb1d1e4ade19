// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/grasp/contact_tick.h"
#include "engine/loops/picture.h"
#include "engine/loops/run.h"
#include "engine/results/grasp_monitor.h"
#include "engine/results/recorder.h"
#include "engine/results/recording.h"
#include "python/interpreter.h"
#include "python/scene.h"

namespace thenar::python {

namespace py = pybind11;

/// A run in one loop or in lockstep, stepped from outside, with the measures of `thenar run` so far.
class Simulation : public Constructed {
 public:
  Simulation(std::shared_ptr<const SceneHandle> scene, std::shared_ptr<const Model> model,
             std::optional<LockstepSettings> lockstep, OwnControl own);
  /// Makes a copy that goes on as the other would.
  Simulation(const Simulation& other);
  Simulation& operator=(const Simulation&) = delete;

  /// Runs one tick as run_ticks() and Recorder do, but keeps nothing.
  void tick();
  /// Runs `count` ticks, or until `stop` is true, asked before each, or, with `to_loss`, the object is lost.
  template <typename Stop>
  void ticks(std::int64_t count, bool to_loss, Stop&& stop) {
    for (std::int64_t i = 0; i < count && !(to_loss && monitor.has_ended()) && !stop(); ++i) tick();
  }

  /// Return and restore all of it but the laws: see engine/loops/run_state.h.
  [[nodiscard]] std::string state() const;
  void set_state(std::string_view bytes);

  [[nodiscard]] const Picture& picture();
  /// Writes a recording of this instant alone. Throws FileError.
  void record_now(const std::filesystem::path& file);

  std::shared_ptr<const SceneHandle> scene;
  std::shared_ptr<const Model> model;
  std::optional<LockstepSettings> lockstep;
  GraspRun run;
  TickInput input;
  TickRecord record;  ///< Record of the last tick.
  RunSums sums;
  GraspMonitor monitor;
  bool closed = false;
  std::atomic<bool> busy{false};

 private:
  template <typename Archive>
  void members(Archive& a) {
    a(static_cast<Run&>(run), input, record, sums, monitor, picture_);
  }
  void read(std::string_view members);
  /// Returns the hash of the model and each value of its scene, which a state and its reader must share.
  [[nodiscard]] std::uint64_t fingerprint() const;
  /// Returns the picture that picture() would show; arrays of it that a caller holds stay as they are.
  [[nodiscard]] Picture picture_now() const;

  Picture picture_;
};

/// A simulation that this thread alone may touch, while it lives. Raises if it is closed, or another thread has it.
class Hold {
 public:
  explicit Hold(Simulation& simulation);
  ~Hold() { simulation_.busy.store(false, std::memory_order_release); }
  Hold(const Hold&) = delete;
  Hold& operator=(const Hold&) = delete;

 private:
  Simulation& simulation_;
};

/// Reads the settings from True, False, or a dict of jitter_s and seed.
[[nodiscard]] std::optional<LockstepSettings> lockstep_of(const py::object& lockstep);

void bind_simulation(py::module_& module);

}  // namespace thenar::python
