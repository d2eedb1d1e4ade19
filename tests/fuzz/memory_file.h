// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace thenar {

/// A file in memory, for readers that take a path. It is in a folder of this process.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& name)
      : folder_("/dev/shm/thenar_fuzz_" + std::to_string(::getpid())), path_(folder_ / name) {
    std::filesystem::create_directories(folder_);
  }
  ~MemoryFile() { std::filesystem::remove_all(folder_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  void write(std::string_view bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }

 private:
  std::filesystem::path folder_, path_;
};

/// libFuzzer's bytes as text.
inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace thenar
