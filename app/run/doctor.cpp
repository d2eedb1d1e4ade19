// SPDX-License-Identifier: Apache-2.0
#include "app/run/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <future>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "engine/loops/percentiles.h"
#include "engine/loops/realtime.h"

namespace thenar::app {

namespace {

constexpr std::array kRates_kHz{10.0, 4.0, 2.0, 1.0};
constexpr double kMeasured_s = 1.0;  // for each of them
constexpr double kSpin_s = 50e-6;    // as the contact thread of a run

/// The first line of a file of the system; nothing if there is none to be read.
std::optional<std::string> line_of(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  return line;
}

void say(std::ostream& out, const char* what, const std::string& words) {
  out << fmt::format("  {:<15} {}\n", what, words) << std::flush;
}

bool is_virtual_machine() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("flags")) return line.find(" hypervisor") != std::string::npos;
  }
  return false;
}

/// Ticks of 10 ms that a core has spent, and those of them that its host gave to others.
struct CoreTime {
  std::int64_t all = 0, stolen = 0;
};

CoreTime core_time(int core) {
  std::ifstream in("/proc/stat");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    if (name != fmt::format("cpu{}", core)) continue;
    CoreTime time;
    std::int64_t ticks = 0;
    // user, nice, system, idle, iowait, irq, softirq, steal; guests' time, which follows, is in user.
    for (int column = 0; column < 8 && words >> ticks; ++column) {
      time.all += ticks;
      if (column == 7) time.stolen = ticks;
    }
    return time;
  }
  return {};
}

/// How late the ticks of a contact thread start [us]. One that slips would have started when the next one does.
Percentiles measure_lateness(double rate_kHz, double spin_s) {
  const double period_s = 1e-3 / rate_kHz;
  const std::int64_t ticks = std::llround(kMeasured_s / period_s);
  std::vector<double> late_us;
  late_us.reserve(static_cast<std::size_t>(ticks));
  Schedule schedule(steady_now_ns() + 1'000'000, period_s, ticks, 0);
  std::int64_t now_ns = steady_now_ns();
  while (const auto tick = schedule.next(now_ns)) {
    now_ns = wait_until(tick->deadline_ns, std::llround(1e9 * spin_s));
    const double this_us = 1e-3 * static_cast<double>(now_ns - tick->deadline_ns);
    for (std::int64_t k = tick->slipped; k >= 0; --k) {
      late_us.push_back(this_us + 1e6 * period_s * static_cast<double>(k));
    }
  }
  // The last ones may have slipped, with nothing after them.
  for (auto k = ticks - std::ssize(late_us); k > 0; --k) late_us.push_back(1e6 * period_s * static_cast<double>(k));
  return percentiles(std::move(late_us));
}

struct WakeUps {
  Scheduling granted;
  Percentiles asleep_us;                                 ///< At the last rate, without a spin.
  std::array<Percentiles, kRates_kHz.size()> late_us{};  ///< At each rate, with one.
};

/// Wakes at each rate, in a thread as the contact thread of a run.
WakeUps measure_wake_ups(int core) {
  // What it throws comes here with get().
  return std::async(std::launch::async,
                    [core] {
                      WakeUps result;
                      result.granted = ask_for_realtime(core);
                      result.granted.denormals_flushed = flush_denormals();
                      const AwakeCores awake;
                      result.granted.kept_awake = awake.granted();
                      result.asleep_us = measure_lateness(kRates_kHz.back(), 0.0);
                      for (std::size_t i = 0; i < kRates_kHz.size(); ++i) {
                        // As in a run, half a step at most.
                        result.late_us[i] = measure_lateness(kRates_kHz[i], std::min(kSpin_s, 0.5e-3 / kRates_kHz[i]));
                      }
                      return result;
                    })
      .get();
}

void say_granted(std::ostream& out, const Scheduling& granted) {
  const bool fifo = granted.policy == "SCHED_FIFO";
  say(out, "scheduling",
      fifo ? fmt::format("SCHED_FIFO {} is granted", granted.priority)
           : "SCHED_FIFO is refused: other programs may hold the contact thread up");
  say(out, "memory", granted.memory_locked ? "can be locked" : "cannot be locked: a swapped-out page holds a tick up");
  say(out, "timer slack",
      granted.timer_slack_ns <= 1.0
          ? "none: timers are not held back to gather them"
          : fmt::format("{:.0f} us: timers are held back to gather them", 1e-3 * granted.timer_slack_ns));
  say(out, "denormals", granted.denormals_flushed ? "flushed to zero" : "not flushed on this processor");
  if (!granted.remark.empty()) say(out, "how to get it", granted.remark);
}

void say_cores(std::ostream& out, const std::vector<int>& cores, const CoreSetAside& set_aside) {
  const std::string words = fmt::format("{} may be used", cores.size());
  say(out, "cores",
      cores.size() > 1
          ? fmt::format("{}; the contact thread gets core {}, the others do the rest", words, set_aside.number())
          : words + ": the contact thread shares it with all else, and control gets no real-time priority");
  if (set_aside.taken()) {
    say(out, "taken",
        fmt::format("core {} is the contact thread's of another run: --core chooses another one", set_aside.number()));
  }
}

