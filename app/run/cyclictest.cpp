// SPDX-License-Identifier: Apache-2.0
#include "app/run/cyclictest.h"

#include <fmt/format.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

namespace thenar::app {

namespace {

constexpr int kBins = 1'000'000;  // The most that cyclictest has: with -N a bin is 1 ns.

/// A program inherits the timer slack of the thread that starts it.
class TimerSlack {
 public:
  explicit TimerSlack(double slack_ns) : before_ns_(prctl(PR_GET_TIMERSLACK)) {
    // 0 stands for the default, which is 50 us.
    if (slack_ns >= 1.0) prctl(PR_SET_TIMERSLACK, std::lround(slack_ns));
  }
  ~TimerSlack() { prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(before_ns_)); }
  TimerSlack(const TimerSlack&) = delete;
  TimerSlack& operator=(const TimerSlack&) = delete;

 private:
  int before_ns_;
};

std::string command_line(const Scheduling& scheduling, double period_s, std::int64_t loops) {
  std::string command =
      fmt::format("cyclictest -q -N -m -t 1 -i {} -l {} -h {}", std::lround(1e6 * period_s), loops, kBins);
  const bool fifo = scheduling.policy == "SCHED_FIFO";
  command += fifo ? fmt::format(" --policy=fifo -p {}", scheduling.priority) : std::string(" --policy=other");
  if (scheduling.core >= 0) command += fmt::format(" -a {}", scheduling.core);
  return command + " 2>/dev/null";
}

}  // namespace

std::optional<std::vector<double>> run_cyclictest(const Scheduling& scheduling, double period_s, std::int64_t loops) {
  const TimerSlack slack(scheduling.timer_slack_ns);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(
      popen(command_line(scheduling, period_s, loops).c_str(), "r"), pclose);
  if (!pipe) return std::nullopt;
  std::vector<double> jitter_us;
  double longest_us = 0.0;
  long long overflows = 0;
  std::array<char, 256> line{};
  while (std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    long long bin = 0, count = 0;
    if (std::sscanf(line.data(), "%lld %lld", &bin, &count) == 2) {
      jitter_us.insert(jitter_us.end(), count, 1e-3 * static_cast<double>(bin));
    } else if (std::sscanf(line.data(), "# Max Latencies: %lld", &bin) == 1) {
      longest_us = 1e-3 * static_cast<double>(bin);
    } else {
      (void)std::sscanf(line.data(), "# Histogram Overflows: %lld", &overflows);
    }
  }
  jitter_us.insert(jitter_us.end(), overflows, longest_us);
  std::sort(jitter_us.begin(), jitter_us.end());
  if (jitter_us.empty()) return std::nullopt;
  return jitter_us;
}

}  // namespace thenar::app
