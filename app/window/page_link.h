// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "app/window/hub.h"

namespace thenar::window {

/// The WebSocket to one page, on the server's thread; keeps itself alive while the page is there. Whatever the page
/// does, it holds one message from it, one on its way to it, and two small answers.
class PageLink : public std::enable_shared_from_this<PageLink> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  PageLink(Stream stream, std::unique_ptr<Seat> seat, Hub& hub);
  ~PageLink();
  PageLink(const PageLink&) = delete;
  PageLink& operator=(const PageLink&) = delete;

  /// Accepts the request for a WebSocket, and serves the page from there on.
  void start(const Request& request);
  /// Sends what comes next, unless something is on its way.
  void pump();

 private:
  using Clock = std::chrono::steady_clock;

  void read();
  void take(std::string_view text);
  std::string act(const Message& message);
  void write(const std::shared_ptr<const std::string>& bytes, bool text);
  void answer(std::optional<std::string>& text);
  void note_progress();
  bool may_talk();
  void close(boost::beast::websocket::close_code code, const char* reason);
  void drop();

  Hub& hub_;
  std::unique_ptr<Seat> seat_;
  boost::beast::websocket::stream<Stream> socket_;
  boost::beast::flat_buffer buffer_;
  boost::asio::steady_timer write_deadline_, state_due_;
  bool open_ = false, writing_ = false, waiting_ = false;
  bool wants_state_ = false;
  std::int64_t scene_ = 0, geometry_ = 0, status_ = 0, grasps_ = 0, state_ = 0;  ///< Numbers of the last ones sent.
  std::optional<std::string> pong_, refusal_;                                    ///< Pending answers.
  double allowance_;                          ///< Messages that the page may send at `counted_`.
  Clock::time_point counted_ = Clock::now();  ///< Time of `allowance_`.
};

}  // namespace thenar::window
