// SPDX-License-Identifier: Apache-2.0
#include "engine/sweeps/sweep.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/grasp/state.h"
#include "engine/results/scene_run.h"
#include "engine/results/summary.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "engine/studies/load_model.h"

namespace thenar {

namespace {

constexpr std::size_t kMostRows = 1'000'000;
/// Digits of a value between two bounds: 0.3 of 0.1:0.5:5, and not 0.30000000000000004.
constexpr int kDigits = 12;

[[noreturn]] void refuse(const std::string& text, const std::string& what) {
  throw ConfigError({{"--vary " + text, "", what}});
}

/// Splits at separators outside brackets and quotes, and trims blanks.
std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts(1);
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else {
      depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    }
    if (c == separator && depth == 0 && quote == 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  for (std::string& part : parts) {
    part.erase(0, part.find_first_not_of(' '));
    part.erase(part.find_last_not_of(' ') + 1);
  }
  return parts;
}

/// A finite number and the unit after it, if any.
struct NumberWithUnit {
  double number = 0.0;
  std::string unit;
};

std::optional<NumberWithUnit> read_number(std::string_view text) {
  double number = 0.0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  // `1e`, `3-5` and the like are words.
  const bool is_unit = text.empty() || std::isalpha(static_cast<unsigned char>(text.front())) != 0 || text == "%" ||
                       text.starts_with("1/");
  if (!is_unit) return std::nullopt;
  return NumberWithUnit{number, std::string(text)};
}

/// Returns the values of a:b:n or a:b:n:log.
std::vector<std::string> read_range(const std::string& text, const std::vector<std::string>& parts) {
  const bool logarithmic = parts.size() == 4 && parts[3] == "log";
  if (parts.size() != 3 && !logarithmic) refuse(text, "write a range as from:to:count or from:to:count:log");
  const auto from = read_number(parts[0]), to = read_number(parts[1]);
  if (!from || !to) refuse(text, "the bounds of a range are numbers with their unit, such as 0.1 mm:2 mm:5");
  if (from->unit != to->unit) refuse(text, "both bounds must carry the same unit");
  const std::size_t count = number_in<std::size_t>(parts[2]).value_or(0);
  if (count < 2 || count > kMostRows) {
    refuse(text, fmt::format("'{}' must be how many values: a whole number within 2 .. {}", parts[2], kMostRows));
  }
  const double a = from->number, b = to->number;
  if (logarithmic && a * b <= 0.0) refuse(text, "equal ratios need bounds of one sign, and none that is zero");
  std::vector<std::string> values;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(count - 1);
    const double value = logarithmic ? a * std::pow(b / a, s) : a + (b - a) * s;
    values.push_back(fmt::format("{:.{}g}{}{}", value, kDigits, from->unit.empty() ? "" : " ", from->unit));
  }
  values.front() = parts[0];
  values.back() = parts[1];
  return values;
}

/// Describes the error of a row's scene in one line, without its source.
std::string reason(const ConfigError& error) {
  std::string text;
  for (const ConfigDiagnostic& fault : error.diagnostics()) {
    if (!text.empty()) text += "; ";
    text += fault.key.empty() ? fault.message : fault.key + ": " + fault.message;
  }
  return text;
}

/// Returns the result of one row; or the reason why there is none, as `failure`. `known` is the thread's last model, of
/// which parts may serve again, and becomes this one's; none is left where the row is refused.
std::optional<SweepRow> run_one(const SweepPlan& plan, std::size_t row, const RunScene& run,
                                std::optional<Model>& known, std::string& failure) {
  const auto refused = [](const std::string& why) {
    return SweepRow{{Outcome::kRefused, why}, nlohmann::ordered_json::object()};
  };
  const auto no_memory = [&] {
    failure = "not enough memory: fewer --jobs leave more to each";
    known.reset();
    return std::nullopt;
  };
  try {
    Scene scene = load_scene(plan.scene, plan.changes(row));
    std::optional<Model> last = std::exchange(known, std::nullopt);
    known = last ? load_model(std::move(scene), *std::move(last)) : load_model(std::move(scene));
    return run(*known);
  } catch (const ConfigError& error) {
    return refused(reason(error));
  } catch (const ReadError& error) {
    failure = error.what();
    return std::nullopt;
  } catch (const FileError& error) {  // Such as a cloud that is no surface.
    return refused(error.what());
  } catch (const std::bad_alloc&) {
    return no_memory();
  } catch (const std::length_error&) {  // More than any memory has.
    return no_memory();
  }
}

/// Returns the unit that all values share; empty if there is none.
std::string common_unit(const Variation& variation) {
  const auto first = read_number(variation.values.front());
  const bool shared = first && std::ranges::all_of(variation.values, [&](const std::string& value) {
                        const auto number = read_number(value);
                        return number && number->unit == first->unit;
                      });
  return shared ? first->unit : "";
}

/// Formats a measure as a cell: none is text.
std::string csv_cell(const SweepRow& row, const std::string& name) {
  const auto value = row.measures.find(name);
  return value == row.measures.end() || value->is_null() ? "" : value->dump();
}

}  // namespace

