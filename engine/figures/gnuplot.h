// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace thenar {

/// Returns the text, of any bytes but NUL, as a string literal of gnuplot.
[[nodiscard]] std::string gnuplot_string(const std::string& text);

/// Draws the figure of a gnuplot script, which names no output, and writes it whole, whatever signals come meanwhile.
/// False if there is no gnuplot or it failed. Throws FileError if the figure cannot be written.
[[nodiscard]] bool draw_figure(const std::string& script, const std::filesystem::path& file);

}  // namespace thenar
