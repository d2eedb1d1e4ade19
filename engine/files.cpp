#include "engine/files.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <system_error>

namespace thenar {

std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

std::string read_file(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw FileError(file, "is a folder, not a file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw FileError(file, std::filesystem::exists(file, error) ? "cannot be read" : "no such file");
  std::ostringstream bytes;
  // An empty file sets the failure bit here, which is no fault.
  bytes << stream.rdbuf();
  if (stream.bad()) throw FileError(file, "cannot be read");
  return std::move(bytes).str();
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::error_code unresolved;
  // What a link names is written, and the link stays; a device or a pipe cannot be put in place of another.
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(path, unresolved);
  const std::filesystem::path& file = unresolved ? path : resolved;
  const bool replace = !std::filesystem::exists(file, unresolved) || std::filesystem::is_regular_file(file, unresolved);
  const std::filesystem::path draft = file.string() + (replace ? ".part" : "");
  std::ofstream stream(draft, std::ios::binary | std::ios::trunc);
  if (!stream) throw FileError(path, "cannot be written");
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  // A full disk may show only when the last bytes leave the buffer.
  stream.close();
  std::error_code error;
  if (stream && replace) std::filesystem::rename(draft, file, error);
  if (stream && !error) return;
  if (replace) std::filesystem::remove(draft, error);
  throw FileError(path, "could not be written in full");
}

void prepare_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(folder, "cannot make this folder: " + error.message());
  const std::filesystem::path probe = folder / ".thenar";
  if (!std::ofstream(probe)) throw FileError(folder, "cannot write into this folder");
  std::filesystem::remove(probe, error);
}

}  // namespace thenar