Variation read_variation(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    refuse(text, "write it as key=from:to:count or key=value,value, such as contact.friction=0.4:1:7");
  }
  const std::string values = text.substr(equals + 1);
  Variation variation{text.substr(0, equals), {}};
  const std::vector<std::string> parts = split(values, ':');
  variation.values = parts.size() > 1 ? read_range(text, parts) : split(values, ',');
  if (std::ranges::any_of(variation.values, &std::string::empty)) refuse(text, "a value is missing");
  return variation;
}

std::size_t SweepPlan::rows() const {
  std::size_t rows = 1;
  for (const Variation& variation : vary) rows *= variation.values.size();
  return rows;
}

std::vector<std::string> SweepPlan::values(std::size_t row) const {
  std::vector<std::string> values(vary.size());
  for (std::size_t i = vary.size(); i-- > 0;) {
    values[i] = vary[i].values[row % vary[i].values.size()];
    row /= vary[i].values.size();
  }
  return values;
}

std::vector<std::string> SweepPlan::changes(std::size_t row) const {
  std::vector<std::string> changes = overrides;
  const std::vector<std::string> row_values = values(row);
  for (std::size_t i = 0; i < vary.size(); ++i) changes.push_back(vary[i].key + "=" + row_values[i]);
  return changes;
}

std::vector<std::filesystem::path> files_of(const SweepPlan& plan) {
  std::vector<std::filesystem::path> files = scene_files(plan.scene, plan.changes(0));
  for (const Variation& variation : plan.vary) {
    // A key names files if it is one of these two or a map around it.
    const auto is_around = [&](const std::string& key) { return key.starts_with(variation.key); };
    if (!is_around("hand.model") && !is_around("object.shape.cloud.file")) continue;
    for (const std::string& value : variation.values) {
      std::vector<std::string> changes = plan.changes(0);
      changes.push_back(variation.key + "=" + value);
      const std::vector<std::filesystem::path> more = scene_files(plan.scene, changes);
      files.insert(files.end(), more.begin(), more.end());
    }
  }
  std::vector<std::filesystem::path> once;
  for (const std::filesystem::path& file : files) {
    if (std::ranges::find(once, file) == once.end()) once.push_back(file);
  }
  return once;
}

void keep_files(const SweepPlan& plan) {
  // First the scene, which names the others.
  KeptFiles::keep(plan.scene);
  for (const std::filesystem::path& file : files_of(plan)) KeptFiles::keep(file);
}

