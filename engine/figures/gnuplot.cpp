#include "engine/figures/gnuplot.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <cstdio>
#include <memory>

#include "engine/formats/files.h"

namespace thenar {

namespace fs = std::filesystem;

std::string gnuplot_string(const std::string& text) {
  std::string literal = "'";
  for (const char c : text) literal += c == '\'' ? std::string("''") : std::string(1, c);
  return literal + "'";
}

bool draw_figure(const std::string& script, const fs::path& file) {
  // Not a pipe: one to a program that is missing or stops ends us, too. And not a file of the folder: the disk may be
  // full, and gnuplot does not look whether it is.
  const int memory = memfd_create("script", 0);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> input(fdopen(memory, "w"), std::fclose);
  if (!input || std::fwrite(script.data(), 1, script.size(), input.get()) != script.size()) return false;
  if (std::fflush(input.get()) != 0) return false;
  std::FILE* const output = popen(fmt::format("gnuplot /dev/fd/{} 2>/dev/null", memory).c_str(), "r");
  if (output == nullptr) return false;
  std::string figure;
  for (int c = std::fgetc(output); c != EOF; c = std::fgetc(output)) figure += static_cast<char>(c);
  if (pclose(output) != 0 || figure.empty()) return false;
  write_file(file, figure);
  return true;
}

}  // namespace thenar
