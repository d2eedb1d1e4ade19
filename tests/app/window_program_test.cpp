// SPDX-License-Identifier: Apache-2.0
// `thenar demo` as a user meets it, where the live window is built.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "tests/support/program.h"

namespace thenar::window_program_test {
namespace {

#ifdef THENAR_WINDOW

// Nobody could find the page.
TEST(WindowProgram, EndsIfItsAddressCannotBePrinted) {
  const ProgramResult run = thenar_program("demo " + config("minimal.yaml") + " --no-browser --port 0",
                                           "timeout 60 sh -c '\"$@\" 3>&1 >/dev/full 2>&3' - ");
  EXPECT_EQ(run.code, 3);
  EXPECT_NE(run.text.find("standard output: could not be written in full"), std::string::npos) << run.text;
}

TEST(WindowProgram, RecordsOverNoInput) {
  const std::filesystem::path scene = scratch() / "scene.yaml";
  std::filesystem::copy_file(config("minimal.yaml"), scene);
  std::filesystem::copy_file(config("hand.yaml"), scene.parent_path() / "hand.yaml");
  const std::string before = read(scene);
  const ProgramResult run =
      thenar_program("demo " + scene.string() + " --no-browser --port 0 --record " + scene.string(), "timeout 60 ");
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(read(scene), before);
}

/// The program while it runs; it is told to end with this.
class Running {
 public:
  explicit Running(const std::string& arguments, const std::string& before = "") {
    output_ = popen(("echo $$; exec " + before + THENAR_PROGRAM + " " + arguments + " 2>&1").c_str(), "r");
    process_ = std::stoi(line());
  }
  ~Running() {
    if (output_ != nullptr) end(SIGKILL);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  /// The next line of its output.
  std::string line() {
    std::string text;
    for (int c = std::fgetc(output_); c != EOF && c != '\n'; c = std::fgetc(output_)) text += static_cast<char>(c);
    return text;
  }
  /// The exit code, after the signal.
  int end(int signal) {
    kill(process_, signal);
    std::string rest;
    return ended(rest);
  }
  /// The exit code, once it has ended; what it still says is added to `text`.
  int ended(std::string& text) {
    while (std::feof(output_) == 0) text += '\n' + line();
    const int status = pclose(std::exchange(output_, nullptr));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  std::FILE* output_;
  pid_t process_;
};

// Whatever the number of files that may be open: it serves, or says what it has not got.
TEST(WindowProgram, SaysThatItMayOpenNoMoreFiles) {
  for (int files = 4; files <= 10; ++files) {
    Running demo("demo " + config("minimal.yaml") + " --no-browser --port 0",
                 "sh -c 'ulimit -n " + std::to_string(files) + "; exec \"$@\"' - ");
    std::string text = demo.line();
    if (text.starts_with("http://")) break;  // It serves.
    const int code = demo.ended(text);
    EXPECT_TRUE(code == 3 || code == 4 || code == 127) << files << ": " << code << text;
    EXPECT_EQ(text.find("internal error"), std::string::npos) << files << ": " << text;
  }
}

/// What a server at 127.0.0.1 answers to a request for `target`.
std::string get(int port, const std::string& target, std::string host = "") {
  if (host.empty()) host = "127.0.0.1:" + std::to_string(port);
  const int client = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (connect(client, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0) {
    const std::string request = "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n";
    send(client, request.data(), request.size(), MSG_NOSIGNAL);
    char bytes[4096];
    for (ssize_t n = recv(client, bytes, sizeof bytes, 0); n > 0; n = recv(client, bytes, sizeof bytes, 0)) {
      answer.append(bytes, static_cast<std::size_t>(n));
    }
  }
  close(client);
  return answer;
}

int port_in(const std::string& url) { return std::stoi(url.substr(url.rfind(':') + 1)); }
/// The path, with the token that the address ends in.
std::string with_token(const std::string& path, const std::string& url) { return path + url.substr(url.find('?')); }

TEST(Demo, ServesASceneUntilItIsTold) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Running demo("demo " + config("box_grasp.yaml") + " --port 0 --no-browser");
    const std::string url = demo.line();
    ASSERT_TRUE(url.starts_with("http://127.0.0.1:")) << url;
    const std::string place = "127.0.0.1:" + std::to_string(port_in(url));
    EXPECT_NE(demo.line().find("ssh -L " + place.substr(10) + ":" + place + " "), std::string::npos);
    EXPECT_NE(get(port_in(url), with_token("/", url)).find("data-source=\"live\""), std::string::npos);
    EXPECT_EQ(demo.end(signal), 0);
  }
}

TEST(Demo, ServesARecording) {
  const std::string file = (scratch() / "box.mcap").string();
  ASSERT_EQ(thenar_program("run " + config("box_grasp.yaml") + " --time '0.1 s' --quiet --record " + file).code, 0);
  Running demo("demo " + file + " --port 0 --no-browser --quiet");
  const std::string url = demo.line();
  const int port = port_in(url);
  EXPECT_NE(get(port, with_token("/", url)).find("data-source=\"recording\""), std::string::npos);
  EXPECT_TRUE(get(port, with_token("/recording", url)).ends_with("\r\n\r\n" + read(file)));
  EXPECT_EQ(demo.end(SIGINT), 0);
}

TEST(Demo, AsksForAToken) {
  for (const std::string address : {"127.0.0.1", "0.0.0.0"}) {
    Running demo("demo " + config("minimal.yaml") + " --port 0 --no-browser --listen " + address);
    const std::string url = demo.line();
    const std::size_t token = url.find("/?token=");
    ASSERT_NE(token, std::string::npos) << url;
    EXPECT_EQ(get(port_in(url), "/").substr(9, 3), "403");
    EXPECT_EQ(get(port_in(url), url.substr(token)).substr(9, 3), "200");
  }
}

// On the command line, or where no other user of the machine reads it.
TEST(Demo, TakesATokenAndNames) {
  const std::string scene = "demo " + config("minimal.yaml") + " --port 0 --no-browser ", token = "a-token-of-scripts";
  for (const auto& [flag, before] :
       {std::pair("--token " + token, std::string()), std::pair(std::string(), "env THENAR_TOKEN=" + token + " ")}) {
    Running demo(scene + flag + " --allow-host localhost:9000 --allow-host near.example.org", before);
    const std::string url = demo.line();
    ASSERT_TRUE(url.ends_with("/?token=" + token)) << url;
    EXPECT_EQ(get(port_in(url), "/?token=" + token).substr(9, 3), "200");
    for (const char* host : {"localhost:9000", "near.example.org", "near.example.org:1234"}) {
      EXPECT_EQ(get(port_in(url), "/?token=" + token, host).substr(9, 3), "200") << host;
    }
    EXPECT_EQ(get(port_in(url), "/?token=" + token, "localhost:9001").substr(9, 3), "403");
  }
  for (const std::string wrong : {"--token short", "--token 'no blanks in a token'", "--allow-host http://localhost",
                                  "--allow-host localhost:0", "--allow-host '*'"}) {
    const ProgramResult run = thenar_program(scene + wrong, "timeout 60 ");
    EXPECT_EQ(run.code, 2) << wrong;
    EXPECT_NE(run.text.find(wrong.substr(0, wrong.find(' '))), std::string::npos) << run.text;
  }
  EXPECT_EQ(thenar_program(scene, "timeout 60 env THENAR_TOKEN=short ").code, 2);
}

// The browser gets the address as one word, from no shell. Here it is a program that writes down what it gets.
TEST(Demo, OpensTheBrowserAtTheAddress) {
  const std::filesystem::path folder = scratch(), opened = folder / "opened";
  std::ofstream(folder / "xdg-open") << "#!/bin/sh\nprintf '%s\\n' \"$@\" >" << opened.string() << "\n";
  std::filesystem::permissions(folder / "xdg-open", std::filesystem::perms::owner_all);
  Running demo("demo " + config("minimal.yaml") + " --port 0 --quiet",
               "env DISPLAY=:0 PATH=" + folder.string() + ":$PATH ");
  const std::string url = demo.line();
  for (int i = 0; i < 6000 && !read(opened).ends_with('\n'); ++i) usleep(10'000);
  EXPECT_EQ(read(opened), url + "\n");
}

TEST(Demo, SaysWhatIsWrong) {
  EXPECT_EQ(thenar_program("demo --help").code, 0);
  const std::string scene = "demo " + config("box_grasp.yaml") + " --no-browser ";
  EXPECT_EQ(thenar_program("demo").code, 2);
  EXPECT_EQ(thenar_program("demo none.yaml --no-browser").code, 3);
  EXPECT_EQ(thenar_program("demo none.mcap --no-browser").code, 3);
  EXPECT_EQ(thenar_program("demo none.mcap --no-browser --contact-rate 4kHz").code, 2);
  EXPECT_EQ(thenar_program(scene + "--port 70000").code, 2);
  EXPECT_EQ(thenar_program(scene + "--listen localhost").code, 2);
  EXPECT_EQ(thenar_program(scene + "--listen \"::1%';exit 7;'\"").code, 2);
  EXPECT_EQ(thenar_program(scene + "--set object.mas=1").code, 2);
  EXPECT_EQ(thenar_program(scene + "--control-rate 8kHz").code, 2);
  Running demo("demo " + config("box_grasp.yaml") + " --port 0 --no-browser");
  const ProgramResult taken = thenar_program(scene + "--port " + std::to_string(port_in(demo.line())));
  EXPECT_EQ(taken.code, 4);
  EXPECT_NE(taken.text.find("--port"), std::string::npos) << taken.text;
}

#else

TEST(Demo, SaysHowToBuildIt) {
  const ProgramResult demo = thenar_program("demo " + config("box_grasp.yaml"));
  EXPECT_EQ(demo.code, 3);
  EXPECT_NE(demo.text.find("./dev demo"), std::string::npos) << demo.text;
}

#endif

}  // namespace
}  // namespace thenar::window_program_test
