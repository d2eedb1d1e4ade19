// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "app/window/server.h"
#include "engine/formats/files.h"
#include "tests/support/scratch.h"

/// A server, and clients of it: real ones, over the loopback.
namespace thenar::window::server_clients {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;

inline constexpr const char* kPage =
    "<!doctype html><html data-source=\"live\"><style>p{}</style><!-- recording --><script>'<script>'</script>"
    "<script type=\"module\">1</script></html>";

/// Waits for what must come.
template <class Condition>
void await(const Condition& condition) {
  while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/// A connection on which anything may be sent.
struct Raw {
  asio::io_context io;
  tcp::socket socket{io};

  explicit Raw(std::uint16_t port) { socket.connect({asio::ip::address_v4::loopback(), port}); }

  bool send(std::string_view bytes) {
    error_code fault;
    asio::write(socket, asio::buffer(bytes), fault);
    return !fault;
  }
  /// All that comes until the end.
  std::string rest() {
    std::string bytes;
    error_code fault;
    asio::read(socket, asio::dynamic_buffer(bytes), fault);
    return bytes;
  }
};

/// A page's WebSocket.
struct Page {
  asio::io_context io;
  websocket::stream<tcp::socket> socket{io};
  error_code fault;  ///< Of the last call.
  bool text = false;

  Page(std::uint16_t port, const std::string& token) {
    const std::string host = "127.0.0.1:" + std::to_string(port);
    socket.next_layer().connect({asio::ip::address_v4::loopback(), port});
    socket.set_option(websocket::stream_base::decorator(
        [&](websocket::request_type& request) { request.set(beast::http::field::origin, "http://" + host); }));
    socket.read_message_max(0);
    socket.handshake(host, "/live?token=" + token);
  }

  bool send(const std::string& message) {
    socket.text(true);
    socket.write(asio::buffer(message), fault);
    return !fault;
  }
  void ask() { send(R"({"type":"next"})"); }
  /// The next message; empty if there is none.
  std::string read() {
    beast::flat_buffer buffer;
    socket.read(buffer, fault);
    text = !fault && socket.got_text();
    return fault ? "" : beast::buffers_to_string(buffer.data());
  }
  std::string refusal() {
    const json message = json::parse(read());
    EXPECT_EQ(message.at("type"), "refused");
    return message.at("reason");
  }
  /// Reads until the end, and says what its reason was.
  websocket::close_reason end() {
    while (!fault) read();
    return socket.reason();
  }
};

/// The bytes that ask for the WebSocket; without an Origin if that is empty.
inline std::string upgrade(const std::string& target, const std::string& host, const std::string& origin) {
  return "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" +
         (origin.empty() ? "" : "Origin: " + origin + "\r\n") +
         "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
}

inline int status(const std::string& answer) { return answer.size() < 12 ? 0 : std::stoi(answer.substr(9, 3)); }
inline std::string body(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }

class Server : public testing::Test {
 protected:
  void SetUp() override {
    alarm(120);  // Ends the tests where they would wait for ever for what does not come.
    folder_ = thenar::scratch();
    thenar::write_file(folder_ / "page.html", kPage);
    settings_.page = folder_ / "page.html";
    settings_.port = 0;
  }
  void TearDown() override {
    server_.reset();
    alarm(0);
  }

  void start() {
    server_ = std::make_unique<WindowServer>(settings_, [this](const Message& message) -> std::string {
      const std::lock_guard lock(mutex_);
      received_.push_back(message);
      if (std::holds_alternative<Reset>(message)) throw std::runtime_error("no reset today");
      return std::holds_alternative<Step>(message) ? "it is running" : "";
    });
    const std::string url = server_->url();
    port_ = static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', 7) + 1)));
    token_ = url.substr(url.find('=') + 1);
  }

  /// The answer to a GET with these fields, Host and token included.
  std::string get(const std::string& path, const std::string& fields = "") const {
    return answer("GET " + with_token(path) + " HTTP/1.1\r\n" + host() + fields + "\r\n");
  }
  std::string get_as_it_is(const std::string& target) const {
    return answer("GET " + target + " HTTP/1.1\r\n" + host() + "\r\n");
  }
  std::string with_token(const std::string& path) const {
    return path + (path.find('?') == path.npos ? "?" : "&") + "token=" + token_;
  }
  std::string answer(const std::string& request) const {
    Raw raw(port_);
    raw.send(request);
    return raw.rest();
  }
  std::string here() const { return "127.0.0.1:" + std::to_string(port_); }
  std::string host() const { return "Host: " + here() + "\r\n"; }
  /// The status that a request for the WebSocket gets: 101 is success.
  int upgraded(const std::string& target, const std::string& host, const std::string& origin) const {
    Raw raw(port_);
    raw.send(upgrade(target, host, origin));
    std::string begin(12, ' ');
    asio::read(raw.socket, asio::buffer(begin));
    return status(begin);
  }
  int upgraded(const std::string& target) const { return upgraded(target, here(), "http://" + here()); }
  std::string live() const { return with_token("/live"); }

  /// A page that has the scene.
  std::unique_ptr<Page> page() const {
    auto page = std::make_unique<Page>(port_, token_);
    EXPECT_EQ(page->read(), "scene");
    EXPECT_EQ(page->read(), "geometry");
    return page;
  }
  std::size_t received() {
    const std::lock_guard lock(mutex_);
    return received_.size();
  }

  std::filesystem::path folder_;
  ServerSettings settings_;
  std::unique_ptr<WindowServer> server_;
  std::uint16_t port_ = 0;
  std::string token_;
  std::mutex mutex_;
  std::vector<Message> received_;
};

}  // namespace thenar::window::server_clients
