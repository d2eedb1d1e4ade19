// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/realtime.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <ctime>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace thenar {

namespace {

// The kernel counts what real-time threads take in periods of this length.
constexpr std::int64_t kThrottlePeriod_ns = 1'000'000'000;

// Stack that a contact tick may use without a page fault.
constexpr std::size_t kStackBytes = 256 * 1024;
// Further stack of a thread.
constexpr std::size_t kSpareStackBytes = 32 * 1024;
constexpr std::size_t kThreadStackBytes = 2 * 1024 * 1024;

/// Returns the remaining stack of the calling thread.
std::size_t stack_left() noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return kStackBytes + kSpareStackBytes;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  const char here = 0;
  return static_cast<std::size_t>(&here - static_cast<const char*>(lowest));
}

/// Touches the stack once, so that its pages are present.
[[gnu::noinline]] void touch_stack() noexcept {
  std::array<char, kStackBytes> pages;
  for (std::size_t i = 0; i < pages.size(); i += 1024) {
    volatile char& page = pages[i];
    page = 0;
  }
}

bool may_lock_memory() noexcept {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> data{};
  if (syscall(SYS_capget, &header, data.data()) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

bool lock_memory() noexcept {
  // Under a limit, memory locked in advance would make a later allocation fail: then the present memory must suffice.
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  if (mlockall(MCL_CURRENT) != 0) return false;
  // The present memory is fetched completely. A run's records follow: room for a day would fill the memory at once.
  if (unlimited || may_lock_memory()) mlockall(MCL_FUTURE | MCL_ONFAULT);
  return true;
}

/// The kernel's struct sched_attr, first version; the headers of C library and kernel that have it exclude each other.
struct SchedulingAttributes {
  std::uint32_t size = sizeof(SchedulingAttributes);
  std::uint32_t policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0, deadline_ns = 0, period_ns = 0;
};

/// Requests short time slices of the fair scheduler, which come sooner; needs no privilege. Linux 6.12 and later heed
/// it. With another program busy on the core a 1 kHz thread's p99.9 of lateness was 4 ms so, and 8 to 13 ms without.
void ask_for_short_turns() noexcept {
  SchedulingAttributes attributes;
  if (syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0) return;
  attributes.runtime_ns = 100'000;  // the least that is allowed
  syscall(SYS_sched_setattr, 0, &attributes, 0);
}

void pause() noexcept {
#if defined(__SSE2__)
  _mm_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

#if defined(__aarch64__)
// Bit of the register FPCR, for results and operands.
constexpr std::uint64_t kFlushToZero = 1U << 24;

std::uint64_t read_fpcr() noexcept {
  std::uint64_t fpcr = 0;
  asm volatile("mrs %0, fpcr" : "=r"(fpcr));
  return fpcr;
}
#endif

bool denormals_are_flushed() noexcept {
#if defined(__SSE2__)
  constexpr unsigned kBoth = _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON;
  return (_mm_getcsr() & kBoth) == kBoth;
#elif defined(__aarch64__)
  return (read_fpcr() & kFlushToZero) != 0;
#else
  return false;
#endif
}

/// Opens a socket with a core's name, which one program at a time can have; -1 if that failed, and `taken` tells
/// whether for that reason. It leaves no file, and ends with its process. Programs in other containers do not see it.
int claim_core(int core, bool& taken) {
  const std::string name = fmt::format("thenar contact thread, core {}", core);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);  // After a 0: a name that is no file's.
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  const int file = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (file < 0) return -1;
  if (bind(file, reinterpret_cast<const sockaddr*>(&address), size) == 0) return file;
  taken = errno == EADDRINUSE;
  close(file);
  return -1;
}

}  // namespace

std::string in_words(const Scheduling& contact) {
  std::string words = contact.policy + (contact.priority > 0 ? fmt::format(" {}", contact.priority) : "");
  words += contact.core < 0 ? ", any core" : fmt::format(", core {}", contact.core);
  words += contact.memory_locked ? ", memory locked" : ", memory not locked";
  if (contact.kept_awake) words += ", cores kept awake";
  return words + (contact.remark.empty() ? "" : "; " + contact.remark);
}

void add_remark(Scheduling& scheduling, const std::string& remark) {
  if (!scheduling.remark.empty()) scheduling.remark += "; ";
  scheduling.remark += remark;
}

std::vector<int> allowed_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof set, &set) != 0) return cores;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &set)) cores.push_back(core);
  }
  return cores;
}

bool keep_to_cores(const std::vector<int>& cores) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int core : cores) CPU_SET(core, &set);
  return sched_setaffinity(0, sizeof set, &set) == 0;
}

CoreSetAside::CoreSetAside(bool wanted, int core) {
  const std::vector<int> all = allowed_cores();
  if (!wanted || all.size() < 2) return;
  all_ = all;
  number_ = core < 0 ? all.back() : core;
  std::vector<int> others = all;
  std::erase(others, number_);
  keep_to_cores(others);
  claim_ = claim_core(number_, taken_);
}

CoreSetAside::~CoreSetAside() {
  if (!all_.empty()) keep_to_cores(all_);
  if (claim_ >= 0) close(claim_);
}

AwakeCores::AwakeCores() noexcept : file_(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
  // The kernel applies the number as a request while the file stays open.
  const std::int32_t longest_us = 0;
  if (file_ >= 0 && write(file_, &longest_us, sizeof longest_us) == sizeof longest_us) return;
  if (file_ >= 0) close(file_);
  file_ = -1;
}

AwakeCores::~AwakeCores() {
  if (file_ >= 0) close(file_);
}

