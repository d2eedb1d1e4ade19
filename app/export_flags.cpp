// SPDX-License-Identifier: Apache-2.0
#include "app/export_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <utility>

#include "app/scene_flags.h"
#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"

namespace thenar::app {

namespace {

constexpr int kLeast_px = 100, kMost_px = 4096;

/// Width and height of "1280x800"; nothing if it is something else.
std::optional<std::pair<int, int>> read_size(const std::string& text) {
  const std::size_t cross = std::min(text.find('x'), text.size());
  const auto width = number_in<int>(text.substr(0, cross)),
             height = number_in<int>(text.substr(std::min(cross + 1, text.size())));
  const auto fits = [](const auto& px) { return px && *px >= kLeast_px && *px <= kMost_px; };
  if (!fits(width) || !fits(height)) return std::nullopt;
  return std::pair(*width, *height);
}

CLI::Validator some_size() {
  return {[](const std::string& text) {
            if (read_size(text)) return std::string();
            return fmt::format("{} is no size of {} to {} pixels, such as 1280x800", text, kLeast_px, kMost_px);
          },
          ""};
}

CLI::Validator film_file() {
  return {[](const std::string& file) {
            if (std::ranges::count(kFilmFormats, ending_of(file)) > 0) return std::string();
            return file + " ends in none of .webp, .gif, .webm and .mp4";
          },
          ""};
}

/// A time of a recording, which may be its beginning.
CLI::Validator time_of_recording() {
  const CLI::Validator rule = quantity(Dimension::kTime, 0.0, 1e5, "1.2 s");
  return {[rule](const std::string& text) {
            std::string time = with_unit(text);
            return rule(time);
          },
          ""};
}

}  // namespace

PageView ExportFlags::view() const {
  PageView view{.alone = alone};
  if (!size.empty()) std::tie(view.width, view.height) = read_size(size).value();
  return view;
}

std::optional<double> ExportFlags::at_s() const {
  if (at.empty()) return std::nullopt;
  return time_s(with_unit(at));
}

FilmSettings ExportFlags::film_settings() const {
  FilmSettings settings{.view = view(), .speed = speed, .frames_per_s = frames_per_s};
  if (!from.empty()) settings.from_s = time_s(with_unit(from));
  if (!to.empty()) settings.to_s = time_s(with_unit(to));
  return settings;
}

void add_export(CLI::App& app, ExportFlags& flags) {
  CLI::App* const command = app.add_subcommand(
      "export", "Makes one page that plays without a network, a picture, a film, or tables, of a recording");
  command->add_option("FILE", flags.recording, "Recording, of thenar run --record")->required();
  CLI::Option_group* const formats = command->add_option_group("formats");
  const auto add = [&](const char* option, std::filesystem::path& file, const char* what) {
    return formats->add_option(option, file, what)->type_name("FILE")->check(named())->check(no_folder());
  };
  add("--html", flags.html, "The page, one file");
  add("--csv", flags.csv, "A row a state: its numbers by name, but for shapes");
  add("--npz", flags.npz, "Arrays for NumPy by the names of their fields, contacts too; SI units");
  add("--sto", flags.sto, "Joint angles and muscle forces for OpenSim");
  CLI::Option* const png = add("--png", flags.png, "A picture of the page; it needs Chromium");
  CLI::Option* const film =
      add("--film", flags.film, "A film of the page, .webp, .gif, .webm or .mp4; it needs Chromium and ffmpeg");
  film->check(film_file());
  formats->require_option(1, 6);
  command->add_option("--at", flags.at, "Of the picture: the recorded time that it shows; default: the end")
      ->type_name("T")
      ->check(time_of_recording())
      ->needs(png);
  command->add_option("--from", flags.from, "Of the film: the first recorded time; default: the beginning")
      ->type_name("T")
      ->check(time_of_recording())
      ->needs(film);
  command->add_option("--to", flags.to, "Of the film: the last recorded time; default: the end")
      ->type_name("T")
      ->check(time_of_recording())
      ->needs(film);
  command->add_option("--speed", flags.speed, "Of the film: recorded time over its own")
      ->type_name("X")
      ->capture_default_str()
      ->check(within(1e-3, 1e3))
      ->needs(film);
  command->add_option("--fps", flags.frames_per_s, "Of the film: frames a second")
      ->type_name("N")
      ->capture_default_str()
      ->check(within(1.0, 100.0))
      ->needs(film);
  command->add_option("--size", flags.size, "Of picture and film: width and height in pixels, default 1280x800")
      ->type_name("WxH")
      ->check(some_size());
  command->add_flag("--alone", flags.alone,
                    "Of picture and film: hand and object alone, without the plots around them");
}

}  // namespace thenar::app
