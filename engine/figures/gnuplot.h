#pragma once

#include <filesystem>
#include <string>

namespace thenar {

/// A string literal of gnuplot's.
[[nodiscard]] std::string gnuplot_string(const std::string& text);

/// Draws the figure of a gnuplot script, which names no output, and writes it whole. False if there is no gnuplot or it
/// failed. Throws FileError if the figure cannot be written.
[[nodiscard]] bool draw_figure(const std::string& script, const std::filesystem::path& file);

}  // namespace thenar