Scheduling current_scheduling() {
  Scheduling scheduling;
  int policy = SCHED_OTHER;
  sched_param parameters{};
  if (pthread_getschedparam(pthread_self(), &policy, &parameters) == 0) {
    if (policy == SCHED_FIFO) scheduling.policy = "SCHED_FIFO";
    if (policy == SCHED_RR) scheduling.policy = "SCHED_RR";
    scheduling.priority = parameters.sched_priority;
  }
  const std::vector<int> cores = allowed_cores();
  if (cores.size() == 1) scheduling.core = cores.front();
  scheduling.timer_slack_ns = std::max(0, prctl(PR_GET_TIMERSLACK));
  scheduling.denormals_flushed = denormals_are_flushed();
  return scheduling;
}

Scheduling ask_for_realtime(int core, int priority) {
  const bool pinned = core < 0 || keep_to_cores({core});
  const std::size_t stack_bytes = stack_left();
  const bool stack_suffices = stack_bytes >= kStackBytes + kSpareStackBytes;
  if (stack_suffices) touch_stack();
  const bool locked = lock_memory();
  // Slack lets the kernel gather timers: 50 us unless asked. A SCHED_FIFO thread has none.
  prctl(PR_SET_TIMERSLACK, 1UL);
  sched_param parameters{};
  parameters.sched_priority = priority;
  const bool fifo = priority > 0 && pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;

  Scheduling scheduling = current_scheduling();
  scheduling.memory_locked = locked;
  if (!fifo) ask_for_short_turns();
  if (!fifo && priority > 0) {
    add_remark(scheduling,
               fmt::format("SCHED_FIFO {} was refused: other programs may delay the contact thread. To get it: "
                           "`setcap cap_sys_nice,cap_ipc_lock+ep PROGRAM`, or `USER - rtprio {}` in "
                           "/etc/security/limits.conf and a new login",
                           priority, priority));
  }
  if (!locked) {
    add_remark(scheduling,
               "memory was not locked: a page that was swapped out delays a tick. To get it: the same setcap, or `USER "
               "- memlock unlimited` in /etc/security/limits.conf and a new login");
  }
  if (!stack_suffices) {
    add_remark(scheduling, fmt::format("the thread has {} KB of stack left, and a tick may use {}", stack_bytes / 1024,
                                       kStackBytes / 1024));
  }
  if (!pinned) add_remark(scheduling, fmt::format("core {} was refused: the thread may run on any", core));
  return scheduling;
}

void widen_thread_stacks() noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) != 0) return;
  std::size_t size = 0;
  pthread_attr_getstacksize(&attributes, &size);
  if (size < kThreadStackBytes && pthread_attr_setstacksize(&attributes, kThreadStackBytes) == 0) {
    pthread_setattr_default_np(&attributes);
  }
  pthread_attr_destroy(&attributes);
}

bool flush_denormals() noexcept {
#if defined(__SSE2__)
  _mm_setcsr(_mm_getcsr() | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
#elif defined(__aarch64__)
  asm volatile("msr fpcr, %0" : : "r"(read_fpcr() | kFlushToZero));
#endif
  return denormals_are_flushed();
}

std::int64_t steady_now_ns() noexcept {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::int64_t wait_until(std::int64_t time_ns, std::int64_t spin_ns) noexcept {
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::int64_t now_ns = steady_now_ns();
  const std::int64_t wake_ns = time_ns - std::min(spin_ns, (time_ns - now_ns) / 2);
  if (now_ns < wake_ns) {
    const timespec wake{wake_ns / kSecond, wake_ns % kSecond};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr) == EINTR) {
    }
    now_ns = steady_now_ns();
  }
  while (now_ns < time_ns) {
    pause();
    now_ns = steady_now_ns();
  }
  return now_ns;
}

std::optional<ScheduledTick> Schedule::next(std::int64_t now_ns) noexcept {
  ScheduledTick tick;
  if (index_ < ticks_due_ && deadline_ns(index_) < now_ns && index_ > 0) {
    if (caught_up_ < max_catch_up_) {
      tick.caught_up = true;
    } else {
      const std::int64_t busy_ns = std::min(now_ns - punctual_ns_, kThrottlePeriod_ns);
      const std::int64_t rest_ns = std::llround(rest_share_ * static_cast<double>(busy_ns));
      const std::int64_t next = std::min(first_not_before(now_ns + rest_ns), ticks_due_);
      tick.slipped = next - index_;
      slipped_ += tick.slipped;
      longest_slip_ = std::max(longest_slip_, tick.slipped);
      index_ = next;
    }
  }
  if (index_ >= ticks_due_) return std::nullopt;
  caught_up_ = tick.caught_up ? caught_up_ + 1 : 0;
  tick.deadline_ns = deadline_ns(index_++);
  if (!tick.caught_up) punctual_ns_ = tick.deadline_ns;
  return tick;
}

std::int64_t Schedule::nanoseconds(double time_s) noexcept {
  return std::llround(std::min(1e9 * time_s, kFarthest_ns));
}

std::int64_t Schedule::deadline_ns(std::int64_t index) const noexcept {
  return start_ns_ + std::llround(std::min(static_cast<double>(index) * period_ns_, kFarthest_ns));
}

std::int64_t Schedule::first_not_before(std::int64_t now_ns) const noexcept {
  if (now_ns > deadline_ns(ticks_due_)) return ticks_due_;  // Also where all that follow are due in a hundred years.
  // The quotient may be rounded to either side of the tick: look at both.
  auto index = static_cast<std::int64_t>(static_cast<double>(now_ns - start_ns_) / period_ns_) - 1;
  while (deadline_ns(index) < now_ns) ++index;
  return index;
}

}  // namespace thenar
