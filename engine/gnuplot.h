#pragma once

#include <filesystem>
#include <string>

namespace thenar {

/// A string literal of gnuplot's.
[[nodiscard]] std::string gnuplot_string(const std::string& text);

/// Runs a gnuplot script, which is kept in `folder` meanwhile. False if there is no gnuplot or it failed.
[[nodiscard]] bool run_gnuplot(const std::string& script, const std::filesystem::path& folder);

}  // namespace thenar
