// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/recorded_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>

#include "engine/formats/files.h"
#include "engine/formats/text.h"

namespace thenar {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t kMostNumbers = 100'000;  // Of all fields: no scene of ours has as many.

// Numbers kept for each number of the states read, beside the first: a state of a scene without the first one's fields
// is a row of NaN.
constexpr std::size_t kMostKept = 16, kAlwaysKept = 1'000'000;

struct BadName : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws BadName, with the name, unless all are printable and differ: they name columns and files.
void expect_names(const std::vector<std::string>& names) {
  std::set<std::string_view> seen;
  for (const std::string& name : names) {
    if (name.empty() || first_unprintable(name) != std::string::npos || !seen.insert(name).second) throw BadName(name);
    // A spreadsheet would take the head of such a column for a formula.
    if (std::string_view("=+-@").find(name.front()) != std::string_view::npos) throw BadName(name);
  }
}

/// As expect_names(); and they are words: letters, digits and '_'.
void expect_words(const std::vector<Field>& fields) {
  std::vector<std::string> names;
  for (const Field& field : fields) names.push_back(field.name);
  expect_names(names);
  for (const Field& field : fields) {
    const bool is_word =
        std::ranges::all_of(field.name, [](unsigned char c) { return c == '_' || (c < 0x80 && std::isalnum(c) != 0); });
    if (!is_word) throw BadName(field.name);
    if (first_unprintable(field.unit) != std::string::npos) throw BadName(field.unit);
  }
}

/// The fields of a scene: each begins where the one before it ends. Throws out_of_range if they are none, and BadName.
std::vector<Field> fields_in(const ordered_json& list) {
  std::vector<Field> fields;
  std::size_t end = 0;
  for (const ordered_json& field : list) {
    for (const char* key : {"begin", "count"}) {
      if (!field.at(key).is_number_unsigned()) throw std::out_of_range("fields");
    }
    fields.push_back({field.at("name"), field.at("unit"), field.at("begin"), field.at("count")});
    if (fields.back().begin != end || fields.back().count > kMostNumbers - end || fields.size() > kMostNumbers) {
      throw std::out_of_range("fields");
    }
    end += fields.back().count;
  }
  expect_words(fields);
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
    if (scene.value("version", 1.0) < 3.0 && scene.contains("object_stiffness")) {
      const auto forces = std::ranges::find(source_, "muscles_N", &Field::name);
      if (forces != source_.end()) forces->name = kUnstretched;
    }
    rows_ = fields_in(scene.value("contact_fields", ordered_json::array()));
    if (!has_scene_) begin(scene);
    find_sources();
  }

  /// The first scene says which fields there are.
  void begin(const ordered_json& scene) {
    has_scene_ = true;
    run.name = scene.value("name", "");
    run.names = signal_names(scene);
    for (const auto& names : {run.names.fingers, run.names.joints, run.names.muscles, run.names.bodies}) {
      expect_names(names);
    }
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
    expect_words(run.contact_fields);
  }

  /// Finds the fields of the rows in the states that follow.
  void find_sources() {
    std::map<std::string_view, const Field*> by_name;
    for (const Field& field : source_) by_name.emplace(field.name, &field);
    parts_.clear();
    for (const Field& field : run.fields) {
      const auto from = by_name.find(field.name);
      const bool same = from != by_name.end() && from->second->count == field.count;
      if (field.count > 0) parts_.push_back({same ? std::optional(from->second->begin) : std::nullopt, field.count});
    }
    const auto time = by_name.find("time_s");
    time_.reset();
    if (time != by_name.end() && time->second->count > 0) time_ = time->second->begin;
    fixed_ = width(source_);
  }

  void see_state(const std::vector<double>& numbers) {
    const std::size_t row = width(rows_);
    if (!has_scene_ || numbers.size() < fixed_) throw std::out_of_range("state");
    read_ += numbers.size() + 1;
    if (run.numbers.size() + width(run.fields) > kAlwaysKept + kMostKept * read_) throw std::out_of_range("states");
    for (const auto& [begin, count] : parts_) {
      if (begin) {
        const auto from = numbers.begin() + static_cast<std::ptrdiff_t>(*begin);
        run.numbers.insert(run.numbers.end(), from, from + static_cast<std::ptrdiff_t>(count));
      } else {
        run.numbers.insert(run.numbers.end(), count, std::numeric_limits<double>::quiet_NaN());
      }
    }
    if (run.contact_fields.empty() || row == 0 || row + 1 != width(run.contact_fields)) return;
    for (std::size_t at = fixed_; at + row <= numbers.size(); at += row) {
      run.contact_numbers.push_back(time_ ? numbers[*time_] : 0.0);
      run.contact_numbers.insert(run.contact_numbers.end(), numbers.begin() + static_cast<std::ptrdiff_t>(at),
                                 numbers.begin() + static_cast<std::ptrdiff_t>(at + row));
    }
  }

  const WantedOfRun& wanted_;
  bool has_scene_ = false;
  std::vector<Field> source_, rows_;  ///< As the messages have them now.

  /// The numbers of a field: where they are in a state; nowhere: they are unknown.
  struct Part {
    std::optional<std::size_t> begin;
    std::size_t count;
  };
  std::vector<Part> parts_;
  std::optional<std::size_t> time_;
  std::size_t fixed_ = 0;  ///< Numbers of a state before its contacts.
  std::size_t read_ = 0;   ///< Numbers of all states.
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
} catch (const BadName& name) {
  throw FileError(file, fmt::format("names a part '{}', which is no name, or is there twice", name.what()));
} catch (const std::bad_alloc&) {
  throw FileError(file, "does not fit into memory");
}

}  // namespace thenar
