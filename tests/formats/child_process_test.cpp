// SPDX-License-Identifier: Apache-2.0
// Work in a child process: what it gives comes back whole, and however the child ends, this process goes on.

#include "engine/formats/child_process.h"

#include <gtest/gtest.h>
#include <sys/time.h>

#include <csignal>
#include <stdexcept>
#include <vector>

namespace thenar::child_process_test {
namespace {

TEST(ChildProcess, GivesItsBytes) {
  EXPECT_EQ(in_child_process([] { return std::string(); }), "");
  // Far more than a pipe holds.
  std::string bytes(3'000'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i);
  EXPECT_EQ(in_child_process([&] { return bytes; }), bytes);
}

TEST(ChildProcess, LeavesThisOneAsItIs) {
  int value = 1;
  (void)in_child_process([&] {
    value = 2;
    return std::string();
  });
  EXPECT_EQ(value, 1);
}

TEST(ChildProcess, ThatFailsGivesNothing) {
  EXPECT_FALSE(in_child_process([]() -> std::string { throw std::runtime_error("no"); }));
  for (const int fault : {SIGKILL, SIGTERM}) {
    EXPECT_FALSE(in_child_process([&] {
      std::raise(fault);
      return std::string();
    }));
  }
}

TEST(ChildProcess, HasBoundedMemoryAndTime) {
  const ChildLimits limits{.memory_bytes = 100'000'000, .cpu_s = 1};
  // Sanitizers end a process that asks for too much, rather than throw: nothing comes back in any case.
  EXPECT_FALSE(in_child_process(
      [] {
        std::vector<std::string> taken;
        while (taken.size() < 10'000) taken.emplace_back(1'000'000, 'x');
        return std::string();
      },
      limits));
  EXPECT_FALSE(in_child_process(
      []() -> std::string {
        for (volatile bool on = true; on;) {
        }
        return "";
      },
      limits));
}

TEST(ChildProcess, AProgramGivesItsOutput) {
  std::string bytes(3'000'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i);
  EXPECT_EQ(output_of({"cat", "/dev/stdin"}, bytes), bytes);
  EXPECT_EQ(output_of({"sh", "-c", "printf x; echo lost >&2"}, ""), "x");
  EXPECT_FALSE(output_of({"sh", "-c", "printf x; exit 3"}, "")) << "it failed";
  EXPECT_FALSE(output_of({"no program has this name"}, ""));
}

// A handler that does not restart calls of the system: each signal interrupts the read.
TEST(ChildProcess, SignalsCutNoOutputOff) {
  struct sigaction ignoring {
  }, before{};
  ignoring.sa_handler = [](int) {};
  sigaction(SIGALRM, &ignoring, &before);
  const itimerval often{{0, 3000}, {0, 3000}}, never{};
  setitimer(ITIMER_REAL, &often, nullptr);
  const auto output = output_of({"sh", "-c", "for i in 1 2 3 4 5; do printf $i; sleep 0.02; done"}, "");
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
  EXPECT_EQ(output, "12345");
}

}  // namespace
}  // namespace thenar::child_process_test
