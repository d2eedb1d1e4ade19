// SPDX-License-Identifier: Apache-2.0
#include "tests/support/seccomp_trap.h"

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#elif defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
#define THENAR_TRAPS_SYSTEM_CALLS
#endif

#ifdef THENAR_TRAPS_SYSTEM_CALLS
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>

#include <array>
#include <cerrno>
#include <csignal>
#endif

namespace thenar {

namespace {

// Lock-free, so that a signal handler may use them.
std::atomic<std::int64_t> trapped{0};
std::atomic<long> last_trapped{-1};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

}  // namespace

std::int64_t SeccompTrap::count() { return trapped; }
long SeccompTrap::last() { return last_trapped; }

#ifdef THENAR_TRAPS_SYSTEM_CALLS

namespace {

/// The call is not made; the thread sees it fail.
void on_system_call(int, siginfo_t* info, void* context) {
  ++trapped;
  last_trapped = info->si_syscall;
  auto& machine = static_cast<ucontext_t*>(context)->uc_mcontext;
  const long result = info->si_syscall == SYS_brk ? 0 : -ENOMEM;  // brk gives the end of the heap, and no error
#if defined(__x86_64__)
  machine.gregs[REG_RAX] = result;
#else
  machine.regs[0] = static_cast<unsigned long long>(result);
#endif
}

sock_filter statement(unsigned code, unsigned value) { return {static_cast<std::uint16_t>(code), 0, 0, value}; }

/// Two statements: let this call pass, or go on.
std::array<sock_filter, 2> allow(long call) {
  return {{{BPF_JMP | BPF_JEQ | BPF_K, 0, 1, static_cast<std::uint32_t>(call)},
           statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)}};
}

}  // namespace

bool SeccompTrap::is_available() { return true; }

bool SeccompTrap::set() {
  struct sigaction action = {};
  action.sa_sigaction = on_system_call;
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  if (sigaction(SIGSYS, &action, nullptr) != 0) return false;

  const auto sleep = allow(SYS_clock_nanosleep), end = allow(SYS_exit_group), handler_end = allow(SYS_rt_sigreturn);
  std::array filter{statement(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                    sleep[0],
                    sleep[1],
                    end[0],
                    end[1],
                    handler_end[0],
                    handler_end[1],
                    statement(BPF_RET | BPF_K, SECCOMP_RET_TRAP)};
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

#else

bool SeccompTrap::is_available() { return false; }
bool SeccompTrap::set() { return false; }

#endif

}  // namespace thenar
