// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes of a connection: the server answers or ends it, and goes on. A first byte 'W' asks for the
// WebSocket first; '@' in a request stands for the server's port, '#' for its token.
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <memory>
#include <string>

#include "app/window/server.h"
#include "tests/fuzz/memory_file.h"

namespace {

using boost::asio::ip::tcp;

const std::string kUpgrade =
    "GET /live?token=# HTTP/1.1\r\nHost: localhost:@\r\nOrigin: http://localhost:@\r\nConnection: Upgrade\r\nUpgrade: "
    "websocket\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

/// A server with something to show.
struct Served {
  thenar::MemoryFile page{"page.html"};
  std::unique_ptr<thenar::window::WindowServer> server;
  std::string port, token;

  Served() {
    page.write("<html data-source=\"live\"><script></script></html>");
    thenar::window::ServerSettings settings;
    settings.port = 0;
    settings.page = page.path();
    server =
        std::make_unique<thenar::window::WindowServer>(settings, [](const thenar::window::Message&) { return "no"; });
    server->set_scene("scene", "geometry");
    server->set_status("status");
    server->show("state");
    const std::string url = server->url();
    port = url.substr(url.rfind(':') + 1, url.rfind('/') - url.rfind(':') - 1);
    token = url.substr(url.find('=') + 1);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Served kServed;
  std::string bytes(thenar::text_of(data, size));
  const bool socket = bytes.starts_with('W');
  std::string head = socket ? kUpgrade : bytes;
  for (std::size_t at = head.find_first_of("@#"); at != head.npos; at = head.find_first_of("@#", at)) {
    head.replace(at, 1, head[at] == '@' ? kServed.port : kServed.token);
  }
  bytes = socket ? head + bytes.substr(1) : head;

  boost::asio::io_context io;
  tcp::socket client(io);
  boost::system::error_code fault;  // The server may end it at any time.
  // From one address after the other: of each one the ports of the last minute are not free yet.
  static unsigned count = 0;
  client.open(tcp::v4());
  client.bind({boost::asio::ip::address_v4(0x7F000001U + count++ % 200U), 0}, fault);
  const auto port = static_cast<std::uint16_t>(std::stoi(kServed.port));
  if (!fault) client.connect({boost::asio::ip::address_v4::loopback(), port}, fault);
  if (fault) std::abort();
  boost::asio::write(client, boost::asio::buffer(bytes), fault);
  client.shutdown(tcp::socket::shutdown_send, fault);
  std::string answer;
  boost::asio::read(client, boost::asio::dynamic_buffer(answer), fault);
  return 0;
}
