// SPDX-License-Identifier: Apache-2.0
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

/// Default and least number of kept states per simulated second.
inline constexpr double kRecordingRate_Hz = 50.0;
inline constexpr double kLeastRecordingRate_Hz = 0.1;
inline constexpr double kShownRate_Hz = 50.0;  ///< Largest rate of the 3-D view.

/// Settings of what a recording keeps of a run.
struct RecordingSettings {
  double rate_Hz = kRecordingRate_Hz;    ///< States per simulated second, at most the contact rate.
  std::vector<std::string> fields = {};  ///< Names of the kept state fields; none: all.
  bool contacts = false;                 ///< Forces and slips of all contacts in every tick, too.
};

/// Returns the number of contact ticks from one kept state to the next.
[[nodiscard]] std::int64_t ticks_per_state(const Model& model, const RecordingSettings& settings);

/// Returns the fault of field names, in a sentence that lists the known ones; empty: none.
[[nodiscard]] std::string unknown_field(const Model& model, const std::vector<std::string>& fields);

/// MCAP recording of a run, which a window replays and other viewers show: docs/reference/recordings.md. Watches the
/// run, or gets its states one by one. A write error ends the file, not the run: the constructor and finish() throw
/// FileError.
class RecordingFile : public Watcher {
 public:
  /// Begins the file with the scene and its points. The settings' fields are known ones.
  RecordingFile(const std::filesystem::path& file, const Model& model, const RecordingSettings& settings = {});
  /// Likewise at `begin_s` of a run, with the object's shown_surface() as it was made before.
  RecordingFile(const std::filesystem::path& file, const Model& model, const RecordingSettings& settings,
                TriangleMesh surface, double begin_s);

  [[nodiscard]] const RecordingSettings& settings() const { return settings_; }
  /// Returns true if the state after this tick is to be kept.
  [[nodiscard]] bool is_due(std::int64_t tick) const { return tick % every_ == 0; }

  /// Adds the tick if it is of a run on one thread, or has a picture. Never ends the run.
  bool see_tick(const Tick& tick) override;
  /// Adds a tick's contacts, and the state if it is due, on the thread that did the tick.
  void add(const State& state, const ContactMemory& memory, const ContactScratch& work, const TickRecord& tick,
           const Eigen::VectorXd& muscle_forces_N);
  /// Adds a state from a picture that is taken already.
  void add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N,
           const LoopFigures& loops = {});
  /// Takes the contacts that a contact thread has left of its ticks. Call it often, to make room for more.
  void take_contacts(FilmTap& tap);
  /// Adds the scene and its points again after a change.
  void add_scene(const Model& model, double time_s);
  void add_status(double time_s, const nlohmann::ordered_json& status);
  /// Sets the totals of states and contact ticks that were lost on the way for want of room.
  void miss(std::int64_t states, std::int64_t contact_ticks);
  /// Returns true if the disk has failed: what follows is lost.
  [[nodiscard]] bool has_failed() const { return file_.has_failed(); }
  /// Returns what was missed, in words; empty: nothing.
  [[nodiscard]] std::string missing() const;
  /// Ends the file, and says what became of the grasp.
  void finish(const Recording& run);
  void finish(const Verdict& verdict, double end_s);
  void finish();

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
  std::vector<Field> all_fields_, fields_;  ///< Fields of a whole state, and of its kept part.
  TriangleMesh surface_;                    ///< Surface of the object, constant.
  McapWriter file_;
  RunSums sums_;  ///< Sums of the ticks seen as a watcher.
  Picture picture_;
  TickContacts contacts_;
  std::string bytes_, kept_;
  ContactBlock block_;
  std::int64_t block_tick_ = 0, block_sequence_ = 0;  ///< The block's last tick.
  std::optional<double> shown_s_;
  double last_s_ = 0.0;
  std::string last_outcome_, last_note_;
  std::size_t last_warnings_ = 0;
  std::int64_t missed_states_ = 0, missed_contacts_ = 0;
};

}  // namespace thenar
