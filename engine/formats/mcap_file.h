// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
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
  std::string encoding;         ///< Encoding of its messages: "json", or one of ours.
  std::string schema_name;      ///< Name of its messages' schema.
  std::string schema_encoding;  ///< "jsonschema" or "text".
  std::string schema;           ///< Text of the schema.
};

/// A chunk of a recording ends with the message that reaches this length: in bytes, or in recorded or wall time.
inline constexpr std::size_t kChunkBytes = 1 << 20;
inline constexpr double kChunk_s = 1.0;

/// An encoder of an MCAP file (mcap.dev, version 0), message by message: chunks with indexes, compressed by zstd where
/// that saves space, and at the end a summary for searches. Each chunk is valid alone: channels come first.
class McapEncoder {
 public:
  explicit McapEncoder(const std::vector<McapChannel>& channels);

  /// Adds a message of channel `channel`, counted from 0.
  void add(std::size_t channel, double time_s, std::string_view bytes);
  /// Ends the current chunk.
  void end_chunk();
  /// Ends the file.
  void finish();
  /// Returns the bytes made since the last call: the file is the sequence of all of these.
  [[nodiscard]] std::string take() { return std::exchange(bytes_, {}); }

 private:
  struct Chunk {
    std::uint64_t begin = 0, length = 0, index_length = 0, first_ns = 0, last_ns = 0;
    std::uint64_t stored = 0, whole = 0;  ///< Bytes of its records as stored, and uncompressed.
    bool compressed = false;
    std::map<std::uint16_t, std::uint64_t> index_at;  ///< By channel.
  };
  void write(std::uint8_t kind, std::string_view bytes);
  void append(std::string_view bytes);
  [[nodiscard]] std::string summary() const;

  std::string bytes_;
  std::uint64_t size_ = 0;  ///< Size of the file so far.
  std::uint32_t crc_ = 0;   ///< Checksum of the file so far.
  std::string schemas_, channels_;
  std::vector<std::uint32_t> messages_;  ///< By channel.
  std::vector<Chunk> chunks_;
  // State of the current chunk:
  std::string records_;
  std::map<std::uint16_t, std::string> index_;
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
  double begin_s_ = 0.0;
  std::chrono::steady_clock::time_point begun_;
};

/// A writer of an MCAP file, which has every chunk as soon as it ends: a truncated file is read to its last whole
/// chunk. When the disk fails, the file ends there.
class McapWriter {
 public:
  /// Throws FileError, also if another process writes this file.
  McapWriter(const std::filesystem::path& file, const std::vector<McapChannel>& channels);

  /// See McapEncoder. A fault of the disk is kept for finish(): the recorded run continues.
  void add(std::size_t channel, double time_s, std::string_view bytes);
  [[nodiscard]] bool has_failed() const { return file_.has_failed(); }
  /// Ends the file. Without it the file counts as truncated. Throws FileError if the disk has failed.
  void finish();

 private:
  void save();
  void throw_if_failed() const;

  std::filesystem::path path_;
  FileLock lock_;
  FileWriter file_;
  McapEncoder encoder_;
};

}  // namespace thenar
