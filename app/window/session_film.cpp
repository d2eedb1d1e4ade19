// SPDX-License-Identifier: Apache-2.0
#include "app/window/session_film.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/formats/files.h"
#include "engine/loops/realtime.h"

namespace thenar::window {

namespace fs = std::filesystem;

namespace {

/// A name that no file of the folder has: of the scene and the time of day, such as box_grasp-20261130-081503.mcap.
fs::path new_file(const fs::path& folder, std::string scene) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  for (char& c : scene) {
    if (kPlain.find(c) == kPlain.npos) c = '_';
  }
  constexpr std::size_t kLongest = 100;  // A file's name may have 255 bytes.
  const std::string stem =
      fmt::format("{}-{:%Y%m%d-%H%M%S}", scene.substr(0, kLongest), fmt::localtime(std::time(nullptr)));
  fs::path file = folder / (stem + ".mcap");
  std::error_code none;
  for (int i = 2; fs::exists(file, none); ++i) file = folder / fmt::format("{}-{}.mcap", stem, i);
  return file;
}

/// What is wrong, without the name of the file before it.
std::string words_of(const FileError& error) {
  const std::string_view text = error.what();
  return std::string(text.substr(std::min(text.size(), error.file().size() + 2)));
}

}  // namespace

void SessionFilm::begin(const fs::path& file, const TriangleMesh& surface, double now_s, LiveContact& live) {
  std::error_code none;
  const fs::path whole = fs::absolute(file, none);
  news_ = {{"file", whole.string()}, {"running", false}, {"begun_s", now_s}, {"note", nullptr}};
  file_ = std::make_unique<RecordingFile>(file, model_, settings_, surface, now_s);
  news_["running"] = true;
  lost_states_ = lost_ticks_ = 0;
  follow(live);
}

void SessionFilm::begin_in_folder(const TriangleMesh& surface, double now_s, LiveContact& live) try {
  begin(new_file(folder_, model_.scene.name), surface, now_s, live);
} catch (const FileError& error) {
  news_["note"] = words_of(error);
}

void SessionFilm::end(LiveContact& live) {
  if (!is_on()) return;
  take();
  news_["running"] = false;
  if (const std::string missing = file_->missing(); !missing.empty()) news_["note"] = missing;
  try {
    file_->finish();
  } catch (const FileError& error) {
    news_["note"] = words_of(error);
    if (!fault_) fault_ = std::current_exception();
  }
  live.tap = nullptr;
  tap_.reset();
  file_.reset();
}

void SessionFilm::finish(LiveContact& live) {
  end(live);
  if (fault_) std::rethrow_exception(fault_);
}

void SessionFilm::follow(LiveContact& live) {
  if (!is_on()) return;
  lost_states_ += tap_ ? tap_->lost_pictures() : 0;
  lost_ticks_ += tap_ ? tap_->lost_contacts() : 0;
  tap_ = std::make_unique<FilmTap>(model_, ticks_per_state(model_, settings_), settings_.contacts);
  live.tap = tap_.get();
}

void SessionFilm::take() {
  if (!is_on()) return;
  file_->take_contacts(*tap_);
  file_->miss(lost_states_ + tap_->lost_pictures(), lost_ticks_ + tap_->lost_contacts());
}

void SessionFilm::see(std::int64_t number, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N,
                      Telemetry& telemetry) {
  const Picture* const picture = is_on() ? tap_->picture_of(number) : nullptr;
  if (picture == nullptr) return;
  TickRecord whole = tick;
  telemetry.write_stages(whole);
  file_->add(*picture, whole, muscle_forces_N, telemetry.figures(steady_now_ns()));
  tap_->pictures.pop();
}

void SessionFilm::add(const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& muscle_forces_N) {
  if (is_on()) file_->add(picture, tick, muscle_forces_N);
}

void SessionFilm::add_scene(double now_s) {
  if (is_on()) file_->add_scene(model_, now_s);
}

void SessionFilm::add_status(double now_s, const nlohmann::ordered_json& status) {
  if (is_on()) file_->add_status(now_s, status);
}

}  // namespace thenar::window
