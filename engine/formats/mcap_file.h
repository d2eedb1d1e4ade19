#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
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

/// Writes an MCAP file (mcap.dev, version 0), message by message, without chunks or an index: it is sound after every
/// message, and a reader gets all whole messages of one that was cut off. When the disk fails, the file ends there.
class McapWriter {
 public:
  /// Throws FileError, also if another process writes this file.
  McapWriter(const std::filesystem::path& file, const std::vector<McapChannel>& channels);

  /// A message of channel `channel`, counted from 0. A fault of the disk is kept for finish(): what is recorded goes
  /// on.
  void add(std::size_t channel, double time_s, std::string_view bytes);
  /// Ends the file. Without it the file counts as cut off. Throws FileError if the disk has failed since the beginning.
  void finish();

 private:
  void record(std::uint8_t kind, std::string_view bytes);
  void throw_if_failed() const;

  std::filesystem::path path_;
  FileLock lock_;
  std::ofstream file_;
  std::vector<std::uint32_t> messages_;  ///< Written, by channel.
};

/// One message of a recording.
struct McapMessage {
  std::string topic;
  double time_s = 0.0;
  std::string_view bytes;  ///< In the file's.
};

/// The messages of a file that McapWriter wrote, in order, up to the last whole one; `whole` says whether the file was
/// ended. Throws FileError if it cannot be read or is no such file: of chunks and compression this reader knows
/// nothing.
struct McapContents {
  std::string file;  ///< All its bytes: messages are many, and held here alone.
  std::vector<McapMessage> messages;
  bool whole = false;

  McapContents() = default;
  McapContents(McapContents&&) = default;
  McapContents& operator=(McapContents&&) = default;
};
[[nodiscard]] McapContents read_mcap(const std::filesystem::path& file);

}  // namespace thenar
