// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace thenar {

/// A file that cannot be read or written, or does not hold what it should (exit code 3): "path: what is wrong".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& file, const std::string& what);
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  std::string file_;
};

/// A file whose bytes could not be read; it implies nothing about the contents.
class ReadError : public FileError {
  using FileError::FileError;
};

/// Returns the file's extension in lower case: ".ply".
[[nodiscard]] std::string ending_of(const std::filesystem::path& file);

/// Reads all bytes of a regular file: a pipe or a device may have no end. Throws ReadError.
[[nodiscard]] std::string read_file(const std::filesystem::path& file);

/// A cache of files: during its lifetime read_file() returns their bytes as first read, in all threads, even if the
/// files change. For work that reads a file many times and must not mix two states of it. It is global to the process,
/// since many functions lie between that work and its readers; so there is one at a time.
class KeptFiles {
 public:
  KeptFiles() = default;
  ~KeptFiles();
  KeptFiles(const KeptFiles&) = delete;
  KeptFiles& operator=(const KeptFiles&) = delete;

  /// Reads a file, by the name that read_file() will use, unless it is kept already. Throws ReadError.
  static void keep(const std::filesystem::path& file);
};

/// Tests whether read_file() would find it: it exists, or is kept.
[[nodiscard]] bool is_readable(const std::filesystem::path& file);

/// Sets how to find out whether somebody asked for the end of this process, which then waits for no pipe any more. It
/// is global to the process, as signals are.
void set_stop_question(bool (*stop_is_asked)());

/// Replaces a file by these bytes, completely or not at all; the file keeps its mode, and where that is allowed its
/// owner. A file that is not regular is written to: for a pipe, as soon as somebody reads it. Throws FileError.
void write_file(const std::filesystem::path& path, std::string_view bytes);
/// Likewise, in parts: `fill` writes them one after the other. What it throws leaves a regular file as it was.
void write_file(const std::filesystem::path& path,
                const std::function<void(const std::function<void(std::string_view)>& write)>& fill);

/// Makes a folder for results and proves that it can be written to. Throws FileError.
void prepare_folder(const std::filesystem::path& folder);

/// A lock on a file or a folder, which the system releases when the process ends in any way. It leaves no trace.
class FileLock {
 public:
  /// Takes the lock; nothing if another process, or another lock of this one, has it. A missing file is created.
  /// Pipes, devices and file systems without locks are never locked by others. Throws FileError.
  [[nodiscard]] static std::optional<FileLock> take(const std::filesystem::path& path);
  /// Replaces the locked file's contents by these bytes, and waits until they are on the disk. Throws FileError; the
  /// file may then contain a part of them.
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

/// A file that is written from its beginning, part by part.
class FileWriter {
 public:
  /// Empties the file. Throws FileError; also for a pipe that nobody reads.
  explicit FileWriter(const std::filesystem::path& path);
  /// Writes to the disk. False once this has failed, and from then on: the file ends there. A pipe whose reader is slow
  /// is waited for, until somebody asks for the end of this process.
  bool write(std::string_view bytes);
  [[nodiscard]] bool has_failed() const { return failed_; }
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

 private:
  int descriptor_;
  bool failed_ = false;
};

/// Returns a file's name relative to `folder`, for use in a file there.
[[nodiscard]] std::filesystem::path seen_from(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace thenar
