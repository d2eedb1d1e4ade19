// The server as pages meet it, also those that mean it ill. Clients are real ones, over the loopback.

#include "app/window/server.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "app/window/admission.h"
#include "engine/formats/files.h"
#include "tests/support/scratch.h"

namespace thenar::window::server_test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;

constexpr const char* kPage =
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
std::string upgrade(const std::string& target, const std::string& host, const std::string& origin) {
  return "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" +
         (origin.empty() ? "" : "Origin: " + origin + "\r\n") +
         "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
}

int status(const std::string& answer) { return answer.size() < 12 ? 0 : std::stoi(answer.substr(9, 3)); }
std::string body(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }

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

/// Of this process's memory.
std::int64_t resident_bytes() {
  std::int64_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

TEST_F(Server, ServesThePageWithItsOwnScriptsAlone) {
  start();
  const std::string answer = get("/");
  ASSERT_EQ(status(answer), 200) << answer;
  const std::string header = answer.substr(0, answer.find("\r\n\r\n"));
  EXPECT_NE(header.find("Cache-Control: no-store"), std::string::npos);
  EXPECT_NE(header.find("Referrer-Policy: no-referrer"), std::string::npos);
  const std::size_t begin = header.find("'nonce-") + 7;
  const std::string nonce = header.substr(begin, header.find('\'', begin) - begin);
  EXPECT_EQ(nonce.size(), 32U);
  EXPECT_NE(header.find("Content-Security-Policy: default-src 'none'; script-src 'nonce-"), std::string::npos);
  // What looks like a tag inside a script is left alone.
  EXPECT_EQ(body(answer),
            "<!doctype html><html data-source=\"live\"><style>p{}</style><!-- recording --><script nonce=\"" + nonce +
                "\">'<script>'</script><script nonce=\"" + nonce + "\" type=\"module\">1</script></html>");
  EXPECT_EQ(status(get("/?x=1")), 200);
  EXPECT_EQ(status(get("/recording")), 404);
}

TEST_F(Server, ServesARecording) {
  std::string bytes(3'000'000, '\0');
  std::mt19937 random(1);
  for (char& byte : bytes) byte = static_cast<char>(random());
  thenar::write_file(folder_ / "out.mcap", bytes);
  settings_.recording = folder_ / "out.mcap";
  start();
  EXPECT_TRUE(body(get("/recording")) == bytes);
  EXPECT_NE(get("/").find("<html data-source=\"recording\">"), std::string::npos);
  EXPECT_EQ(upgraded(live()), 404) << "nothing is live";
  // One that stops reading it holds up nobody.
  Raw stuck(port_);
  stuck.send("GET " + with_token("/recording") + " HTTP/1.1\r\n" + host() + "\r\n");
  EXPECT_TRUE(body(get("/recording")) == bytes);
}

TEST_F(Server, WantsItsFiles) {
  settings_.page = folder_ / "none.html";
  EXPECT_THROW(start(), thenar::FileError);
  thenar::write_file(folder_ / "page.html", "<html></html>");
  settings_.page = folder_ / "page.html";
  EXPECT_THROW(start(), thenar::FileError);
  thenar::write_file(folder_ / "page.html", kPage);
  settings_.recording = folder_ / "none.mcap";
  EXPECT_THROW(start(), thenar::FileError);
}

TEST_F(Server, AnswersNothingElse) {
  start();
  EXPECT_EQ(status(get("/page.html")), 404);
  EXPECT_EQ(status(get("/../../etc/passwd")), 404);
  EXPECT_EQ(status(get("//")), 404);
  EXPECT_EQ(status(get("http://127.0.0.1:" + std::to_string(port_) + "/")), 404);
  EXPECT_EQ(status(answer("POST / HTTP/1.1\r\n" + host() + "Content-Length: 2\r\n\r\n{}")), 413);
  EXPECT_EQ(status(answer("POST / HTTP/1.1\r\n" + host() + "\r\n")), 405);
  EXPECT_EQ(status(answer("GET / HTTP/1.1\r\n" + host() + "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n")), 413);
  EXPECT_EQ(status(answer("GET / HTTP/1.1\r\n" + host() + "Content-Length: 99999999999\r\n\r\n")), 413);
  EXPECT_EQ(status(get("/", "X: " + std::string(9000, 'x') + "\r\n")), 431);
  EXPECT_EQ(status(get("/" + std::string(9000, 'x'))), 431);
  EXPECT_EQ(status(answer("\x16\x03\x01 a TLS client hello\r\n\r\n")), 400);
  EXPECT_EQ(status(get("/live", "Origin: http://" + here() + "\r\n")), 426);
  EXPECT_EQ(upgraded(with_token("/")), 200) << "the page, and no WebSocket";
  EXPECT_EQ(upgraded("/other"), 404);
  EXPECT_EQ(status(get("/")), 200) << "and goes on";
}

TEST_F(Server, RefusesAForeignHost) {
  start();
  const std::string port = ":" + std::to_string(port_);
  for (const std::string& ours : {"127.0.0.1" + port, "localhost" + port, "LOCALHOST" + port, "[::1]" + port}) {
    EXPECT_EQ(status(answer("GET " + with_token("/") + " HTTP/1.1\r\nHost: " + ours + "\r\n\r\n")), 200) << ours;
    EXPECT_EQ(upgraded(live(), ours, "http://" + ours), 101) << ours;
  }
  const std::string other_port = ":" + std::to_string(port_ ^ 1);
  for (const std::string& theirs :
       {"example.org" + port, "localhost.example.org" + port, "127.0.0.1" + other_port, std::string("127.0.0.1"),
        std::string("localhost:"), "localhost" + port + "x", "192.168.0.1" + port, "::1" + port, std::string("::1"),
        "127.1" + port, "[127.0.0.1]" + port, "user@127.0.0.1" + port, std::string("[]"), std::string("[") + port,
        std::string()}) {
    EXPECT_EQ(status(answer("GET " + with_token("/") + " HTTP/1.1\r\nHost: " + theirs + "\r\n\r\n")), 403) << theirs;
  }
  EXPECT_EQ(status(answer("GET " + with_token("/") + " HTTP/1.1\r\n\r\n")), 403);
  EXPECT_EQ(status(get("/", "Host: example.org\r\n")), 403) << "two of them";
}

TEST_F(Server, RefusesAForeignOrigin) {
  start();
  for (const std::string& theirs : {std::string("http://example.org"), std::string("null"), "https://" + here(),
                                    "http://localhost:" + std::to_string(port_), "http://" + here() + "/",
                                    std::string("http://127.0.0.1"), std::string("file://")}) {
    EXPECT_EQ(upgraded(live(), here(), theirs), 403) << theirs;
    EXPECT_EQ(status(get("/", "Origin: " + theirs + "\r\n")), 403) << theirs;
  }
  EXPECT_EQ(status(get("/", "Origin: http://" + here() + "\r\nOrigin: http://" + here() + "\r\n")), 403);
  EXPECT_EQ(status(get("/", "Origin: http://" + here() + "\r\n")), 200);
}

// On loopback, too: every user of the machine reaches that.
TEST_F(Server, AsksForItsToken) {
  thenar::write_file(folder_ / "out.mcap", "private");
  start();
  EXPECT_TRUE(server_->url().ends_with("/?token=" + token_));
  const std::string right = "?token=" + token_;
  std::string last_off = right, longer = right + "0";
  last_off.back() = last_off.back() == '0' ? '1' : '0';
  EXPECT_EQ(status(get_as_it_is("/" + right)), 200);
  EXPECT_EQ(status(get_as_it_is("/?a=b&token=" + token_ + "&c")), 200);
  EXPECT_EQ(upgraded("/live" + right), 101);
  EXPECT_EQ(upgraded("/live" + right, here(), ""), 101) << "a program that is no browser";
  EXPECT_EQ(upgraded("/live" + right, here(), "http://example.org"), 403);
  const std::string wrong_ones[] = {"",
                                    "?token=",
                                    last_off,
                                    longer,
                                    "?xtoken=" + token_,
                                    right.substr(0, right.size() - 1),
                                    "?token=" + token_ + "#"};
  for (const std::string& wrong : wrong_ones) {
    EXPECT_EQ(status(get_as_it_is("/" + wrong)), 403) << wrong;
    EXPECT_EQ(upgraded("/live" + wrong), 403) << wrong;
  }
  settings_.recording = folder_ / "out.mcap";
  const std::string before = token_;
  start();
  EXPECT_NE(token_, before) << "each server has another";
  for (const std::string& wrong : wrong_ones) EXPECT_EQ(status(get_as_it_is("/recording" + wrong)), 403) << wrong;
  EXPECT_EQ(body(get("/recording")), "private");
}

// 16 bytes, of which none is alike in all of them but with a chance of 2^-500.
TEST(Admission, TokensAreRandom) {
  std::set<std::string> tokens;
  std::array<std::set<std::string>, 16> bytes;
  for (int i = 0; i < 64; ++i) {
    const std::string token = random_token();
    ASSERT_EQ(token.size(), 32U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), token.npos) << token;
    tokens.insert(token);
    for (std::size_t k = 0; k < 16; ++k) bytes[k].insert(token.substr(2 * k, 2));
  }
  EXPECT_EQ(tokens.size(), 64U);
  for (const auto& values : bytes) EXPECT_GT(values.size(), 1U);
}

