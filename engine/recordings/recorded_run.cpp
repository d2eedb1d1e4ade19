#include "engine/recordings/recorded_run.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "engine/formats/files.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t kMostNumbers = 100'000;  // Of all fields: no scene of ours has as many.

/// Throws out_of_range if they are none.
std::vector<Field> fields_in(const ordered_json& list) {
  std::vector<Field> fields;
  std::size_t numbers = 0;
  for (const ordered_json& field : list) {
    for (const char* key : {"begin", "count"}) {
      if (!field.at(key).is_number_unsigned()) throw std::out_of_range("fields");
    }
    fields.push_back({field.at("name"), field.at("unit"), field.at("begin"), field.at("count")});
    // Of all fields together: a table has a column for each number.
    if (fields.back().begin > kMostNumbers || fields.back().count > kMostNumbers - numbers) {
      throw std::out_of_range("fields");
    }
    numbers += fields.back().count;
  }
  return fields;
}

std::size_t width(const std::vector<Field>& fields) {
  std::size_t end = 0;
  for (const Field& field : fields) end = std::max(end, field.begin + field.count);
  return end;
}

/// Puts the messages of a recording together.
class RunReader {
 public:
  explicit RunReader(const WantedOfRun& wanted) : wanted_(wanted) {}

  void see(const McapMessage& message) {
    if (message.topic == "/scene") see_scene(ordered_json::parse(message.bytes));
    if (message.topic == "/state") see_state(read_state_message(message.bytes));
    if (message.topic == "/contacts" && wanted_.contacts) {
      ContactBlock block = read_contact_block(message.bytes);
      if (block.ticks == 0) throw std::out_of_range("contacts");
      run.contact_blocks.push_back(std::move(block));
    }
  }

  [[nodiscard]] bool has_scene() const { return has_scene_; }

  RecordedRun run;

 private:
  void see_scene(const ordered_json& scene) {
    source_ = fields_in(scene.at("fields"));
    // Before version 3 the forces of muscles with stiffness, whose scenes have this member, lacked what stretch adds.
    if (scene.value("version", 1) < 3 && scene.contains("object_stiffness")) {
      const auto forces = std::ranges::find(source_, "muscles_N", &Field::name);
      if (forces != source_.end()) forces->name = kUnstretched;
    }
    rows_ = fields_in(scene.value("contact_fields", ordered_json::array()));
    if (has_scene_) return;
    has_scene_ = true;
    run.name = scene.value("name", "");
    run.names = signal_names(scene);
    for (Field field : source_) {
      run.recorded.push_back(field.name);
      if (wanted_.field && !wanted_.field(field)) continue;
      field.begin = width(run.fields);
      run.fields.push_back(field);
    }
    if (!wanted_.contacts || rows_.empty()) return;
    run.contact_fields = {{"time_s", "s", 0, 1}};
    for (Field field : rows_) {
      field.begin += 1;
      run.contact_fields.push_back(field);
    }
  }

  void see_state(const std::vector<double>& numbers) {
    const std::size_t fixed = width(source_), row = width(rows_);
    if (!has_scene_ || numbers.size() < fixed) throw std::out_of_range("state");
    for (const Field& field : run.fields) {
      const auto from = std::ranges::find(source_, field.name, &Field::name);
      const bool same = from != source_.end() && from->count == field.count;
      for (std::size_t i = 0; i < field.count; ++i) {
        run.numbers.push_back(same ? numbers[from->begin + i] : std::numeric_limits<double>::quiet_NaN());
      }
    }
    if (run.contact_fields.empty() || row == 0 || row + 1 != width(run.contact_fields)) return;
    const auto time = std::ranges::find(source_, "time_s", &Field::name);
    for (std::size_t at = fixed; at + row <= numbers.size(); at += row) {
      run.contact_numbers.push_back(time != source_.end() ? numbers[time->begin] : 0.0);
      run.contact_numbers.insert(run.contact_numbers.end(), numbers.begin() + static_cast<std::ptrdiff_t>(at),
                                 numbers.begin() + static_cast<std::ptrdiff_t>(at + row));
    }
  }

  const WantedOfRun& wanted_;
  bool has_scene_ = false;
  std::vector<Field> source_, rows_;  ///< As the messages have them now.
};

}  // namespace

Eigen::Map<const RowMatrix> RecordedRun::rows(const std::vector<double>& numbers, const std::vector<Field>& fields) {
  const auto columns = static_cast<Eigen::Index>(width(fields));
  return {numbers.data(), columns == 0 ? 0 : static_cast<Eigen::Index>(numbers.size()) / columns, columns};
}

RowMatrix RecordedRun::field(const std::string& of) const {
  const auto found = std::ranges::find(fields, of, &Field::name);
  if (found == fields.end()) return RowMatrix(states().rows(), 0);
  return columns_of(states(), *found);
}

RowMatrix columns_of(const Eigen::Map<const RowMatrix>& rows, const Field& field) {
  const auto count = static_cast<Eigen::Index>(field.count);
  if (rows.rows() == 0) return RowMatrix(0, count);  // There may be no memory either, of which Eigen would take a part.
  return rows.middleCols(static_cast<Eigen::Index>(field.begin), count);
}

RecordedRun read_recording(const std::filesystem::path& file, const WantedOfRun& wanted) try {
  RunReader reader(wanted);
  const McapReading reading = read_mcap(file, [&](const McapMessage& message) { reader.see(message); });
  if (!reader.has_scene()) throw FileError(file, "holds no scene");
  reader.run.reading = reading;
  return std::move(reader.run);
} catch (const nlohmann::json::exception&) {
  throw FileError(file, "has a scene that cannot be read");
} catch (const std::out_of_range&) {
  throw FileError(file, "has states of another version");
}

}  // namespace thenar
