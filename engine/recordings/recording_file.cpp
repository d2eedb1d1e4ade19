// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/recording_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "engine/formats/foxglove.h"
#include "engine/formats/text.h"
#include "engine/recordings/recording_scene.h"
#include "engine/recordings/shown_surface.h"
#include "engine/recordings/signal_columns.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

constexpr std::uint32_t kMostBlockTicks = 256;
constexpr std::size_t kStateHead = 8;  // Bytes before a state's numbers.

/// The fields that are kept, in their order, one behind the other. Time and tick always are.
std::vector<Field> kept_fields(const std::vector<Field>& all, const std::vector<std::string>& names) {
  if (names.empty()) return all;
  std::vector<Field> kept;
  std::size_t begin = 0;
  for (Field field : all) {
    const bool always = field.name == "time_s" || field.name == "tick";
    if (!always && std::ranges::find(names, field.name) == names.end()) continue;
    field.begin = begin;
    begin += field.count;
    kept.push_back(field);
  }
  return kept;
}

/// As a recording begins with it: with the fields that it keeps.
ordered_json recorded_scene(const Model& model, const std::vector<Field>& fields, const TriangleMesh& surface) {
  ordered_json scene = scene_message(model, false, surface);
  ordered_json listed = ordered_json::array();
  for (const Field& field : fields) {
    listed.push_back({{"name", field.name}, {"unit", field.unit}, {"begin", field.begin}, {"count", field.count}});
  }
  scene["fields"] = listed;
  return without_unknowns(scene);
}

std::vector<McapChannel> channels_of(const Model& model, const std::vector<Field>& fields) {
  return recording_channels(recorded_scene(model, fields, {}), fields, signal_columns(fields, signal_names(model)));
}

ordered_json signals(const std::vector<SignalColumn>& columns, const std::vector<double>& numbers) {
  ordered_json json = ordered_json::object();
  for (const SignalColumn& column : columns) {
    const double number = column.factor * numbers[column.at];
    if (std::isfinite(number)) json[column.name] = number;
  }
  return json;
}

}  // namespace

std::int64_t ticks_per_state(const Model& model, const RecordingSettings& settings) {
  return std::max<std::int64_t>(1, std::llround(1.0 / (settings.rate_Hz * model.scene.step_s)));
}

std::string unknown_field(const Model& model, const std::vector<std::string>& fields) {
  const std::vector<Field> all = state_fields(model);
  std::vector<std::string_view> names;
  for (const Field& field : all) names.push_back(field.name);
  for (const std::string& name : fields) {
    if (std::ranges::find(names, name) != names.end()) continue;
    return fmt::format("a state has no field '{}'{} It has {}", printable(name),
                       did_you_mean(nearest_word(name, names)).empty() ? "." : did_you_mean(nearest_word(name, names)),
                       join(names, ", "));
  }
  return {};
}

RecordingFile::RecordingFile(const std::filesystem::path& file, const Model& model, const RecordingSettings& settings)
    : RecordingFile(file, model, settings, shown_surface(model), 0.0) {}

RecordingFile::RecordingFile(const std::filesystem::path& file, const Model& model, const RecordingSettings& settings,
                             TriangleMesh surface, double begin_s)
    : model_(model),
      settings_(settings),
      every_(ticks_per_state(model, settings)),
      all_fields_(state_fields(model)),
      fields_(kept_fields(all_fields_, settings.fields)),
      surface_(std::move(surface)),
      file_(file, channels_of(model, fields_)),
      picture_(model),
      contacts_(model) {
  add_scene(model, begin_s);
}

void RecordingFile::add_scene(const Model& model, double time_s) {
  end_block();
  every_ = ticks_per_state(model, settings_);
  all_fields_ = state_fields(model);
  fields_ = kept_fields(all_fields_, settings_.fields);
  contacts_ = TickContacts(model);
  put(RecordingTopic::kScene, time_s, recorded_scene(model, fields_, surface_).dump());
  put(RecordingTopic::kGeometry, time_s, geometry_message(model, surface_));
  put(RecordingTopic::kHand, time_s, hand_entities(model, time_s).dump());
  put(RecordingTopic::kObject, time_s, object_entities(model, time_s, surface_).dump());
  log(time_s, true, fmt::format("scene {}", model.scene.name));
  shown_s_.reset();
}

bool RecordingFile::see_tick(const Tick& tick) {
  const TickRecord record = tick_record(model_, tick, sums_);
  if (tick.picture != nullptr) add(*tick.picture, record, tick.muscle_forces_N);
  if (tick.run != nullptr) add(tick.run->state, tick.run->memory, tick.run->work, record, tick.muscle_forces_N);
  return true;
}

void RecordingFile::add(const State& state, const ContactMemory& memory, const ContactScratch& work,
                        const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N) {
  if (settings_.contacts) {
    thenar::take_contacts(state, memory, work, contacts_);
    add_contacts(contacts_);
  }
  if (!is_due(state.tick)) return;
  take_picture(state, memory, work, picture_);
  add(picture_, tick, muscle_forces_N);
}