TEST_F(Server, IsReachedByOthersByANumericAddress) {
  settings_.address = "0.0.0.0";
  start();
  EXPECT_TRUE(server_->url().starts_with("http://127.0.0.1:")) << "nobody can open 0.0.0.0";
  const std::string port = ":" + std::to_string(port_), request = "GET " + with_token("/") + " HTTP/1.1\r\nHost: ";
  EXPECT_EQ(status(answer(request + "192.168.7.7" + port + "\r\n\r\n")), 200) << "it may be one of this machine's";
  EXPECT_EQ(status(answer(request + "example.org" + port + "\r\n\r\n")), 403) << "a name may lead anybody here";
}

TEST(Admission, KnowsItsNames) {
  const auto refused = [](const char* address, const char* token, std::string_view host) {
    return !refuse({.host = host, .origin = {}, .target = "/?token=t"}, {address, 8470, token}).empty();
  };
  EXPECT_FALSE(refused("10.0.0.5", "t", "10.0.0.5:8470"));
  EXPECT_TRUE(refused("10.0.0.5", "t", "localhost:8470"));
  EXPECT_TRUE(refused("10.0.0.5", "t", "127.0.0.1:8470"));
  EXPECT_TRUE(refused("10.0.0.5", "t", "10.0.0.6:8470"));
  EXPECT_TRUE(refused("10.0.0.5", "u", "10.0.0.5:8470"));
  EXPECT_FALSE(refused("::1", "t", "[::1]:8470"));
  EXPECT_FALSE(refused("::1", "t", "[0:0::1]:8470"));
  EXPECT_TRUE(refused("::1", "t", "[::2]:8470"));
  EXPECT_TRUE(refused("::1", "", "[::1]:8470")) << "an empty token is nobody's";
  EXPECT_FALSE(refused("fe80::1", "t", "[fe80::1]:8470"));
  EXPECT_EQ(reach_of("127.0.0.1"), Reach::kThisMachine);
  EXPECT_EQ(reach_of("::1"), Reach::kThisMachine);
  EXPECT_EQ(reach_of("0.0.0.0"), Reach::kOthers);
  EXPECT_EQ(reach_of("::"), Reach::kOthers);
  EXPECT_EQ(reach_of("localhost"), Reach::kNoAddress);
  EXPECT_EQ(reach_of(""), Reach::kNoAddress);
  EXPECT_EQ(reach_of("fe80::1%eth0"), Reach::kNoAddress) << "no URL has one";
  EXPECT_EQ(reach_of("::1%';touch /tmp/x;'"), Reach::kNoAddress);
  EXPECT_EQ(host_and_port("::1", 80), "[::1]:80");
}

