// SPDX-License-Identifier: Apache-2.0
#include "app/window/http_exchange.h"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <random>
#include <string>
#include <thread>

#include "engine/formats/files.h"
#include "tests/window/server_clients.h"

namespace thenar::window::http_exchange_test {
namespace {

using namespace server_clients;

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

}  // namespace
}  // namespace thenar::window::http_exchange_test
