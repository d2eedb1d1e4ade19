// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/recording_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "engine/figures/browser.h"
#include "engine/figures/recording_page.h"
#include "engine/formats/child_process.h"
#include "engine/formats/files.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// A recording's page, opened.
class OpenRecording {
 public:
  OpenRecording(const fs::path& recording, const PageView& view)
      : browser_(recording_page(recording), view.width, view.height), view_(view) {
    constexpr int kTries = 2400;  // 2 min.
    for (int i = 0; browser_.evaluate("window.thenar?.drawn > 0") != true; ++i) {
      if (i == kTries) throw FileError(recording, "is not drawn within 2 min");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    duration_s_ = browser_.evaluate("thenar.replay.duration");
  }

  [[nodiscard]] double duration_s() const { return duration_s_; }
  [[nodiscard]] const fs::path& folder() const { return browser_.folder(); }
  [[nodiscard]] std::string picture(double at_s) {
    browser_.evaluate(fmt::format("thenar.showAt({}, {})", at_s, view_.alone));
    return browser_.picture();
  }

 private:
  Browser browser_;
  PageView view_;
  double duration_s_ = 0.0;
};

std::string encoded(const fs::path& folder, const FilmSettings& settings, const std::string& ending) {
  const std::vector<std::string> how =
      ending == ".webp"
          ? std::vector<std::string>{"-c:v", "libwebp_anim", "-quality", "70", "-compression_level", "6", "-loop", "0"}
      : ending == ".gif"
          ? std::vector<std::string>{"-filter_complex",
                                     "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=none",
                                     "-loop", "0"}
      : ending == ".webm"
          ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-pix_fmt", "yuv420p"}
          : std::vector<std::string>{"-c:v",      "libx264",   "-crf", "20",
                                     "-pix_fmt",  "yuv420p",   "-vf",  "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                     "-movflags", "+faststart"};
  const fs::path film = folder / ("film" + ending);
  std::vector<std::string> command = {"ffmpeg", "-framerate", fmt::format("{:g}", settings.frames_per_s), "-i",
                                      folder / "%06d.png"};
  command.insert(command.end(), how.begin(), how.end());
  command.emplace_back(film);
  if (!output_of({"ffmpeg", "-version"}, "")) throw FileError("ffmpeg", "is missing: films need it");
  if (!output_of(command, "")) throw FileError("ffmpeg", "failed to make a film");
  return read_file(film);
}

}  // namespace

std::string recording_picture(const fs::path& recording, const PageView& view, std::optional<double> at_s) {
  OpenRecording page(recording, view);
  return page.picture(at_s.value_or(page.duration_s()));
}

std::string recording_film(const fs::path& recording, const FilmSettings& settings, const std::string& ending,
                           const std::function<void(double)>& progress) {
  OpenRecording page(recording, settings.view);
  const double to_s = std::min(settings.to_s.value_or(page.duration_s()), page.duration_s());
  const double step_s = settings.speed / settings.frames_per_s;
  const auto frames = static_cast<int>(std::floor(std::max(0.0, to_s - settings.from_s) / step_s + 1e-6)) + 1;
  for (int i = 0; i < frames; ++i) {
    write_file(page.folder() / fmt::format("{:06}.png", i), page.picture(settings.from_s + i * step_s));
    if (progress) progress((i + 1.0) / frames);
  }
  return encoded(page.folder(), settings, ending);
}

}  // namespace thenar
