#include "engine/sweep_journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <cerrno>
#include <optional>
#include <sstream>
#include <utility>

#include "engine/config.h"
#include "engine/files.h"
#include "engine/summary.h"

namespace thenar {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

/// An open file that closes, and lets go of its lock, with the scope.
struct OpenFile {
  int descriptor;
  OpenFile(const fs::path& file, int flags) : descriptor(open(file.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~OpenFile() {
    if (descriptor >= 0) close(descriptor);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
};

/// Whether somebody else holds the lock. A file system without locks knows of nobody.
bool is_held(int descriptor) { return flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

/// The files that a scene names: hand and cloud.
void add_files(const fs::path& scene, const std::vector<std::string>& changes, std::vector<fs::path>& files) {
  const Config config(scene, changes);
  const ConfigMap root = config.root();
  if (root.is_map("hand")) files.push_back(root.map("hand").path("model"));
  if (!root.is_map("object") || !root.map("object").is_map("shape")) return;
  const ConfigMap shape = root.map("object").map("shape");
  if (!shape.has("cloud")) return;
  files.push_back(shape.is_map("cloud") ? shape.map("cloud").path("file") : shape.path("cloud"));
}

/// The scene and all files that its rows name.
std::vector<fs::path> files_of(const SweepPlan& plan) {
  std::vector<fs::path> files{plan.scene};
  add_files(plan.scene, plan.changes(0), files);
  for (const Variation& variation : plan.vary) {
    if (!variation.key.starts_with("hand") && !variation.key.starts_with("object")) continue;
    for (const std::string& value : variation.values) {
      std::vector<std::string> changes = plan.changes(0);
      changes.push_back(variation.key + "=" + value);
      add_files(plan.scene, changes, files);
    }
  }
  std::vector<fs::path> once;
  for (const fs::path& file : files) {
    if (!file.empty() && std::ranges::find(once, file) == once.end()) once.push_back(file);
  }
  return once;
}

/// A file by its name and contents; one that cannot be read makes a refused row, not another sweep.
ordered_json fingerprint(const fs::path& file) try {
  const std::string bytes = read_file(file);
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return {{"file", file.filename().string()}, {"bytes", bytes.size()}, {"crc32", crc.checksum()}};
} catch (const FileError&) {
  return {{"file", file.filename().string()}, {"bytes", nullptr}, {"crc32", nullptr}};
}

/// The part in which two plans differ.
std::string difference(const ordered_json& one, const ordered_json& other) {
  for (const auto& [key, value] : one.items()) {
    if (!other.is_object() || other.value(key, ordered_json()) != value) return key;
  }
  return "contents";
}

ordered_json to_line(std::size_t row, const SweepRow& result) {
  return {{"row", row},
          {"outcome", name(result.verdict.outcome)},
          {"reason", result.verdict.reason},
          {"left_out", result.left_out},
          {"measures", result.measures}};
}

/// Nothing if the line is torn.
std::optional<std::pair<std::size_t, SweepRow>> read_line(const std::string& text) try {
  const ordered_json line = ordered_json::parse(text);
  const auto* const outcome = std::ranges::find_if(kOutcomes, [&](Outcome o) { return line.at("outcome") == name(o); });
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

void claim_sweep_folder(const fs::path& folder, const ordered_json& plan) {
  prepare_folder(folder);
  const fs::path file = folder / "plan.json";
  const auto refuse = [&](const std::string& what) {
    throw ConfigError({{folder.string(), "", what + ": name another folder with --out"}});
  };
  if (!fs::exists(file)) {
    if (fs::exists(folder / "rows.csv") || !journals(folder).empty()) refuse("this folder holds other rows");
    write_file(file, plan.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n");
    return;
  }
  const ordered_json there = ordered_json::parse(read_file(file), nullptr, false);
  if (there == plan) return;
  refuse(fmt::format("this folder holds another sweep, with another '{}' in plan.json", difference(plan, there)));
}

std::map<std::size_t, SweepRow> read_journals(const fs::path& folder) {
  std::map<std::size_t, SweepRow> rows;
  for (const fs::path& file : journals(folder)) {
    std::istringstream lines(read_file(file));
    for (std::string text; std::getline(lines, text);) {
      if (auto row = read_line(text)) rows.insert(std::move(*row));
    }
  }
  return rows;
}

SweepJournal::SweepJournal(const fs::path& folder, int rank)
    : folder_(folder), file_(folder / fmt::format("journal-{}.jsonl", rank)) {
  descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw FileError(file_, "cannot be written");
  if (is_held(descriptor_)) {
    close(descriptor_);
    throw ConfigError({{folder.string(), "", "this sweep is running already"}});
  }
  // What a killed process left of a line becomes a line of its own.
  const std::string text = read_file(file_);
  if (!text.empty() && text.back() != '\n' && write(descriptor_, "\n", 1) != 1) {
    throw FileError(file_, "cannot be written");
  }
}

SweepJournal::~SweepJournal() {
  if (descriptor_ >= 0) close(descriptor_);
}

void SweepJournal::add(std::size_t row, const SweepRow& result) {
  const std::string line = to_line(row, result).dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
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
  Merged merged{read_journals(folder_)};
  for (const fs::path& file : journals(folder_)) {
    const OpenFile journal(file, O_RDWR);
    if (is_held(journal.descriptor)) merged.last = false;
  }
  write_file(folder_ / "rows.csv", rows_csv(plan, merged.rows));
  return merged;
}

}  // namespace thenar
