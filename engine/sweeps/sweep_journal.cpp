// SPDX-License-Identifier: Apache-2.0
#include "engine/sweeps/sweep_journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/formats/checksum.h"
#include "engine/formats/files.h"
#include "engine/formats/open_file.h"
#include "engine/results/summary.h"
#include "engine/scenes/config.h"

namespace thenar {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

constexpr const char* kRunsAlready = "this sweep is running already";

/// Tests whether another process holds the lock; never on a file system without locks.
bool is_held(int descriptor) { return flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

/// Returns a plan in the form of its file.
std::string plan_text(const ordered_json& plan) {
  return plan.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::uint32_t checksum(const ordered_json& plan) { return crc32(plan_text(plan)); }

/// Returns the identity of a file by its name and contents.
ordered_json fingerprint(const fs::path& file) {
  const std::string bytes = read_file(file);
  return {{"file", file.filename().string()}, {"bytes", bytes.size()}, {"crc32", crc32(bytes)}};
}

/// Returns the part in which two plans differ.
std::string difference(const ordered_json& one, const ordered_json& other) {
  for (const auto& [key, value] : one.items()) {
    if (!other.is_object() || other.value(key, ordered_json()) != value) return key;
  }
  return "contents";
}

/// A line is {"row":3,"plan":<checksum>,"crc32":<checksum of what follows>,"outcome":...}. So where rows stand is known
/// without reading what they are, and a line that was cut or damaged shows.
constexpr std::string_view kRow = R"({"row":)", kChecksum = R"(,"crc32":)";

/// What follows the number of a row of this plan.
std::string plan_part(const ordered_json& plan) { return fmt::format(R"(,"plan":{})", checksum(plan)); }

std::string to_line(std::size_t row, const std::string& plan, const SweepRow& result) {
  const ordered_json json{{"outcome", to_string(result.verdict.outcome)},
                          {"reason", result.verdict.reason},
                          {"left_out", result.left_out},
                          {"measures", result.measures}};
  std::string rest = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  rest.front() = ',';
  return fmt::format("{}{}{}{}{}{}\n", kRow, row, plan, kChecksum, crc32(rest), rest);
}

/// Takes a prefix, or a number, from a text. False if it does not begin with it.
bool take(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}
bool take(std::string_view& text, std::size_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

/// Returns the row of a line; nothing if it is truncated or another plan's.
std::optional<std::size_t> row_of(std::string_view line, const std::string& plan) {
  std::size_t row = 0, sum = 0;
  const bool is_whole = take(line, kRow) && take(line, row) && take(line, plan) && take(line, kChecksum) &&
                        take(line, sum) && crc32(line) == sum;
  return is_whole ? std::optional(row) : std::nullopt;
}

std::optional<SweepRow> read_line(const std::string& text) try {
  const ordered_json line = ordered_json::parse(text);
  const auto* const outcome =
      std::ranges::find_if(kOutcomes, [&](Outcome o) { return line.at("outcome") == to_string(o); });
  if (outcome == kOutcomes.end()) return std::nullopt;
  SweepRow row;
  row.verdict.outcome = *outcome;
  row.verdict.reason = line.at("reason").get<std::string>();
  row.measures = line.at("measures");
  row.left_out = line.at("left_out").get<std::string>();
  return row;
} catch (const ordered_json::exception&) {
  return std::nullopt;
}

std::vector<fs::path> journals(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (file.extension() == ".jsonl" && file.filename().string().starts_with("journal-")) files.push_back(file);
  }
  return files;
}

[[noreturn]] void refuse(const fs::path& folder, const std::string& what) {
  throw ConfigError({{folder.string(), "", what}});
}

/// Refuses a folder with another plan.
void check_plan(const fs::path& folder, const std::string& text, const ordered_json& plan) {
  if (text == plan_text(plan)) return;
  const ordered_json there = ordered_json::parse(text, nullptr, false);
  refuse(folder,
         fmt::format("this folder holds another sweep, with another '{}' in plan.json: name another folder with "
                     "--out",
                     difference(plan, there)));
}

}  // namespace

ordered_json plan_json(const SweepPlan& plan, const std::string& runner) {
  ordered_json vary = ordered_json::object(), files = ordered_json::array();
  for (const Variation& variation : plan.vary) vary[variation.key] = variation.values;
  for (const fs::path& file : files_of(plan)) files.push_back(fingerprint(file));
  return {{"scene", plan.scene.filename().string()},
          {"vary", vary},
          {"set", plan.overrides},
          {"runner", runner},
          {"files", files},
          {"build", build_settings()}};
}

FileLock claim_sweep_folder(const fs::path& folder, const ordered_json& plan) {
  prepare_folder(folder);
  const fs::path file = folder / "plan.json";
  // In this order: rows have a plan from the beginning.
  const bool has_rows = fs::exists(folder / "rows.csv") || !journals(folder).empty();
  if (has_rows && !fs::exists(file)) refuse(folder, "this folder holds other rows: name another folder with --out");
  std::optional<FileLock> lock = FileLock::take(file);
  if (!lock) refuse(folder, kRunsAlready);
  const std::string text = read_file(file), wanted = plan_text(plan);
  // A process that is killed while it writes this leaves a part of it, or nothing.
  if (!has_rows && wanted.starts_with(text) && text != wanted) {
    lock->write(wanted);
  } else {
    check_plan(folder, text, plan);
  }
  return *std::move(lock);
}

FinishedRows::FinishedRows(const fs::path& folder, const SweepPlan& plan, const ordered_json& json)
    : places_(plan.rows()) {
  const std::string its = plan_part(json);
  for (const fs::path& file : journals(folder)) {
    files_.push_back(file);
    if (!read_journal(static_cast<std::uint32_t>(files_.size() - 1), its)) {
      throw ReadError(file, "cannot be read: " + std::generic_category().message(errno));
    }
  }
}

bool FinishedRows::read_journal(std::uint32_t file, const std::string& plan) {
  std::string text;         // From the beginning of a line on,
  std::uint64_t begin = 0;  // which is here in the file.
  std::vector<char> part(1 << 20);
  const OpenFile journal(files_[file], O_RDONLY | O_NONBLOCK);
  if (journal.descriptor < 0) return false;
  for (ssize_t size = 0; (size = ::read(journal.descriptor, part.data(), part.size())) != 0;) {
    if (size < 0) return false;
    text.append(part.data(), static_cast<std::size_t>(size));
    std::size_t from = 0;
    for (std::size_t end = 0; (end = text.find('\n', from)) != std::string::npos; from = end + 1) {
      const auto row = row_of(std::string_view(text).substr(from, end - from), plan);
      if (!row || *row >= places_.size() || contains(*row)) continue;
      places_[*row] = {file, static_cast<std::uint32_t>(end - from), begin + from};
      ++count_;
    }
    text.erase(0, from);
    begin += from;
  }
  return true;
}

std::optional<SweepRow> FinishedRows::read(std::size_t row) const {
  const Place& at = places_[row];
  if (at.bytes == 0) return std::nullopt;
  std::string text(at.bytes, ' ');
  const OpenFile journal(files_[at.file], O_RDONLY | O_NONBLOCK);
  const ssize_t size = pread(journal.descriptor, text.data(), text.size(), static_cast<off_t>(at.begin));
  return size == static_cast<ssize_t>(text.size()) ? read_line(text) : std::nullopt;
}

SweepJournal::SweepJournal(const fs::path& folder, int rank, ordered_json plan)
    : folder_(folder),
      file_(folder / fmt::format("journal-{}.jsonl", rank)),
      plan_(std::move(plan)),
      line_begin_(plan_part(plan_)) {
  // The plan of the process that claimed the folder, which may have read other files.
  check_plan(folder, read_file(folder / "plan.json"), plan_);
  descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw FileError(file_, "cannot be written");
  if (is_held(descriptor_)) {
    close(descriptor_);
    refuse(folder, kRunsAlready);
  }
  // A partial line of a killed process becomes a line of its own.
  const off_t size = lseek(descriptor_, 0, SEEK_END);
  char last = '\n';
  const bool is_read = size == 0 || (size > 0 && pread(descriptor_, &last, 1, size - 1) == 1);
  if (!is_read || (last != '\n' && write(descriptor_, "\n", 1) != 1)) {
    throw FileError(file_, "cannot be written");
  }
}

SweepJournal::~SweepJournal() {
  if (descriptor_ >= 0) close(descriptor_);
}

void SweepJournal::add(std::size_t row, const SweepRow& result) {
  const std::string line = to_line(row, line_begin_, result);
  // In one piece: whoever ends this process, now or later, finds the line whole or torn at its end.
  if (write(descriptor_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    throw FileError(file_, "could not be written in full");
  }
}

std::optional<SweepJournal::Outcomes> SweepJournal::finish(const SweepPlan& plan) {
  // One process at a time: the last one reads what all others wrote.
  const OpenFile turn(folder_ / "plan.json", O_RDWR);
  if (turn.descriptor >= 0) flock(turn.descriptor, LOCK_EX);
  close(std::exchange(descriptor_, -1));
  for (const fs::path& file : journals(folder_)) {
    if (is_held(OpenFile(file, O_RDWR).descriptor)) return std::nullopt;
  }
  const FinishedRows rows(folder_, plan, plan_);
  Outcomes outcomes;
  const auto counted = [&](std::size_t index) {
    std::optional<SweepRow> row = rows.read(index);
    if (row) ++outcomes[row->verdict.outcome];
    return row;
  };
  write_file(folder_ / "rows.csv", [&](const auto& write) { write_rows_csv(plan, counted, write); });
  return outcomes;
}

}  // namespace thenar
