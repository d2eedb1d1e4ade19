#include "engine/results/gnuplot.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>

#include "engine/formats/files.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// A file that is in memory alone, and that programs that this one starts can open by its path.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : descriptor_(memfd_create("script", 0)) {
    std::FILE* const file = std::fopen(path().c_str(), "w");
    if (file == nullptr) return;
    is_whole_ = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    is_whole_ = std::fclose(file) == 0 && is_whole_;
  }
  ~MemoryFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] std::string path() const { return fmt::format("/dev/fd/{}", descriptor_); }
  [[nodiscard]] bool is_whole() const { return is_whole_; }

 private:
  int descriptor_;
  bool is_whole_ = false;
};

}  // namespace

std::string gnuplot_string(const std::string& text) {
  std::string literal = "'";
  for (const char c : text) literal += c == '\'' ? std::string("''") : std::string(1, c);
  return literal + "'";
}

bool draw_figure(const std::string& script, const fs::path& file) {
  // Not a pipe: one to a program that is missing or stops ends us, too. And not a file of the folder: the disk may be
  // full, and gnuplot does not look whether it is.
  const MemoryFile input(script);
  if (!input.is_whole()) return false;
  std::FILE* const output = popen(("gnuplot " + input.path() + " 2>/dev/null").c_str(), "r");
  if (output == nullptr) return false;
  std::string figure;
  for (int c = std::fgetc(output); c != EOF; c = std::fgetc(output)) figure += static_cast<char>(c);
  if (pclose(output) != 0 || figure.empty()) return false;
  write_file(file, figure);
  return true;
}

}  // namespace thenar
