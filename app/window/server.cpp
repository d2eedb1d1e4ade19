// SPDX-License-Identifier: Apache-2.0
#include "app/window/server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/system_error.hpp>
#include <csignal>
#include <system_error>
#include <thread>
#include <utility>

#include "app/window/admission.h"
#include "app/window/http_exchange.h"
#include "app/window/hub.h"
#include "app/window/page_link.h"
#include "app/window/page_text.h"
#include "engine/formats/files.h"

namespace thenar::window {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kMaxStrangers = 32;
constexpr int kSendBuffer = 256 * 1024;  // Of the system, a page: what it holds for one that stopped reading.
constexpr std::chrono::milliseconds kRest(100);

/// A browser that this program starts does not inherit the socket, and with it the port.
template <class Socket>
void close_on_exec(Socket& socket) {
  fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
}

tcp::acceptor listen(asio::io_context& io, const std::string& address, std::uint16_t port) {
  if (reach_of(address) == Reach::kNoAddress) throw PortError(address + ": is no numeric address, such as 127.0.0.1");
  const tcp::endpoint place(asio::ip::make_address(address), port);
  tcp::acceptor acceptor(io);
  error_code fault;
  acceptor.open(place.protocol(), fault);
  if (!fault) acceptor.set_option(tcp::acceptor::reuse_address(true), fault);
  if (!fault) acceptor.bind(place, fault);
  if (!fault) acceptor.listen(asio::socket_base::max_listen_connections, fault);
  if (!fault) {
    close_on_exec(acceptor);
    return acceptor;
  }
  throw PortError(fmt::format("{}: cannot listen there: {}{}", host_and_port(address, port), fault.message(),
                              fault == asio::error::address_in_use
                                  ? "; choose another port with --port, or let --port 0 find a free one"
                                  : ""));
}

}  // namespace

struct WindowServer::Impl {
  Impl(const ServerSettings& settings, Receive receive);
  ~Impl();

  void accept();
  void run();
  template <class Change>
  void tell(const Change& change);

  Hub hub;
  Site site;
  // Gone first: what waits in it uses the above.
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer rest;
  std::thread thread;
};

WindowServer::Impl::Impl(const ServerSettings& settings, Receive receive)
    : acceptor(listen(io, settings.address, settings.port)), rest(io) {
  hub.receive = std::move(receive);
  hub.patience = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * settings.patience_s));
  site.page = read_page(settings.page, !settings.recording.empty());
  site.recording = settings.recording;
  if (!site.recording.empty() && !std::filesystem::is_regular_file(site.recording)) {
    throw thenar::FileError(site.recording, "is no file that can be served");
  }
  site.listening = {settings.address, acceptor.local_endpoint().port(),
                    settings.token.empty() ? random_token() : settings.token, settings.also};
  accept();
  // Signals are for the thread that waits for them.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(thread.native_handle(), "thenar-server");
}

WindowServer::Impl::~Impl() {
  io.stop();
  thread.join();
}

/// Until stop(). A handler that fails, as for want of memory, takes its own connection with it and no other.
void WindowServer::Impl::run() {
  while (!io.stopped()) {
    try {
      io.run();
    } catch (const std::exception&) {
    }
  }
}

void WindowServer::Impl::accept() {
  acceptor.async_accept([this](error_code fault, tcp::socket socket) {
    if (fault == asio::error::operation_aborted) return;
    if (fault) {  // No more files may be open, say: others may close some.
      rest.expires_after(kRest);
      rest.async_wait([this](error_code) { accept(); });
      return;
    }
    accept();
    // The one that has taken longest gives way: who says nothing keeps nobody out.
    if (hub.strangers.size() >= kMaxStrangers) {
      hub.strangers.front()->close();
      hub.strangers.erase(hub.strangers.begin());
    }
    close_on_exec(socket);
    error_code none;  // A socket that takes no option fails soon enough.
    socket.set_option(tcp::no_delay(true), none);
    socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), none);
    serve(Stream(std::move(socket)), site, hub);
  });
}

/// Changes the news, and has the server's thread look at them: once, however often they change until then.
template <class Change>
void WindowServer::Impl::tell(const Change& change) {
  {
    const std::lock_guard lock(hub.mutex);
    change(hub.news);
    if (!std::exchange(hub.told, false)) return;
  }
  asio::post(io, [this] {
    {
      const std::lock_guard lock(hub.mutex);
      hub.told = true;
    }
    for (PageLink* const link : hub.links) link->pump();
  });
}

WindowServer::WindowServer(const ServerSettings& settings, Receive receive) try
    : impl_(std::make_unique<Impl>(settings, std::move(receive))) {
} catch (const boost::system::system_error& error) {  // As where no more files may be open.
  throw PortError("no page can be served: " + error.code().message());
} catch (const std::system_error& error) {
  throw PortError("no page can be served: " + error.code().message());
}
WindowServer::~WindowServer() = default;

std::string WindowServer::url() const {
  const Listening& place = impl_->site.listening;
  const asio::ip::address address = asio::ip::make_address(place.address);
  const std::string reached = !address.is_unspecified() ? place.address : address.is_v6() ? "::1" : "127.0.0.1";
  return fmt::format("http://{}/?token={}", host_and_port(reached, place.port), place.token);
}

namespace {

void replace(Shown& shown, std::string bytes) {
  shown = {std::make_shared<const std::string>(std::move(bytes)), shown.number + 1};
}

}  // namespace

void WindowServer::set_scene(std::string scene, std::string geometry) {
  impl_->tell([&](News& news) {
    replace(news.scene, std::move(scene));
    replace(news.geometry, std::move(geometry));
    // A state of the scene before does not fit this one: pages get none until there is a new one.
    news.state.bytes = nullptr;
  });
}

void WindowServer::set_status(std::string status) {
  impl_->tell([&](News& news) { replace(news.status, std::move(status)); });
}

void WindowServer::set_grasps(std::string grasps) {
  impl_->tell([&](News& news) { replace(news.grasps, std::move(grasps)); });
}

void WindowServer::show(std::string state) {
  impl_->tell([&](News& news) { replace(news.state, std::move(state)); });
}

int WindowServer::pages() const { return impl_->hub.pages; }

}  // namespace thenar::window