TEST_F(Server, SaysWhyItCannotListen) {
  start();
  const auto error_of = [](const ServerSettings& settings) -> std::string {
    try {
      const WindowServer server(settings, [](const Message&) { return ""; });
    } catch (const PortError& error) {
      return error.what();
    }
    return "";
  };
  ServerSettings taken = settings_;
  taken.port = port_;
  const std::string error = error_of(taken);
  EXPECT_NE(error.find("127.0.0.1:" + std::to_string(port_)), std::string::npos) << error;
  EXPECT_NE(error.find("--port"), std::string::npos) << error;
  taken.address = "localhost";
  EXPECT_NE(error_of(taken).find("no numeric address"), std::string::npos);
  taken.address = "192.0.2.1";  // Kept for documentation: nobody has it.
  EXPECT_NE(error_of(taken).find("192.0.2.1"), std::string::npos);
  // The port is free again at once.
  server_.reset();
  taken = settings_;
  taken.port = port_;
  EXPECT_EQ(error_of(taken), "");
}

TEST_F(Server, ShowsTheSceneBeforeItsStates) {
  start();
  Page page(port_, token_);
  page.ask();
  server_->show("too early");  // A state of which nobody could know what it holds.
  server_->set_scene("scene", "geometry");
  server_->set_status("status");
  server_->show("state");
  EXPECT_EQ(page.read(), "scene");
  EXPECT_TRUE(page.text);
  EXPECT_EQ(page.read(), "geometry");
  EXPECT_FALSE(page.text);
  EXPECT_EQ(page.read(), "status");
  EXPECT_EQ(page.read(), "state");
  // What comes later finds all of it.
  Page later(port_, token_);
  EXPECT_EQ(later.read(), "scene");
  EXPECT_EQ(later.read(), "geometry");
  EXPECT_EQ(later.read(), "status");
  later.ask();
  EXPECT_EQ(later.read(), "state");
}