Scene first_scene(const SweepPlan& plan) {
  std::size_t rows = 1;
  for (auto variation = plan.vary.begin(); variation != plan.vary.end(); ++variation) {
    if (std::find_if(plan.vary.begin(), variation, [&](const auto& v) { return v.key == variation->key; }) !=
        variation) {
      refuse(variation->key, "this key varies twice");
    }
    rows *= variation->values.size();
    if (rows > kMostRows) refuse(variation->key, fmt::format("makes more than {} rows", kMostRows));
  }
  std::optional<ConfigError> first;
  for (std::size_t row = 0; row < rows; ++row) {
    try {
      return load_scene(plan.scene, plan.changes(row));
    } catch (const ConfigError& error) {
      if (!first) first = error;
    }
  }
  std::vector<ConfigDiagnostic> faults = first->diagnostics();
  for (ConfigDiagnostic& fault : faults) {
    const auto is_its = [&](const Variation& variation) { return fault.location == "--set " + variation.key; };
    if (std::ranges::any_of(plan.vary, is_its)) fault.location.replace(0, 5, "--vary");
  }
  throw ConfigError(faults);
}

SweepRow sweep_row(const Model& model, const Recording& recording) {
  const RunView view = view_of(model, recording);
  SweepRow row{recording.verdict, nlohmann::ordered_json::object(),
               fmt::format("{}", fmt::join(model.scene.left_out, "; "))};
  for (const RunMeasure* const measure : sweep_measures()) {
    // Slides have ends of their own.
    const MeasureValue value = measure->is_in(view) ? measure->value(view) : MeasureValue();
    const auto* const number = std::get_if<double>(&value);
    row.measures[measure->column_name()] = number != nullptr && !std::isfinite(*number) ? nullptr : to_json(value);
  }
  return row;
}

SweepRow run_row(const Model& model) {
  State state(model);
  return sweep_row(model, run_scene(model, state, {.shows = false}));
}

void run_sweep(const SweepPlan& plan, const std::vector<std::size_t>& rows, int jobs, const RunScene& run,
               const SweepListener& listener) {
  // oneTBB would hold back jobs beyond the cores.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  tbb::enumerable_thread_specific<std::optional<Model>> known;
  std::mutex telling;
  arena.execute([&] {
    // Halves of the list go to threads, so that rows of one thread are neighbours and share an object's surface.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, rows.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            std::string failure;
            std::optional<SweepRow> result = run_one(plan, rows[i], run, known.local(), failure);
            const std::lock_guard lock(telling);
            if (result) {
              listener.done(rows[i], *std::move(result));
            } else {
              listener.failed(rows[i], failure);
            }
          }
        },
        tbb::simple_partitioner());
  });
}

void write_rows_csv(const SweepPlan& plan, const std::function<std::optional<SweepRow>(std::size_t row)>& row_of,
                    const std::function<void(std::string_view)>& write) {
  constexpr std::size_t kPart = 1 << 20;  // bytes
  std::vector<std::string> names;
  for (const RunMeasure* const measure : sweep_measures()) names.push_back(measure->column_name());
  std::vector<std::string> units;
  std::string csv;
  for (const Variation& variation : plan.vary) {
    units.push_back(common_unit(variation));
    csv += csv_cell(variation.key + (units.back().empty() ? "" : " [" + units.back() + "]")) + ',';
  }
  csv += fmt::format("outcome,reason,left_out,{}\n", fmt::join(names, ","));
  for (std::size_t index = 0; index < plan.rows(); ++index) {
    const std::optional<SweepRow> row = row_of(index);
    if (!row) continue;
    const std::vector<std::string> values = plan.values(index);
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::string value = values[i];
      // The unit is in the header; from the end, for the value may be 1/N or hold blanks.
      if (!units[i].empty()) value.erase(value.find_last_not_of(' ', value.size() - units[i].size() - 1) + 1);
      csv += csv_cell(value) + ',';
    }
    csv +=
        csv_cell(to_string(row->verdict.outcome)) + ',' + csv_cell(row->verdict.reason) + ',' + csv_cell(row->left_out);
    for (const std::string& measure : names) csv += ',' + csv_cell(*row, measure);
    csv += '\n';
    if (csv.size() < kPart) continue;
    write(csv);
    csv.clear();
  }
  write(csv);
}

}  // namespace thenar
