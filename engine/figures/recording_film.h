// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace thenar {

/// How the window's page shows a recording in pictures.
struct PageView {
  int width = 1280, height = 800;  ///< [px].
  bool alone = false;              ///< The picture without the plots and buttons around it.
};

/// Returns a recording's page at a time, from its beginning, as a PNG; nothing: at its end. Throws FileError as
/// recording_page() does, and if there is no browser.
[[nodiscard]] std::string recording_picture(const std::filesystem::path& recording, const PageView& view,
                                            std::optional<double> at_s);

struct FilmSettings {
  PageView view = {};
  double from_s = 0.0;              ///< First time that is shown.
  std::optional<double> to_s = {};  ///< Last one; nothing: the recording's end.
  double speed = 1.0;               ///< Recorded time over the film's.
  double frames_per_s = 25.0;
};

/// Formats of films, by their files' endings.
inline constexpr std::array<const char*, 4> kFilmFormats{".webp", ".gif", ".webm", ".mp4"};

/// Returns a film of a recording's page in the format of this ending. Every frame is drawn, however long that takes;
/// `progress` is called after each with the share of the film that is drawn. Throws FileError as recording_picture()
/// does, and if ffmpeg is missing.
[[nodiscard]] std::string recording_film(const std::filesystem::path& recording, const FilmSettings& settings,
                                         const std::string& ending, const std::function<void(double)>& progress = {});

}  // namespace thenar