TEST_F(Server, ShowsAChangedSceneBeforeAnyOfItsStates) {
  start();
  server_->set_scene("scene", "geometry");
  server_->show("old state");
  const auto page = this->page();
  server_->set_scene("scene 2", "geometry 2");
  EXPECT_EQ(page->read(), "scene 2");
  EXPECT_EQ(page->read(), "geometry 2");
  page->ask();  // The old state would come between these answers.
  for (int i = 0; i < 3; ++i) {
    page->send(R"({"type":"ping","t":0})");
    EXPECT_EQ(json::parse(page->read()).at("type"), "pong");
  }
  server_->show("new state");
  EXPECT_EQ(page->read(), "new state");
}

TEST_F(Server, ShowsTheNewestStateToThoseThatAsk) {
  start();
  server_->set_scene("scene", "geometry");
  const auto page = this->page();
  for (int i = 1; i <= 100; ++i) server_->show(std::to_string(i));
  page->ask();
  EXPECT_EQ(page->read(), "100");
  page->ask();  // There is none that is newer: it gets the next one, once.
  page->ask();
  page->send(R"({"type":"ping","t":7})");
  EXPECT_EQ(json::parse(page->read()).at("type"), "pong");
  server_->show("101");
  EXPECT_EQ(page->read(), "101");
  server_->show("102");
  page->send(R"({"type":"ping","t":8})");
  EXPECT_EQ(json::parse(page->read()).at("type"), "pong") << "nobody asked for 102";
}

TEST_F(Server, SendsAtMostSixtyStatesASecond) {
  start();
  server_->set_scene("scene", "geometry");
  const auto page = this->page();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i <= 12; ++i) {
    server_->show(std::to_string(i));
    page->ask();
    EXPECT_EQ(page->read(), std::to_string(i));
  }
  // 12 periods of 1/60 s lie between the first one and the last one.
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(200));
}

TEST_F(Server, AnswersPingsAndSaysWhyItRefuses) {
  start();
  Page page(port_, token_);
  page.send(R"({"type":"ping","t":-1.25})");
  const json pong = json::parse(page.read());
  EXPECT_EQ(pong.at("t"), -1.25);
  EXPECT_GT(pong.at("now_s").get<double>(), 0.0);
  page.send(R"({"type":"poke","force_N":[0,0,1e9]})");
  EXPECT_EQ(page.refusal(), "force_N must lie within -5 .. 5");
  page.send(R"({"type":"step"})");
  EXPECT_EQ(page.refusal(), "it is running") << "the session's own reason";
  page.send(R"({"type":"reset"})");
  EXPECT_EQ(page.refusal(), "internal error: no reset today") << "what the session throws ends nothing";
  page.socket.binary(true);
  page.socket.write(asio::buffer(std::string(R"({"type":"pause"})")), page.fault);
  EXPECT_EQ(page.refusal(), "a message is text");
  page.send(R"({"type":"pause"})");
  await([&] { return received() == 3; });
  EXPECT_TRUE(std::holds_alternative<Pause>(received_.back()));
}

TEST_F(Server, EndsWhatIsTooMuch) {
  start();
  Page large(port_, token_);
  large.send(std::string(4097, ' '));
  EXPECT_EQ(large.end().code, websocket::close_code::too_big);
  EXPECT_EQ(large.end().reason, "a message has at most 4096 bytes");

  Page pieces(port_, token_);  // A message without an end.
  pieces.socket.text(true);
  for (int i = 0; i < 5000; ++i) pieces.socket.write_some(false, asio::buffer(std::string(16, ' ')), pieces.fault);
  pieces.fault = {};
  const auto reason = pieces.end().code;
  EXPECT_TRUE(reason == websocket::close_code::too_big || reason == websocket::close_code::policy_error) << reason;

  Page fast(port_, token_);
  for (int i = 0; i < 5000 && fast.send(R"({"type":"release"})"); ++i) continue;
  fast.fault = {};
  EXPECT_EQ(fast.end().code, websocket::close_code::policy_error);

  Page pings(port_, token_);
  for (int i = 0; i < 5000 && !pings.fault; ++i) pings.socket.ping({}, pings.fault);
  await([&] { return server_->pages() == 0; });

  Page text(port_, token_);
  text.send("\xff\xfe");
  EXPECT_EQ(text.end().code, websocket::close_code::bad_payload);
  EXPECT_LE(received(), 400U);
  EXPECT_EQ(status(get("/")), 200) << "and goes on";
}

