#include "engine/results/recording_file.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/results/shown_surface.h"
#include "engine/results/signal_columns.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t kMostNumbers = 100'000;  // Of all fields: no scene of ours has as many.

// In the order of the channels.
enum Channel : std::size_t { kScene, kGeometry, kState, kSignals, kStatus };

/// What the raw messages hold, in words.
std::string state_schema(const std::vector<Field>& fields) {
  std::string text = "THNR, version and kind (2) as uint16, then float64, little-endian:\n";
  const auto add = [&text](const Field& field) {
    text += fmt::format("{} [{}] at {}, {} numbers\n", field.name, field.unit.empty() ? "1" : field.unit, field.begin,
                        field.count);
  };
  for (const Field& field : fields) add(field);
  text += "then a row for each contact:\n";
  for (const Field& field : contact_fields()) add(field);
  return text;
}

std::string signals_schema(const std::vector<SignalColumn>& columns) {
  ordered_json properties = ordered_json::object();
  for (const SignalColumn& column : columns) {
    properties[column.name] = {{"type", "number"}, {"description", column.unit}};
  }
  return ordered_json{{"type", "object"}, {"properties", properties}}.dump();
}

std::vector<McapChannel> channels(const Model& model) {
  const std::vector<Field> fields = state_fields(model);
  const std::string any = R"({"type":"object"})";
  return {
      {"/scene", "json", "thenar.Scene", "jsonschema", any},
      {"/geometry", "thenar", "thenar.Geometry", "text",
       "THNR, version and kind (1) as uint16, then float32, little-endian: points and normals as /scene counts them"},
      {"/state", "thenar", "thenar.State", "text", state_schema(fields)},
      {"/signals", "json", "thenar.Signals", "jsonschema", signals_schema(signal_columns(fields, signal_names(model)))},
      {"/status", "json", "thenar.Status", "jsonschema", any}};
}

ordered_json signals(const std::vector<SignalColumn>& columns, const std::vector<double>& numbers) {
  ordered_json json = ordered_json::object();
  for (const SignalColumn& column : columns) json[column.name] = column.factor * numbers[column.at];
  return json;
}

std::vector<Field> fields_of(const ordered_json& scene) {
  std::vector<Field> fields;
  std::size_t numbers = 0;
  for (const ordered_json& field : scene.at("fields")) {
    for (const char* key : {"begin", "count"}) {
      if (!field.at(key).is_number_unsigned()) throw std::out_of_range("fields");
    }
    fields.push_back({field.at("name"), field.at("unit"), field.at("begin"), field.at("count")});
    // Of all fields together: a header has a column for each number.
    if (fields.back().count > kMostNumbers - numbers) throw std::out_of_range("fields");
    numbers += fields.back().count;
  }
  return fields;
}

std::string csv_header(const std::vector<SignalColumn>& columns) {
  std::string line;
  for (const SignalColumn& column : columns) line += (line.empty() ? "" : ",") + csv_cell(column.name);
  return line + "\n";
}

std::string csv_row(const std::vector<SignalColumn>& columns, const std::vector<double>& numbers) {
  std::string line;
  for (const SignalColumn& column : columns) {
    // The fewest digits that read back the same.
    line += fmt::format("{}{}", line.empty() ? "" : ",", column.factor * numbers.at(column.at));
  }
  return line + "\n";
}

}  // namespace

RecordingFile::RecordingFile(const std::filesystem::path& file, const Model& model)
    : model_(model), surface_(shown_surface(model)), file_(file, channels(model)), picture_(model) {
  add_scene(model, 0.0);
}

void RecordingFile::add_scene(const Model& model, double time_s) {
  fields_ = state_fields(model);
  file_.add(kScene, time_s, scene_message(model, false, surface_).dump());
  file_.add(kGeometry, time_s, geometry_message(model, surface_));
}

bool RecordingFile::is_due(std::int64_t tick) const {
  // A period that ends at a tick's end, but for rounding, ends there.
  const auto periods = [&](std::int64_t t) {
    return std::floor(static_cast<double>(t) * model_.scene.step_s * kRecordingRate_Hz + 1e-6);
  };
  return periods(tick) > periods(tick - 1);
}

void RecordingFile::add(const State& state, const ContactWorkspace& work, const TickRecord& tick,
                        const Eigen::VectorXd& muscle_forces_N) {
  if (!is_due(state.tick)) return;
  take_picture(state, work, picture_);
  add(picture_, tick, muscle_forces_N);
}

void RecordingFile::add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N) {
  write_state_message(model_, picture, tick, muscle_forces_N, {}, bytes_);
  add(tick.time_s, bytes_);
}

void RecordingFile::add(double time_s, const std::string& state_message) {
  file_.add(kState, time_s, state_message);
  const std::vector<SignalColumn> columns = signal_columns(fields_, signal_names(model_));
  file_.add(kSignals, time_s, signals(columns, read_state_message(state_message)).dump());
}

void RecordingFile::add_status(double time_s, const ordered_json& status) { file_.add(kStatus, time_s, status.dump()); }

void RecordingFile::finish(const Recording& run) {
  const double end_s = run.ticks.empty() ? 0.0 : run.ticks.back().time_s;
  add_status(end_s, {{"type", "status"}, {"outcome", to_string(run.verdict.outcome)}, {"reason", run.verdict.reason}});
  finish();
}

std::string recording_csv(const std::filesystem::path& file) try {
  std::string csv;
  std::vector<SignalColumn> columns;
  for (const McapMessage& message : read_mcap(file).messages) {
    if (message.topic == "/scene") {
      const bool first = columns.empty();
      const ordered_json scene = ordered_json::parse(message.bytes);
      columns = signal_columns(fields_of(scene), signal_names(scene));
      if (first) csv = csv_header(columns);
    }
    if (message.topic == "/state") csv += csv_row(columns, read_state_message(message.bytes));
  }
  if (columns.empty()) throw FileError(file, "holds no scene");
  return csv;
} catch (const nlohmann::json::exception&) {
  throw FileError(file, "has a scene that cannot be read");
} catch (const std::out_of_range&) {
  throw FileError(file, "has states of another version");
}

}  // namespace thenar