void say_kernel(std::ostream& out, int core) {
  const bool preemptible = line_of("/sys/kernel/realtime") == "1";
  say(out, "kernel",
      fmt::format("{}{}", preemptible ? "PREEMPT_RT" : "without PREEMPT_RT",
                  is_virtual_machine() ? ", in a virtual machine: its host decides, too" : ""));
  const auto governor = line_of(fmt::format("/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor", core));
  if (!governor) {
    say(out, "frequency", "no governor to be seen");
  } else if (*governor == "performance") {
    say(out, "frequency", "governor performance");
  } else {
    say(out, "frequency",
        fmt::format("governor {}: a core that idles slows down. `cpupower frequency-set -g performance` "
                    "keeps it awake",
                    *governor));
  }
  const auto runtime = line_of("/proc/sys/kernel/sched_rt_runtime_us");
  const auto period = line_of("/proc/sys/kernel/sched_rt_period_us");
  if (!runtime || !period) {
    say(out, "throttling", "unknown");
  } else if (*runtime == "-1" || *runtime == *period) {
    say(out, "throttling", "none");
  } else {
    say(out, "throttling",
        fmt::format("real-time threads may have {} of {} us; ours sleeps where a step leaves time, and after a slip",
                    *runtime, *period));
  }
}

void say_clock(std::ostream& out) {
  const std::string source =
      line_of("/sys/devices/system/clocksource/clocksource0/current_clocksource").value_or("unknown");
  constexpr std::array kLocal{"tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"};
  const bool local = std::find(kLocal.begin(), kLocal.end(), source) != kLocal.end();
  constexpr int kReadings = 100'000;
  const std::int64_t start_ns = steady_now_ns();
  std::int64_t now_ns = start_ns;
  for (int i = 0; i < kReadings; ++i) now_ns = steady_now_ns();
  const double reading_ns = static_cast<double>(now_ns - start_ns) / kReadings;
  say(out, "clock",
      fmt::format("{}, read {} a system call in {:.0f} ns", source, local ? "without" : "by", reading_ns));
}

void say_lateness(std::ostream& out, const std::string& what, const Percentiles& late_us) {
  say(out, what.c_str(),
      fmt::format("p50 {:.1f}, p99 {:.1f}, p99.9 {:.1f}, max {:.1f} us", late_us.p50, late_us.p99, late_us.p999,
                  late_us.max));
}

/// A tick must fit into its period with its lateness and its computation: half of the period for each. As in a run, a
/// rate is kept if 99 % of the ticks are in time.
std::string verdict(const WakeUps& wake_ups) {
  std::size_t kept = kRates_kHz.size();  // The fastest, if all slower ones are kept, too.
  while (kept > 0 && wake_ups.late_us[kept - 1].p99 <= 500.0 / kRates_kHz[kept - 1]) --kept;
  if (kept < kRates_kHz.size()) {
    const double period_us = 1000.0 / kRates_kHz[kept];
    return fmt::format(
        "This machine can keep contact at {:g} kHz: 99 % of the ticks start within half of their period, {:g} of {:g} "
        "us.\nInto the other half must fit `contact: compute` of run --realtime, also for 99 % of the ticks; "
        "into the\ncontrol period must fit `control: whole tick`.",
        kRates_kHz[kept], 0.5 * period_us, period_us);
  }
  return fmt::format(
      "This machine may not keep contact at 1 kHz: one tick in 100 starts more than {:.0f} of 1000 us late, and 99 % "
      "must be done.",
      wake_ups.late_us.back().p99);
}
static_assert(kKeptShare == 0.99, "its words");

}  // namespace

void doctor(std::ostream& out, int asked_core) {
  const std::vector<int> cores = allowed_cores();
  const CoreSetAside set_aside(true, asked_core);
  const int core = set_aside.number() >= 0 ? set_aside.number() : cores.empty() ? 0 : cores.back();
  out << "What this machine can keep\n";
  say_cores(out, cores, set_aside);
  say_kernel(out, core);
  say_clock(out);
  const CoreTime before = core_time(core);
  const WakeUps wake_ups = measure_wake_ups(core);
  const CoreTime after = core_time(core);
  say_granted(out, wake_ups.granted);
  const auto stolen = static_cast<double>(after.stolen - before.stolen);
  say(out, "steal",
      fmt::format("{:.1f} % of the core's time went to others on its host while measuring",
                  100.0 * stolen / static_cast<double>(std::max<std::int64_t>(1, after.all - before.all))));
  out << fmt::format(
      "How late the ticks of a thread start, in {:g} s each; with a spin of {:.0f} us but for the first\n", kMeasured_s,
      1e6 * kSpin_s);
  say_lateness(out, fmt::format("{:g} kHz, asleep", kRates_kHz.back()), wake_ups.asleep_us);
  for (std::size_t i = kRates_kHz.size(); i-- > 0;) {
    say_lateness(out, fmt::format("{:g} kHz", kRates_kHz[i]), wake_ups.late_us[i]);
  }
  out << verdict(wake_ups) << '\n';
}

}  // namespace thenar::app