TEST_F(Server, SurvivesGarbageAndBrokenConnections) {
  start();
  server_->set_scene("scene", "geometry");
  server_->show("state");
  const auto good = page();
  std::mt19937 random(2);
  for (int i = 0; i < 60; ++i) {
    Raw raw(port_);
    if (i % 2 == 0) {
      ASSERT_TRUE(raw.send(upgrade(live(), here(), "http://" + here())));
      char begin[12];
      asio::read(raw.socket, asio::buffer(begin));
      ASSERT_EQ(std::string(begin, 12), "HTTP/1.1 101");
    }
    std::string bytes(random() % 2000, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    raw.send(bytes);
    if (i % 3 == 0) raw.socket.set_option(asio::socket_base::linger(true, 0));  // It goes with a reset.
  }
  for (int i = 0; i < 10; ++i) {  // In the middle of a message.
    Page page(port_, token_);
    page.socket.write_some(false, asio::buffer(std::string("{\"type\":")), page.fault);
    page.socket.next_layer().close();
  }
  for (int i = 0; i < 10; ++i) {  // In the middle of a frame, and of a request.
    Raw raw(port_);
    raw.send(upgrade(live(), here(), "http://" + here()) + "\x81\xfe\x01");
    Raw header(port_);
    header.send("GET / HTTP/1.1\r\nHo");
  }
  good->ask();
  EXPECT_EQ(good->read(), "state");
  await([&] { return server_->pages() == 1; });
  EXPECT_EQ(received(), 0U);
}

TEST_F(Server, DropsAHeaderThatNeverEnds) {
  settings_.patience_s = 0.2;
  start();
  Raw raw(port_);
  raw.send("GET / HTTP/1.1\r\nX: ");
  // However it goes on, a byte at a time: the patience is for all of it.
  while (raw.send("x")) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  Raw silent(port_);
  EXPECT_EQ(silent.rest(), "");
}

// Forty who say nothing, and come again and again, do not keep the owner out: the oldest of them give way.
TEST_F(Server, SilentStrangersKeepNobodyOut) {
  settings_.patience_s = 100.0;  // Nobody is dropped for being slow.
  start();
  std::deque<Raw> idle;
  for (int i = 0; i < 40; ++i) idle.emplace_back(port_);
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(status(get("/")), 200) << i;
    idle.emplace_back(port_);
  }
  // One that began its request and was not pushed out ends it.
  const auto slow = std::make_unique<Raw>(port_);
  slow->send("GET " + with_token("/") + " HTTP/1.1\r\n");
  for (int i = 0; i < 20; ++i) idle.emplace_back(port_);
  slow->send(host() + "\r\n");
  EXPECT_EQ(status(slow->rest()), 200);
  EXPECT_EQ(idle.front().rest(), "") << "ended";
  // Those whom it refuses are strangers, too, though they stay after that.
  std::deque<Raw> refused;
  for (int i = 0; i < 40; ++i) {
    refused.emplace_back(port_);
    refused.back().send("GET / HTTP/1.1\r\n" + host() + "\r\n");
  }
  EXPECT_EQ(status(get("/")), 200);
}

TEST_F(Server, ServesOnlySoManyPagesAtOnce) {
  settings_.patience_s = 100.0;
  start();
  std::deque<Raw> pages;
  const auto open = [&] {
    pages.emplace_back(port_);
    pages.back().send(upgrade(live(), here(), "http://" + here()));
    std::string begin(12, ' ');
    asio::read(pages.back().socket, asio::buffer(begin));
    return status(begin);
  };
  for (int i = 0; i < 32; ++i) ASSERT_EQ(open(), 101) << i;
  EXPECT_EQ(open(), 503) << "the 33rd is told";
  pages.pop_front();
  await([&] { return open() == 101; });
  // Two hundred more that come and go at once.
  pages.clear();
  for (int i = 0; i < 200; ++i) Raw raw(port_);
  await([&] { return status(get("/")) == 200; });
}

