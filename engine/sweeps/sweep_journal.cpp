#include "engine/sweeps/sweep_journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <sstream>
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

ordered_json to_line(std::size_t row, const SweepRow& result, std::uint32_t plan) {
  return {{"row", row},
          {"plan", plan},
          {"outcome", to_string(result.verdict.outcome)},
          {"reason", result.verdict.reason},
          {"left_out", result.left_out},
          {"measures", result.measures}};
}

/// Reads a line; nothing if it is truncated or another plan's.
std::optional<std::pair<std::size_t, SweepRow>> read_line(const std::string& text, std::uint32_t plan) try {
  const ordered_json line = ordered_json::parse(text);
  if (line.at("plan") != plan || !line.at("row").is_number_unsigned()) return std::nullopt;
  const auto* const outcome =
      std::ranges::find_if(kOutcomes, [&](Outcome o) { return line.at("outcome") == to_string(o); });
  if (outcome == kOutcomes.end()) return std::nullopt;
  SweepRow row;
  row.verdict.outcome = *outcome;
  row.verdict.reason = line.at("reason").get<std::string>();
  row.measures = line.at("measures");
  row.left_out = line.at("left_out").get<std::string>();
  return std::pair(line.at("row").get<std::size_t>(), std::move(row));
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

std::map<std::size_t, SweepRow> read_journals(const fs::path& folder, const ordered_json& plan) {
  const std::uint32_t its = checksum(plan);
  std::map<std::size_t, SweepRow> rows;
  for (const fs::path& file : journals(folder)) {
    std::istringstream lines(read_file(file));
    for (std::string text; std::getline(lines, text);) {
      if (auto row = read_line(text, its)) rows.insert(std::move(*row));
    }
  }
  return rows;
}

SweepJournal::SweepJournal(const fs::path& folder, int rank, ordered_json plan)
    : folder_(folder), file_(folder / fmt::format("journal-{}.jsonl", rank)), plan_(std::move(plan)) {
  // The plan of the process that claimed the folder, which may have read other files.
  check_plan(folder, read_file(folder / "plan.json"), plan_);
  descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw FileError(file_, "cannot be written");
  if (is_held(descriptor_)) {
    close(descriptor_);
    refuse(folder, kRunsAlready);
  }
  // A partial line of a killed process becomes a line of its own.
  const std::string text = read_file(file_);
  if (!text.empty() && text.back() != '\n' && write(descriptor_, "\n", 1) != 1) {
    throw FileError(file_, "cannot be written");
  }
}

SweepJournal::~SweepJournal() {
  if (descriptor_ >= 0) close(descriptor_);
}

void SweepJournal::add(std::size_t row, const SweepRow& result) {
  const std::string line =
      to_line(row, result, checksum(plan_)).dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  // In one piece: whoever ends this process, now or later, finds the line whole or torn at its end.
  if (write(descriptor_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    throw FileError(file_, "could not be written in full");
  }
}

SweepJournal::Merged SweepJournal::finish(const SweepPlan& plan) {
  // One process at a time: the last one reads what all others wrote, and its rows.csv is the one that stays.
  const OpenFile turn(folder_ / "plan.json", O_RDWR);
  if (turn.descriptor >= 0) flock(turn.descriptor, LOCK_EX);
  close(std::exchange(descriptor_, -1));
  Merged merged{read_journals(folder_, plan_)};
  for (const fs::path& file : journals(folder_)) {
    const OpenFile journal(file, O_RDWR);
    if (is_held(journal.descriptor)) merged.last = false;
  }
  write_file(folder_ / "rows.csv", rows_csv(plan, merged.rows));
  return merged;
}

}  // namespace thenar
