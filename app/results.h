// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/mcap_reader.h"

namespace thenar::app {

/// A file that a command will write, and the flag that names it or its folder.
struct Result {
  std::string flag;
  std::filesystem::path file;
};

/// Throws ConfigError if a result would replace an input of the same command, by whatever name, or another result.
void check_results(const std::vector<Result>& results, const std::vector<std::filesystem::path>& inputs);

/// Makes a folder for results, which belongs to this process while the lock lives: results of two must not mix. Throws
/// ConfigError if another process writes there, and FileError.
[[nodiscard]] FileLock claim_folder(const std::filesystem::path& folder, const std::string& flag);

/// Folders for results that are made while this lives: those that are empty at its end are removed again.
class NewFolders {
 public:
  /// Takes note of the folder and its parents that do not exist yet.
  explicit NewFolders(std::filesystem::path folder);
  ~NewFolders();
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;

 private:
  std::vector<std::filesystem::path> missing_;  ///< The innermost first.
};

/// Prints repairs of an object's surface on stderr.
void print_object_notes(const std::vector<std::string>& notes, bool quiet);

/// Keeps all results that can be had: goes on after a FileError, and throws the first one at the end.
class Attempts {
 public:
  template <typename Write>
  void attempt(const Write& write) {
    try {
      write();
    } catch (const FileError&) {
      if (!first_) first_ = std::current_exception();
    }
  }
  /// Throws FileError if an attempt failed.
  void finish() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::exception_ptr first_;
};

/// Reads a recording through. Throws FileError if it has no states; `last_s` becomes the time of its last message.
[[nodiscard]] McapReading look_through(const std::filesystem::path& recording, double& last_s);

}  // namespace thenar::app
