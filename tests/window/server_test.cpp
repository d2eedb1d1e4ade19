// SPDX-License-Identifier: Apache-2.0
// The server as pages meet it, also those that mean it ill. Clients are real ones, over the loopback.

#include "app/window/server.h"

#include <gtest/gtest.h>

#include <boost/asio/read.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>

#include "tests/window/server_clients.h"

namespace thenar::window::server_test {
namespace {

using namespace server_clients;

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
  server_->set_grasps("grasps");
  server_->show("state");
  EXPECT_EQ(page.read(), "scene");
  EXPECT_TRUE(page.text);
  EXPECT_EQ(page.read(), "geometry");
  EXPECT_FALSE(page.text);
  EXPECT_EQ(page.read(), "status");
  EXPECT_EQ(page.read(), "grasps");
  EXPECT_TRUE(page.text);
  EXPECT_EQ(page.read(), "state");
  // What comes later finds all of it.
  Page later(port_, token_);
  EXPECT_EQ(later.read(), "scene");
  EXPECT_EQ(later.read(), "geometry");
  EXPECT_EQ(later.read(), "status");
  EXPECT_EQ(later.read(), "grasps");
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
