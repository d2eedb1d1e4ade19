// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string_view>

namespace thenar {

/// One message of a recording, valid while it is received.
struct McapMessage {
  std::string_view topic;
  double time_s = 0.0;
  std::string_view bytes;
};
using ReceiveMessage = std::function<void(const McapMessage&)>;

/// The extent of a recording that could be read.
struct McapReading {
  bool whole = false;              ///< True if the file was ended, and is valid.
  std::size_t damaged_chunks = 0;  ///< Number of chunks that were skipped.
};

/// Passes the messages of an MCAP file (mcap.dev, version 0) to `receive` in the order in which they were written, up
/// to the last whole chunk, or outside of chunks the last whole message. Supports chunks without compression and with
/// zstd. One chunk at a time is in memory. Throws FileError if the file cannot be read, is no MCAP file, has a message
/// of an undeclared channel or chunks compressed by lz4, or unpacks to more than 64 MiB and kMostUnpacked times its
/// size; and exceptions of `receive`.
inline constexpr std::size_t kMostUnpacked = 256;
McapReading read_mcap(const std::filesystem::path& file, const ReceiveMessage& receive);

/// Passes the messages of an MCAP file's bytes; `file` is for errors alone.
McapReading read_mcap(std::string_view bytes, const std::filesystem::path& file, const ReceiveMessage& receive);

}  // namespace thenar
