// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/formats/mcap_reader.h"

namespace thenar {

/// A message that is kept.
struct KeptMessage {
  std::string topic;
  double time_s;
  std::string bytes;
};

/// All of a recording.
struct KeptMessages {
  std::vector<KeptMessage> messages;
  McapReading reading;
};

inline KeptMessages messages_in(const std::filesystem::path& file) {
  KeptMessages kept;
  kept.reading = read_mcap(file, [&](const McapMessage& message) {
    kept.messages.push_back({std::string(message.topic), message.time_s, std::string(message.bytes)});
  });
  return kept;
}

}  // namespace thenar
