// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/figures/recording_film.h"

namespace CLI {
class App;
}  // namespace CLI

namespace thenar::app {

/// The flags of thenar export.
struct ExportFlags {
  std::filesystem::path recording;
  std::filesystem::path html, csv, npz, sto, png, film;  ///< What is made of it; empty: not this one.
  std::string at, from, to, size;                        ///< As written; empty: not asked for.
  double speed = 1.0, frames_per_s = 25.0;
  bool alone = false;

  [[nodiscard]] PageView view() const;
  [[nodiscard]] std::optional<double> at_s() const;
  [[nodiscard]] FilmSettings film_settings() const;
};

/// Adds the command export.
void add_export(CLI::App& app, ExportFlags& flags);

}  // namespace thenar::app
