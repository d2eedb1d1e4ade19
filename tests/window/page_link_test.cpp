// SPDX-License-Identifier: Apache-2.0
#include "app/window/page_link.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/write.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/window/server_clients.h"

namespace thenar::window::page_link_test {
namespace {

using namespace server_clients;

/// Of this process's memory.
std::int64_t resident_bytes() {
  std::int64_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE);
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
  EXPECT_EQ(page.refusal(), "force_N must not be longer than 5 N");
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

}  // namespace
}  // namespace thenar::window::page_link_test
