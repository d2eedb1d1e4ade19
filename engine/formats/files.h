#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace thenar {

/// A file that cannot be read or written, or does not hold what it should (exit code 3): "path: what is wrong".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& file, const std::string& what)
      : std::runtime_error(file.string() + ": " + what), file_(file.string()) {}
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  std::string file_;
};

/// A file whose bytes could not be had: it says nothing about what the file holds.
class ReadError : public FileError {
  using FileError::FileError;
};

/// The ending of the file's name in small letters: ".ply".
[[nodiscard]] std::string ending_of(const std::filesystem::path& file);

/// All bytes of a regular file: a pipe or a device may have no end. Throws ReadError.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

/// Files that are read once: as long as this lives, read_file() returns their bytes as they were, in all threads,
/// whatever becomes of the files. For work that reads a file many times and must not mix two states of it. Of the whole
/// process, since many functions lie between that work and its readers; so there is one at a time.
class KeptFiles {
 public:
  KeptFiles() = default;
  ~KeptFiles();
  KeptFiles(const KeptFiles&) = delete;
  KeptFiles& operator=(const KeptFiles&) = delete;

  /// Reads a file, named as read_file() will name it, unless it is kept already. Throws ReadError.
  static void keep(const std::filesystem::path& file);
};

/// Whether read_file() would find it: it is there, or kept.
[[nodiscard]] bool is_readable(const std::filesystem::path& file);

/// Replaces a file by these bytes, whole or not at all; what is no regular file, such as a pipe, is written to. Throws
/// FileError.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes a folder for results and proves that it can be written to. Throws FileError.
void prepare_folder(const std::filesystem::path& folder);

/// A lock on a file or a folder, which the system ends with the process, however that ends. It leaves no trace.
class FileLock {
 public:
  /// Nothing if another process, or another lock of this one, has it. A missing file is made. Devices are nobody's, and
  /// a file system without locks knows of nobody. Throws FileError.
  [[nodiscard]] static std::optional<FileLock> take(const std::filesystem::path& path);
  /// Makes these bytes the locked file's contents, and waits until they are on the disk. Throws FileError; then the
  /// file may hold a part of them.
  void write(std::string_view bytes) const;
  ~FileLock();
  FileLock(FileLock&& other) noexcept
      : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileLock& operator=(FileLock&& other) = delete;

 private:
  FileLock(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_;
};

/// A file's name as a file in `folder` has to give it.
[[nodiscard]] std::filesystem::path seen_from(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace thenar
