#include "engine/gnuplot.h"

#include <cstdlib>

#include "engine/files.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// One word of the shell's.
std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace

std::string gnuplot_string(const std::string& text) {
  std::string literal = "'";
  for (const char c : text) literal += c == '\'' ? std::string("''") : std::string(1, c);
  return literal + "'";
}

bool run_gnuplot(const std::string& script, const fs::path& folder) {
  // A file and not a pipe: a pipe to a program that is missing or stops ends us too.
  const fs::path file = folder / ".figures.gnuplot";
  write_file(file, script);
  const int status = std::system(("gnuplot " + shell_word(file.string()) + " >/dev/null 2>&1").c_str());
  std::error_code error;
  fs::remove(file, error);
  return status == 0;
}

}  // namespace thenar