// A WebSocket takes empty pieces of a message without a word. A page that sends nothing else ends, or it would cost a
// core.
TEST_F(Server, EndsAMessageOfEmptyPieces) {
  settings_.patience_s = 100.0;
  start();
  Page page(port_, token_);
  page.socket.text(true);
  page.socket.write_some(false, asio::buffer(std::string("{")), page.fault);
  const std::string empty_piece("\x00\x80\x01\x02\x03\x04", 6);
  std::string many;
  for (int i = 0; i < 1000; ++i) many += empty_piece;
  std::int64_t sent = 0;
  for (error_code fault; !fault && sent < 30'000'000; sent += 1000) {
    asio::write(page.socket.next_layer(), asio::buffer(many), fault);
  }
  // 64 kB are 11 000 of them; the rest is what the system holds on its way, some MB.
  EXPECT_LT(sent, 3'000'000);
  await([&] { return server_->pages() == 0; });
  EXPECT_EQ(status(get("/")), 200) << "and goes on";

  // Pieces with something in them are as good as one.
  Page good(port_, token_);
  good.socket.text(true);
  const std::string message = R"({"type":"pause"})";
  for (std::size_t i = 0; i < message.size(); ++i) {
    good.socket.write_some(i + 1 == message.size(), asio::buffer(message.substr(i, 1)), good.fault);
  }
  await([&] { return received() == 1; });
}

// One page asks and asks, but does not read. It holds one state up, and no more of them; the nine others are shown the
// newest.
TEST_F(Server, APageThatStopsReadingCostsNothing) {
  settings_.patience_s = 100.0;
  start();
  server_->set_scene("scene", "geometry");
  const auto stuck = page();
  std::vector<std::unique_ptr<Page>> others;
  for (int i = 0; i < 9; ++i) others.push_back(page());
  EXPECT_EQ(server_->pages(), 10);
  const std::int64_t before = resident_bytes();
  const std::string large(16 << 20, 'x');  // More than the system takes for a page.
  for (int i = 0; i < 100; ++i) {
    server_->show(large + std::to_string(i));
    if (i % 20 == 0) stuck->ask();
  }
  // 1.6 GB were shown. The server has the newest, and one on its way; the rest is room for what sanitizers keep.
  EXPECT_LT(resident_bytes() - before, 400'000'000);
  for (const auto& other : others) {
    other->ask();
    EXPECT_TRUE(other->read() == large + "99");
  }
  EXPECT_EQ(server_->pages(), 10);
}

TEST_F(Server, DropsAPageThatDoesNotTakeWhatItAskedFor) {
  settings_.patience_s = 0.3;
  start();
  server_->set_scene("scene", std::string(16 << 20, 'g'));
  Page page(port_, token_);
  // Its signs of life do not help it.
  while (page.send(R"({"type":"release"})")) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  await([&] { return server_->pages() == 0; });
}

TEST_F(Server, PingsThoseThatAreSilent) {
  settings_.patience_s = 2.0;  // A page that reads has half of it to answer a ping.
  start();
  server_->set_scene("scene", "geometry");
  const auto reader = page();
  const auto silent = page();
  reader->socket.control_callback([&](websocket::frame_type, beast::string_view) {
    if (server_->pages() == 1) server_->set_status("the silent one is gone");
  });
  EXPECT_EQ(reader->read(), "the silent one is gone");
}

TEST_F(Server, EndsAtOnceWhateverPagesDo) {
  settings_.patience_s = 100.0;
  start();
  server_->set_scene("scene", std::string(64 << 20, 'g'));
  Page stuck(port_, token_);
  Page reading(port_, token_);
  EXPECT_EQ(reading.read(), "scene");
  Raw half(port_);
  half.send("GET / HT");
  server_.reset();
  EXPECT_NE(reading.end().code, websocket::close_code::normal);
}

// For ThreadSanitizer: the calling thread shows, and pages come, ask and go.
TEST_F(Server, SharesWithoutARace) {
  start();
  server_->set_scene("scene", "geometry");
  std::atomic<bool> done = false;
  std::thread pages([&] {
    for (int i = 0; i < 20; ++i) {
      const auto page = this->page();
      page->ask();
      while (page->read() == "status") continue;
    }
    done = true;
  });
  for (int i = 0; !done; ++i) {
    server_->show("state " + std::to_string(i));
    if (i % 100 == 0) server_->set_status("status");
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
  pages.join();
}

}  // namespace
}  // namespace thenar::window::server_test
