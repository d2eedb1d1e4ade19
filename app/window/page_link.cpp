// SPDX-License-Identifier: Apache-2.0
#include "app/window/page_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "app/window/message.h"
#include "engine/loops/realtime.h"

namespace thenar::window {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using beast::error_code;

constexpr std::chrono::nanoseconds kStatePeriod(1'000'000'000 / 60);
constexpr double kMessagesPerSecond = 200.0;  // A hand's motion is 60 a second, the states are as many.

// What is no UTF-8 cannot come: a message that has it is refused. Still nothing here may throw for it.
std::string text_of(const nlohmann::json& message) {
  return message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

PageLink::PageLink(Stream stream, std::unique_ptr<Seat> seat, Hub& hub)
    : hub_(hub),
      seat_(std::move(seat)),
      socket_(std::move(stream)),
      write_deadline_(socket_.get_executor()),
      state_due_(socket_.get_executor()),
      allowance_(kMessagesPerSecond) {}

PageLink::~PageLink() {
  if (hub_.links.erase(this) > 0) --hub_.pages;
}

void PageLink::start(const Request& request) {
  beast::get_lowest_layer(socket_).expires_never();  // From here on the WebSocket's own.
  websocket::stream_base::timeout patience;
  patience.handshake_timeout = hub_.patience;
  patience.idle_timeout = hub_.patience;  // Who is silent for half of it is pinged.
  patience.keep_alive_pings = true;
  socket_.set_option(patience);
  socket_.auto_fragment(false);  // A message goes out from where it lies.
  socket_.read_message_max(0);   // read() counts, so that it can say what was wrong.
  beast::get_lowest_layer(socket_).rate_policy().watch([this] { drop(); });
  socket_.control_callback([this](websocket::frame_type, beast::string_view) {
    note_progress();
    if (!may_talk()) drop();
  });
  socket_.async_accept(request, [self = shared_from_this()](error_code fault) {
    if (fault) return;
    self->open_ = true;
    self->hub_.links.insert(self.get());
    ++self->hub_.pages;
    self->read();
    self->pump();
  });
}

void PageLink::read() {
  const std::size_t room = kMaxMessage + 1 - buffer_.size();
  socket_.async_read_some(buffer_, room, [self = shared_from_this()](error_code fault, std::size_t) {
    if (fault) return self->drop();
    self->note_progress();
    if (!self->may_talk()) return self->close(websocket::close_code::policy_error, "more than 200 messages a second");
    if (self->buffer_.size() > kMaxMessage) {
      return self->close(websocket::close_code::too_big, "a message has at most 4096 bytes");
    }
    if (self->socket_.is_message_done()) {
      self->take(beast::buffers_to_string(self->buffer_.cdata()));
      self->buffer_.clear();
      self->pump();
    }
    self->read();
  });
}

void PageLink::take(std::string_view text) {
  ReadMessage read = socket_.got_text() ? read_message(text) : ReadMessage{{}, "a message is text"};
  if (read.message) read.refusal = act(*read.message);
  if (!read.refusal.empty()) refusal_ = text_of({{"type", "refused"}, {"reason", read.refusal}});
}

/// Does what the page asks for, or says why not.
std::string PageLink::act(const Message& message) try {
  if (std::holds_alternative<Next>(message)) {
    wants_state_ = true;
    return "";
  }
  if (const Ping* const ping = std::get_if<Ping>(&message)) {
    const double now_s = 1e-9 * static_cast<double>(thenar::steady_now_ns());
    pong_ = text_of({{"type", "pong"}, {"t", ping->t}, {"now_s", now_s}});
    return "";
  }
  return hub_.receive(message);
} catch (const std::exception& error) {
  return fmt::format("internal error: {}", error.what());
}

void PageLink::pump() {
  if (!open_ || writing_) return;
  const News news = hub_.newest();
  const auto is_new = [](const Shown& message, std::int64_t& sent) {
    if (message.number <= sent) return false;
    sent = message.number;
    return true;
  };
  if (is_new(news.scene, scene_)) return write(news.scene.bytes, true);
  if (is_new(news.geometry, geometry_)) return write(news.geometry.bytes, false);
  if (is_new(news.status, status_)) return write(news.status.bytes, true);
  if (is_new(news.grasps, grasps_)) return write(news.grasps.bytes, true);
  if (pong_) return answer(pong_);
  if (refusal_) return answer(refusal_);
  const bool shown = news.scene.number > 0 && news.state.bytes && news.state.number > state_;
  if (!wants_state_ || !shown || waiting_) return;
  if (Clock::now() < state_due_.expiry()) {
    waiting_ = true;
    state_due_.async_wait([self = shared_from_this()](error_code) {
      self->waiting_ = false;
      self->pump();
    });
    return;
  }
  wants_state_ = false;
  state_ = news.state.number;
  state_due_.expires_after(kStatePeriod);
  write(news.state.bytes, false);
}

void PageLink::answer(std::optional<std::string>& text) {
  const auto bytes = std::make_shared<const std::string>(std::move(*text));
  text.reset();
  write(bytes, true);
}

void PageLink::write(const std::shared_ptr<const std::string>& bytes, bool text) {
  writing_ = true;
  write_deadline_.expires_after(hub_.patience);
  write_deadline_.async_wait([self = shared_from_this()](error_code cancelled) {
    if (!cancelled && self->writing_ && Clock::now() >= self->write_deadline_.expiry()) self->drop();
  });
  socket_.text(text);
  socket_.async_write(boost::asio::buffer(*bytes), [self = shared_from_this(), bytes](error_code fault, std::size_t) {
    self->writing_ = false;
    self->write_deadline_.cancel();
    if (fault) return self->drop();
    self->pump();
  });
}

/// A message, or a part of one that has bytes, or a sign of life has come.
void PageLink::note_progress() { beast::get_lowest_layer(socket_).rate_policy().note_progress(); }

/// Whether the page keeps to its share of messages; counts one more.
bool PageLink::may_talk() {
  const Clock::time_point now = Clock::now();
  const double since_s = std::chrono::duration<double>(now - counted_).count();
  counted_ = now;
  allowance_ = std::min(kMessagesPerSecond, allowance_ + since_s * kMessagesPerSecond) - 1.0;
  return allowance_ >= 0.0;
}

/// Says why, and ends. What the page still sends until it has read that is thrown away.
void PageLink::close(websocket::close_code code, const char* reason) {
  open_ = false;
  beast::get_lowest_layer(socket_).rate_policy().watch({});  // The patience for a close is its end.
  socket_.async_close({code, reason}, [self = shared_from_this()](error_code) { self->drop(); });
}

/// Ends at once: what is under way fails, and with its last handler this goes.
void PageLink::drop() {
  open_ = false;
  write_deadline_.cancel();
  state_due_.cancel();
  beast::get_lowest_layer(socket_).close();
}

}  // namespace thenar::window