void RecordingFile::add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N,
                        const LoopFigures& loops) {
  write_state_message(model_, picture, tick, muscle_forces_N, loops, bytes_);
  add_fields(tick.time_s);
  // Where the simulation was set back, it is shown at once.
  const bool due = !shown_s_ || tick.time_s < *shown_s_ || tick.time_s - *shown_s_ > 1.0 / kShownRate_Hz - 1e-9;
  if (due) show(picture, tick);
  last_s_ = tick.time_s;
}

/// The state and its signals, of the whole state in `bytes_`.
void RecordingFile::add_fields(double time_s) {
  if (settings_.fields.empty()) {
    put(RecordingTopic::kState, time_s, bytes_);
  } else {
    kept_.assign(bytes_, 0, kStateHead);
    std::size_t end = 0;
    for (const Field& field : all_fields_) {
      end = std::max(end, field.begin + field.count);
      if (std::ranges::find(fields_, field.name, &Field::name) == fields_.end()) continue;
      kept_.append(bytes_, kStateHead + sizeof(double) * field.begin, sizeof(double) * field.count);
    }
    // The contacts' rows stay where their number does.
    if (std::ranges::find(settings_.fields, "contacts") != settings_.fields.end()) {
      kept_.append(bytes_, kStateHead + sizeof(double) * end, std::string::npos);
    }
    put(RecordingTopic::kState, time_s, kept_);
  }
  const std::vector<SignalColumn> columns = signal_columns(fields_, signal_names(model_));
  const std::string& message = settings_.fields.empty() ? bytes_ : kept_;
  put(RecordingTopic::kSignals, time_s, signals(columns, read_state_message(message)).dump());
}

void RecordingFile::show(const Picture& picture, const TickRecord& tick) {
  const double time_s = tick.time_s;
  shown_s_ = time_s;
  put(RecordingTopic::kFrames, time_s, frame_transforms(model_, picture, tick.X_WT, time_s).dump());
  put(RecordingTopic::kForces, time_s, force_entities(model_, picture, time_s).dump());
  put(RecordingTopic::kPressures, time_s, pressure_entities(model_, picture, time_s).dump());
}

void RecordingFile::take_contacts(FilmTap& tap) {
  for (const TickContacts* tick; (tick = tap.contacts.front()) != nullptr; tap.contacts.pop()) add_contacts(*tick);
}

void RecordingFile::add_contacts(const TickContacts& tick) {
  const bool goes_on = block_.ticks > 0 && block_.ticks < kMostBlockTicks && tick.tick == block_tick_ + 1 &&
                       tick.sequence == block_sequence_ && tick.count == block_.contacts;
  if (!goes_on) {
    end_block();
    block_.step_s = model_.scene.step_s;
    block_.time_s = static_cast<double>(tick.tick) * block_.step_s;
    block_.contacts = static_cast<std::uint32_t>(tick.count);
  }
  block_.add({tick.contacts.data(), tick.count});
  block_tick_ = tick.tick;
  block_sequence_ = tick.sequence;
}

void RecordingFile::end_block() {
  if (block_.ticks > 0) put(RecordingTopic::kContacts, block_.time_s, contact_block_message(block_));
  block_.ticks = 0;
  block_.rows.clear();
}

void RecordingFile::add_status(double time_s, const ordered_json& status) {
  put(RecordingTopic::kStatus, time_s, without_unknowns(status).dump());
  const std::string outcome = status.value("outcome", ""), reason = status.value("reason", "");
  const std::string words = reason.empty() ? outcome : outcome + ": " + reason;
  if (words != last_outcome_)
    log(time_s, outcome == to_string(Outcome::kHeld) || outcome == to_string(Outcome::kTaskDone),
        "the grasp is " + words);
  last_outcome_ = words;
  const ordered_json warnings = status.value("warnings", ordered_json::array());
  for (std::size_t i = last_warnings_; i < warnings.size(); ++i) log(time_s, false, warnings[i]);
  last_warnings_ = warnings.size();
  const ordered_json note = status.value("note", ordered_json());
  if (note.is_string() && note != last_note_) log(time_s, true, note);
  last_note_ = note.is_string() ? note.get<std::string>() : "";
}

void RecordingFile::log(double time_s, bool fine, const std::string& text) {
  const foxglove::LogLevel level = fine ? foxglove::LogLevel::kInfo : foxglove::LogLevel::kWarning;
  put(RecordingTopic::kLog, time_s, foxglove::log(level, text, time_s).dump());
}

void RecordingFile::miss(std::int64_t states, std::int64_t contact_ticks) {
  missed_states_ = states;
  missed_contacts_ = contact_ticks;
}

std::string RecordingFile::missing() const {
  if (missed_states_ + missed_contacts_ == 0) return {};
  return fmt::format("the recording lacks {} and the contacts of {}, for which there was no time",
                     counted(missed_states_, "state"), counted(missed_contacts_, "tick"));
}

void RecordingFile::finish(const Recording& run) {
  finish(run.verdict, run.ticks.empty() ? 0.0 : run.ticks.back().time_s);
}

void RecordingFile::finish(const Verdict& verdict, double end_s) {
  add_status(end_s, {{"type", "status"}, {"outcome", to_string(verdict.outcome)}, {"reason", verdict.reason}});
  last_s_ = end_s;
  finish();
}

void RecordingFile::finish() {
  end_block();
  if (!missing().empty()) log(last_s_, false, missing());
  file_.finish();
}

}  // namespace thenar
