#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "collision/triangle_mesh.h"
#include "engine/formats/contact_block.h"
#include "engine/formats/mcap_file.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/film_tap.h"
#include "engine/loops/picture.h"
#include "engine/loops/run.h"
#include "engine/recordings/recording_schemas.h"
#include "engine/recordings/state_message.h"
#include "engine/results/recorder.h"
#include "engine/results/recording.h"

namespace thenar {

/// So many states are kept of a second, unless others are asked for.
inline constexpr double kRecordingRate_Hz = 50.0;
inline constexpr double kLeastRecordingRate_Hz = 0.1;
inline constexpr double kShownRate_Hz = 50.0;  ///< At most so often is it shown in 3-D.

/// What is kept of a run.
struct RecordingSettings {
  double rate_Hz = kRecordingRate_Hz;    ///< States of a simulated second; as many as contact ticks at most.
  std::vector<std::string> fields = {};  ///< Of a state, by their names; none: all.
  bool contacts = false;                 ///< Forces and slips of all contacts in every tick, too.
};

/// Contact ticks from one kept state to the next.
[[nodiscard]] std::int64_t ticks_per_state(const Model& model, const RecordingSettings& settings);

/// What is wrong with the names of fields, in a sentence that lists those there are; empty: nothing.
[[nodiscard]] std::string unknown_field(const Model& model, const std::vector<std::string>& fields);

/// What a run looks like, in an MCAP file that a window replays and others show: docs/reference/recordings.md. It may
/// watch the run, or get its states one by one. What the disk refuses ends the file, not the run: the beginning and
/// finish() throw FileError.
class RecordingFile : public Watcher {
 public:
  /// Begins with the scene and its points. The settings' fields are known ones.
  RecordingFile(const std::filesystem::path& file, const Model& model, const RecordingSettings& settings = {});

  [[nodiscard]] const RecordingSettings& settings() const { return settings_; }
  /// Whether the state after this tick is to be kept.
  [[nodiscard]] bool is_due(std::int64_t tick) const { return tick % every_ == 0; }

  /// Adds the tick if it is of a run on one thread, or has a picture. Never ends the run.
  bool see_tick(const Tick& tick) override;
  /// What a tick left, on the thread that did it: its contacts, and the state if it is due.
  void add(const State& state, const ContactMemory& memory, const ContactScratch& work, const TickRecord& tick,
           const Eigen::VectorXd& muscle_forces_N);
  /// A state, of a picture that is taken already.
  void add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N,
           const LoopFigures& loops = {});
  /// All that a contact thread has left of its ticks' contacts. Call it often: it is what makes room for more.
  void take_contacts(FilmTap& tap);
  /// The scene and its points once more: they have changed.
  void add_scene(const Model& model, double time_s);
  void add_status(double time_s, const nlohmann::ordered_json& status);
  /// What had no room on its way here, in all.
  void miss(std::int64_t states, std::int64_t contact_ticks);
  /// In words; empty: nothing.
  [[nodiscard]] std::string missing() const;
  /// Ends the file, and says what became of the grasp.
  void finish(const Recording& run);
  void finish(const Verdict& verdict, double end_s);
  void finish();

  /// As it shows the object.
  [[nodiscard]] const TriangleMesh& surface() const { return surface_; }

 private:
  void add_contacts(const TickContacts& tick);
  void end_block();
  void add_fields(double time_s);
  void show(const Picture& picture, const TickRecord& tick);
  void log(double time_s, bool fine, const std::string& text);
  void put(RecordingTopic topic, double time_s, const std::string& bytes) {
    file_.add(static_cast<std::size_t>(topic), time_s, bytes);
  }

  const Model& model_;
  RecordingSettings settings_;
  std::int64_t every_;
  std::vector<Field> all_fields_, fields_;  ///< Of a whole state, and of what is kept of one.
  TriangleMesh surface_;                    ///< Of the object, which stays.
  McapWriter file_;
  RunSums sums_;  ///< Of the ticks that it has seen as a watcher.
  Picture picture_;
  TickContacts contacts_;
  std::string bytes_, kept_;
  ContactBlock block_;
  std::int64_t block_tick_ = 0, block_sequence_ = 0;  ///< Of its last tick.
  std::optional<double> shown_s_;
  double last_s_ = 0.0;
  std::string last_outcome_, last_note_;
  std::size_t last_warnings_ = 0;
  std::int64_t missed_states_ = 0, missed_contacts_ = 0;
};

}  // namespace thenar
