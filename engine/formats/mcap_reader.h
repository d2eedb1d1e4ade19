#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string_view>

namespace thenar {

/// One message of a recording, for as long as it is received.
struct McapMessage {
  std::string_view topic;
  double time_s = 0.0;
  std::string_view bytes;
};
using ReceiveMessage = std::function<void(const McapMessage&)>;

/// How much of a recording could be read.
struct McapReading {
  bool whole = false;              ///< The file was ended, and is sound.
  std::size_t damaged_chunks = 0;  ///< These were passed over.
};

/// Gives the messages of an MCAP file (mcap.dev, version 0) in the order in which they were written, up to the last
/// whole chunk, or outside of chunks the last whole message. Knows chunks without compression and those of zstd. One
/// chunk at a time is held in full. Throws FileError if the file cannot be read, is no such file, or has a message of a
/// channel that it does not name; and what `receive` throws.
McapReading read_mcap(const std::filesystem::path& file, const ReceiveMessage& receive);

/// The same of its bytes; `file` is for errors alone.
McapReading read_mcap(std::string_view bytes, const std::filesystem::path& file, const ReceiveMessage& receive);

}  // namespace thenar
