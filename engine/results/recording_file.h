#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "collision/triangle_mesh.h"
#include "engine/formats/mcap_file.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/picture.h"
#include "engine/results/recording.h"
#include "engine/results/state_message.h"

namespace thenar {

/// So many states are kept of a second of a run.
inline constexpr double kRecordingRate_Hz = 50.0;

/// What a run looks like, in an MCAP file that a window replays: docs/reference/window.md. What the disk refuses ends
/// the file, not the run: the beginning and finish() throw FileError.
class RecordingFile {
 public:
  /// Begins with the scene and its points.
  RecordingFile(const std::filesystem::path& file, const Model& model);

  /// Whether the state after this tick is to be kept: the first one of each 1 / kRecordingRate_Hz of simulated time.
  [[nodiscard]] bool is_due(std::int64_t tick) const;

  /// The state that a tick left, if it is due.
  void add(const State& state, const ContactWorkspace& work, const TickRecord& tick,
           const Eigen::VectorXd& muscle_forces_N);
  /// The same of a picture that is taken already.
  void add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N);
  /// A state message as it was shown.
  void add(double time_s, const std::string& state_message);
  /// The scene and its points once more: they have changed.
  void add_scene(const Model& model, double time_s);
  void add_status(double time_s, const nlohmann::ordered_json& status);
  /// Ends the file, and says what became of the grasp.
  void finish(const Recording& run);
  void finish() { file_.finish(); }

  /// As it shows the object.
  [[nodiscard]] const TriangleMesh& surface() const { return surface_; }

 private:
  const Model& model_;
  TriangleMesh surface_;
  McapWriter file_;
  Picture picture_;
  std::string bytes_;
  std::vector<Field> fields_;
};

/// The short fields of every state in a recording as comma-separated values: a header with units, a row a state. Throws
/// FileError if the file is no recording.
[[nodiscard]] std::string recording_csv(const std::filesystem::path& file);

}  // namespace thenar
