// SPDX-License-Identifier: Apache-2.0
#include "app/window/http_exchange.h"

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "app/window/page_link.h"

namespace thenar::window {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;

constexpr std::uint32_t kMaxHeader = 8 * 1024;
constexpr int kMaxGuests = 32;
constexpr const char* kNoBody = "A request has no body.";

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

/// The field, where it is there once: of two, one may be meant for somebody else.
std::optional<std::string_view> only(const PageLink::Request& request, http::field field) {
  if (request.count(field) != 1) return std::nullopt;
  return view(request[field]);
}

/// One request and its answer. It keeps itself alive until then.
class HttpExchange : public std::enable_shared_from_this<HttpExchange> {
 public:
  HttpExchange(Stream stream, const Site& site, Hub& hub) : site_(site), hub_(hub), stream_(std::move(stream)) {
    hub_.strangers.push_back(&stream_);
    parser_.header_limit(kMaxHeader);
    parser_.body_limit(std::uint64_t{0});
  }
  ~HttpExchange() { std::erase(hub_.strangers, &stream_); }
  HttpExchange(const HttpExchange&) = delete;
  HttpExchange& operator=(const HttpExchange&) = delete;

  void read() {
    stream_.expires_after(hub_.patience);
    http::async_read_header(stream_, buffer_, parser_, [self = shared_from_this()](error_code fault, std::size_t) {
      if (!fault) return self->answer();
      // Of a request that never ends nobody waits for an answer.
      if (fault.category() != make_error_code(http::error::bad_method).category()) return;
      if (fault == http::error::end_of_stream || fault == http::error::partial_message) return;
      if (fault == http::error::body_limit) return self->refuse(http::status::payload_too_large, kNoBody);
      if (fault != http::error::header_limit)
        return self->refuse(http::status::bad_request, "This is no HTTP request.");
      self->refuse(http::status::request_header_fields_too_large, "A request has at most 8 kB.");
    });
  }

 private:
  void answer() {
    const PageLink::Request& request = parser_.get();
    const std::string_view target = view(request.target());
    const std::string_view path = target.substr(0, target.find('?'));
    if (request.method() != http::verb::get)
      return refuse(http::status::method_not_allowed, "There is nothing but GET.");
    if (!parser_.is_done()) return refuse(http::status::payload_too_large, kNoBody);
    const bool live = site_.recording.empty();
    if (path != "/" && path != (live ? "/live" : "/recording"))
      return refuse(http::status::not_found, "There is nothing here.");

    const Asker asker{only(request, http::field::host), only(request, http::field::origin), target};
    if (request.count(http::field::origin) > 1) return refuse(http::status::forbidden, "There are two Origins.");
    const std::string why = window::refuse(asker, site_.listening);
    if (!why.empty()) return refuse(http::status::forbidden, why);
    if (hub_.guests >= kMaxGuests) {
      return refuse(http::status::service_unavailable, "There are 32 pages already: close one.");
    }
    std::erase(hub_.strangers, &stream_);
    seat_ = std::make_unique<Seat>(hub_);
    if (path == "/") return send_page();
    if (path == "/recording") return send_recording();
    if (!beast::websocket::is_upgrade(request)) return refuse(http::status::upgrade_required, "This is a WebSocket.");
    std::make_shared<PageLink>(std::move(stream_), std::move(seat_), hub_)->start(request);
  }

  void refuse(http::status status, std::string why) {
    http::response<http::string_body> response(status, 11);
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    if (status == http::status::upgrade_required) response.set(http::field::upgrade, "websocket");
    if (status == http::status::method_not_allowed) response.set(http::field::allow, "GET");
    response.body() = std::move(why) + "\n";
    send(std::move(response));
  }

  void send_page() {
    http::response<http::span_body<const char>> response(http::status::ok, 11);
    response.set(http::field::content_type, "text/html; charset=utf-8");
    response.set("Content-Security-Policy", site_.page.content_security_policy);
    response.body() = {site_.page.html.data(), site_.page.html.size()};
    send(std::move(response));
  }

  void send_recording() {
    http::response<http::file_body> response(http::status::ok, 11);
    response.set(http::field::content_type, "application/octet-stream");
    error_code fault;
    response.body().open(site_.recording.c_str(), beast::file_mode::scan, fault);
    if (fault) return refuse(http::status::internal_server_error, "The recording cannot be read any more.");
    send(std::move(response));
  }

  /// Answers, and ends the connection: pages ask for little, and not often.
  template <class Body>
  void send(http::response<Body>&& answer) {
    answer.set(http::field::cache_control, "no-store");
    answer.set("Referrer-Policy", "no-referrer");  // A token is in the page's address.
    answer.set("X-Content-Type-Options", "nosniff");
    answer.set("Cross-Origin-Resource-Policy", "same-origin");
    answer.keep_alive(false);
    answer.prepare_payload();
    struct Answer {
      explicit Answer(http::response<Body>&& given) : response(std::move(given)), serializer(response) {}
      http::response<Body> response;
      http::response_serializer<Body> serializer;
    };
    send_piece(std::make_shared<Answer>(std::move(answer)));
  }

  template <class Answer>
  void send_piece(const std::shared_ptr<Answer>& answer) {
    stream_.expires_after(hub_.patience);
    http::async_write_some(stream_, answer->serializer,
                           [self = shared_from_this(), answer](error_code fault, std::size_t) {
                             if (!fault && !answer->serializer.is_done()) return self->send_piece(answer);
                             if (!fault) self->end();
                           });
  }

  /// Waits until the other side has taken the answer and ends, too: what it had sent and nobody read would else take
  /// the answer away from it.
  void end() {
    error_code none;
    stream_.socket().shutdown(boost::asio::socket_base::shutdown_send, none);
    stream_.expires_after(hub_.patience);
    drain();
  }
  void drain() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(kMaxHeader), [self = shared_from_this()](error_code fault, std::size_t) {
      if (!fault) self->drain();
    });
  }

  const Site& site_;
  Hub& hub_;
  std::unique_ptr<Seat> seat_;  ///< From when it has shown that it may ask.
  Stream stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
};

}  // namespace

void serve(Stream stream, const Site& site, Hub& hub) {
  std::make_shared<HttpExchange>(std::move(stream), site, hub)->read();
}

}  // namespace thenar::window
