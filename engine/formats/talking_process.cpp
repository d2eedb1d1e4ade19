// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/talking_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "engine/formats/child_process.h"

namespace thenar {

namespace {

constexpr int kIn = 3, kOut = 4;  // Descriptors of the program.
constexpr int kAbove = 10;        // Ours are no lower, so that none is in the way of these.

/// Makes two connected sockets. Not a pipe: writing to one whose reader has ended would end this process, too.
bool make_sockets(std::array<int, 2>& ends) {
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return false;
  for (int& end : ends) {
    const int low = end;
    end = fcntl(low, F_DUPFD_CLOEXEC, kAbove);
    close(low);
  }
  return ends[0] >= 0 && ends[1] >= 0;
}

}  // namespace

TalkingProcess::TalkingProcess(const std::vector<std::string>& command) {
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  if (make_sockets(in) && make_sockets(out)) child_ = start_program(command, {{in[0], kIn}, {out[0], kOut}});
  to_ = in[1];
  from_ = out[1];
  for (const int end : {in[0], out[0]}) {
    if (end >= 0) close(end);
  }
}

TalkingProcess::~TalkingProcess() {
  for (const int end : {to_, from_}) {
    if (end >= 0) close(end);
  }
  if (child_ < 0) return;
  kill(-child_, SIGKILL);  // With what it has started.
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool TalkingProcess::send(std::string_view message) {
  std::string rest(message);
  rest += '\0';
  std::string_view left = rest;
  while (child_ >= 0 && !left.empty()) {
    const ssize_t sent = ::send(to_, left.data(), left.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) return false;
    if (sent > 0) left.remove_prefix(static_cast<std::size_t>(sent));
  }
  return left.empty();
}

std::optional<std::string> TalkingProcess::receive(std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  for (;;) {
    const std::size_t end = unread_.find('\0', searched_);
    if (end != std::string::npos) {
      std::string message = unread_.substr(0, end);
      unread_.erase(0, end + 1);
      searched_ = 0;
      return message;
    }
    searched_ = unread_.size();
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    pollfd waits{from_, POLLIN, 0};
    if (child_ < 0 || left.count() <= 0) return std::nullopt;
    const int ready = poll(&waits, 1, static_cast<int>(left.count()));
    if (ready == 0 || (ready < 0 && errno != EINTR)) return std::nullopt;
    if (ready < 0) continue;
    std::array<char, 65536> part;
    const ssize_t size = read(from_, part.data(), part.size());
    if (size == 0 || (size < 0 && errno != EINTR)) return std::nullopt;
    if (size > 0) unread_.append(part.data(), static_cast<std::size_t>(size));
  }
}

}  // namespace thenar
