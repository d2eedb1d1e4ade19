#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/formats/files.h"

namespace thenar {

/// A topic of a recording.
struct McapChannel {
  std::string topic;
  std::string encoding;         ///< Of its messages: "json", or one of ours.
  std::string schema_name;      ///< Of what its messages hold,
  std::string schema_encoding;  ///< "jsonschema" or "text",
  std::string schema;           ///< and its text.
};

/// A chunk of a recording ends with the message that makes it so long: in bytes, and in recorded or wall time.
inline constexpr std::size_t kChunkBytes = 1 << 20;
inline constexpr double kChunk_s = 1.0;

/// Makes the bytes of an MCAP file (mcap.dev, version 0), message by message: chunks with indexes, compressed by zstd
/// where that saves anything, and at the end a summary by which readers find what they look for. All chunks are sound
/// by themselves: the channels stand before the first one.
class McapEncoder {
 public:
  explicit McapEncoder(const std::vector<McapChannel>& channels);

  /// A message of channel `channel`, counted from 0.
  void add(std::size_t channel, double time_s, std::string_view bytes);
  /// Ends the chunk that is being filled.
  void end_chunk();
  /// Ends the file.
  void finish();
  /// What has been made since it was called last: the file is all that it gave, in order.
  [[nodiscard]] std::string take() { return std::exchange(bytes_, {}); }

 private:
  struct Chunk {
    std::uint64_t begin = 0, length = 0, index_length = 0, first_ns = 0, last_ns = 0;
    std::uint64_t stored = 0, whole = 0;  ///< Bytes of its records, compressed or not, and as they were.
    bool compressed = false;
    std::map<std::uint16_t, std::uint64_t> index_at;  ///< By channel.
  };
  void write(std::uint8_t kind, std::string_view bytes);
  void append(std::string_view bytes);
  [[nodiscard]] std::string summary() const;

  std::string bytes_;
  std::uint64_t size_ = 0;  ///< Of the file so far,
  std::uint32_t crc_ = 0;   ///< and its checksum.
  std::string schemas_, channels_;
  std::vector<std::uint32_t> messages_;  ///< By channel.
  std::vector<Chunk> chunks_;
  // Of the chunk that is being filled:
  std::string records_;
  std::map<std::uint16_t, std::string> index_;
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
  double begin_s_ = 0.0;
  std::chrono::steady_clock::time_point begun_;
};

/// The same in a file, which has every chunk as soon as it has ended: one that was cut off is read to its last whole
/// chunk. When the disk fails, the file ends there.
class McapWriter {
 public:
  /// Throws FileError, also if another process writes this file.
  McapWriter(const std::filesystem::path& file, const std::vector<McapChannel>& channels);

  /// See McapEncoder. A fault of the disk is kept for finish(): what is recorded goes on.
  void add(std::size_t channel, double time_s, std::string_view bytes);
  /// Ends the file. Without it the file counts as cut off. Throws FileError if the disk has failed since the beginning.
  void finish();

 private:
  void save();
  void throw_if_failed() const;

  std::filesystem::path path_;
  FileLock lock_;
  std::ofstream file_;
  McapEncoder encoder_;
};

}  // namespace thenar
