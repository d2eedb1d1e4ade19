// SPDX-License-Identifier: Apache-2.0
#include "app/window/admission.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>

#include "engine/formats/files.h"
#include "tests/window/server_clients.h"

namespace thenar::window::admission_test {
namespace {

using namespace server_clients;

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
        std::string(), "[::1%lo]" + port, "[::1%25x]" + port, "127.0.0.1:0" + port.substr(1),
        "127.0.0.1:+" + port.substr(1)}) {
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

// A tunnel whose near end has another port, or a name; a server before this one that encrypts.
TEST_F(Server, IsReachedByTheNamesThatItIsGiven) {
  settings_.also = {{"localhost", 9000}, {"grasp.example.org", std::nullopt}};
  start();
  const auto page = [&](const std::string& host, const std::string& origin) { return upgraded(live(), host, origin); };
  EXPECT_EQ(page("localhost:9000", "http://localhost:9000"), 101);
  EXPECT_EQ(page("Grasp.Example.org", "https://grasp.example.org"), 101);
  EXPECT_EQ(page("grasp.example.org:8443", "https://grasp.example.org:8443"), 101);
  EXPECT_EQ(page(here(), "http://" + here()), 101) << "its own name stays";
  EXPECT_EQ(page("localhost:9001", "http://localhost:9001"), 403);
  EXPECT_EQ(page("127.0.0.1:9000", "http://127.0.0.1:9000"), 403);
  EXPECT_EQ(page("example.org", "http://example.org"), 403) << "a part of a name is another";
  EXPECT_EQ(page("grasp.example.org:0", ""), 403);
  EXPECT_EQ(page("grasp.example.org:x", ""), 403);
  EXPECT_EQ(page("localhost:9000", "http://example.org"), 403) << "a page of others";
  EXPECT_EQ(page(here(), "https://" + here()), 403) << "this server does not encrypt";
  EXPECT_EQ(upgraded("/live?token=" + std::string(32, '0'), "localhost:9000", ""), 403) << "a name is no token";
}

TEST_F(Server, TakesTheTokenThatItIsGiven) {
  settings_.token = "a-token.that_I~know";
  start();
  EXPECT_TRUE(server_->url().ends_with("/?token=a-token.that_I~know"));
  EXPECT_EQ(status(get_as_it_is("/?token=a-token.that_I~know")), 200);
  EXPECT_EQ(status(get_as_it_is("/?token=a-token.that_I~knew")), 403);
}

TEST(Admission, ReadsNamesOfHosts) {
  EXPECT_EQ(read_host_name("localhost:9000"), (HostName{"localhost", 9000}));
  EXPECT_EQ(read_host_name("my-host.example.org"), (HostName{"my-host.example.org", std::nullopt}));
  EXPECT_EQ(read_host_name("192.168.7.7:80"), (HostName{"192.168.7.7", 80}));
  EXPECT_EQ(read_host_name("[::1]:80"), (HostName{"[::1]", 80}));
  EXPECT_EQ(read_host_name("[::1]"), (HostName{"[::1]", std::nullopt}));
  for (const char* none : {"", ":80", "localhost:", "localhost:0", "localhost:65536", "localhost:8o",
                           "http://localhost", "*", "*.example.org", "a b", "::1", "::1:80", "[]", "[::1",
                           "[localhost]", "[127.0.0.1]", "user@host", "-a", "host/path"}) {
    EXPECT_FALSE(read_host_name(none)) << none;
  }
}

TEST(Admission, TokensAreLongAndPlain) {
  EXPECT_TRUE(can_be_token(random_token()));
  EXPECT_TRUE(can_be_token("0123456789abcdeF"));
  EXPECT_TRUE(can_be_token(std::string(128, 'x')));
  for (const std::string& none :
       {std::string(), std::string("0123456789abcde"), std::string(129, 'x'), std::string("0123456789abcde&"),
        std::string("0123456789 abcdef"), std::string("0123456789%61bcdef"), std::string("0123456789abcdé")}) {
    EXPECT_FALSE(can_be_token(none)) << none;
  }
}

}  // namespace
}  // namespace thenar::window::admission_test
