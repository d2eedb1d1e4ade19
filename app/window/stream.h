// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

namespace thenar::window {

/// Counts what a connection reads that nothing comes of: a WebSocket takes empty pieces of a message for itself,
/// without end.
class ReadWatch {
 public:
  /// Calls `end` once more than 64 kB have come to nothing: more than a whole message and what comes with it.
  void watch(std::function<void()> end) { end_ = std::move(end); }
  /// Notes that something has come of the bytes read.
  void note_progress() { idle_bytes_ = 0; }

 private:
  // Interface of a rate policy of Beast.
  friend class boost::beast::rate_policy_access;

  static constexpr std::size_t kMost = 64 * 1024;

  [[nodiscard]] static std::size_t available_read_bytes() { return std::numeric_limits<std::size_t>::max(); }
  [[nodiscard]] static std::size_t available_write_bytes() { return std::numeric_limits<std::size_t>::max(); }
  void transfer_read_bytes(std::size_t bytes) {
    idle_bytes_ += bytes;
    if (idle_bytes_ > kMost && end_) end_();
  }
  static void transfer_write_bytes(std::size_t /*bytes*/) {}
  static void on_timer() {}

  std::function<void()> end_;
  std::size_t idle_bytes_ = 0;
};

/// A connection to the server.
using Stream = boost::beast::basic_stream<boost::asio::ip::tcp, boost::asio::any_io_executor, ReadWatch>;

}  // namespace thenar::window
