// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/gnuplot.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "engine/formats/child_process.h"
#include "engine/formats/files.h"

namespace thenar {

std::string gnuplot_string(const std::string& text) {
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  std::string literal;
  if (std::ranges::none_of(text, is_control)) {
    for (const char c : text) literal += c == '\'' ? std::string("''") : std::string(1, c);
    return "'" + literal + "'";
  }
  // A line feed would end the line of the script. Between double quotes all bytes may be numbers.
  for (const unsigned char c : text) literal += fmt::format("\\{:03o}", c);
  return '"' + literal + '"';
}

bool draw_figure(const std::string& script, const std::filesystem::path& file) {
  // Not into a file of the folder: the disk may be full, and gnuplot does not look whether it is.
  const std::optional<std::string> figure = output_of({"gnuplot", "/dev/stdin"}, script);
  if (!figure || figure->empty()) return false;
  write_file(file, *figure);
  return true;
}

}  // namespace thenar
