// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thenar {

/// A program that takes messages from its descriptor 3 and gives messages to its descriptor 4, each with a zero byte
/// at its end, as browsers do that another program steers. It ends with this.
class TalkingProcess {
 public:
  /// Starts it, found as shells do. What it writes to its standard output and error is lost.
  explicit TalkingProcess(const std::vector<std::string>& command);
  ~TalkingProcess();
  TalkingProcess(const TalkingProcess&) = delete;
  TalkingProcess& operator=(const TalkingProcess&) = delete;

  /// Sends a message; false if the program does not run any more.
  [[nodiscard]] bool send(std::string_view message);
  /// Waits for the next message; nothing if the program ended or said nothing for so long.
  [[nodiscard]] std::optional<std::string> receive(std::chrono::milliseconds patience);

 private:
  pid_t child_ = -1;
  int to_ = -1, from_ = -1;
  std::string unread_;
  std::size_t searched_ = 0;  ///< So many bytes of it are known to hold no end of a message.
};

}  // namespace thenar
