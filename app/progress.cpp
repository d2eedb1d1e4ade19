// SPDX-License-Identifier: Apache-2.0
#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>

#include "engine/formats/files.h"

namespace thenar::app {

namespace {

// The signal handler's.
std::atomic<bool> stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

}  // namespace

bool stop_is_asked() { return stop; }

namespace {

void listen_for_stop() {
  set_stop_question(stop_is_asked);
  struct sigaction action {};
  action.sa_handler = [](int) { stop = true; };
  action.sa_flags = SA_RESETHAND;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

}  // namespace

ProgressLine::ProgressLine(bool quiet) : shows_(!quiet && isatty(STDERR_FILENO) != 0) {}

void ProgressLine::show(const std::string& words) {
  const auto now = std::chrono::steady_clock::now();
  if (!shows_ || (has_shown_ && now - shown_at_ < std::chrono::milliseconds(100))) return;
  has_shown_ = true;
  shown_at_ = now;
  std::fprintf(stderr, "\r%s\x1b[K", words.c_str());
}

void ProgressLine::clear() {
  if (has_shown_) std::fputs("\r\x1b[K", stderr);
  has_shown_ = false;
}

ReadyingLine::ReadyingLine(bool quiet)
    : teller_([this, began = std::chrono::steady_clock::now(),
               line = ProgressLine(quiet)](const std::stop_token& done) mutable {
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any wake;
        const auto pause = [&](std::chrono::milliseconds time) {
          wake.wait_for(lock, done, time, [] { return false; });
        };
        for (pause(std::chrono::seconds(1)); !done.stop_requested(); pause(std::chrono::milliseconds(200))) {
          const double taken_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
          line.show(fmt::format("making ready: {}, {:.1f} s", stage_.load(), taken_s));
        }
        line.clear();
      }) {}

SearchWatch::SearchWatch(bool quiet) : line_(quiet) { listen_for_stop(); }

bool SearchWatch::step(double share, int grasps) {
  constexpr int kCells = 30;
  const int full = static_cast<int>(share * kCells);
  line_.show(fmt::format("[{:#<{}}{:-<{}}] {:.0f} %, {} found", "", full, "", kCells - full, 100.0 * share, grasps));
  return !stop;
}

RunWatch::RunWatch(const Scene& scene, bool quiet)
    : duration_s_(scene.duration_s), shows_(!quiet && isatty(STDERR_FILENO) != 0) {
  listen_for_stop();
}

void RunWatch::end() const {
  if (shows_) std::fputc('\n', stderr);
}

bool RunWatch::tick(double simulated_s, double wall_s) {
  if (shows_ && (wall_s - shown_s_ >= 0.1 || simulated_s >= duration_s_)) {
    shown_s_ = wall_s;
    std::fprintf(stderr, "\r%.2f of %.2f s simulated, %.1f times real time ", simulated_s, duration_s_,
                 simulated_s / wall_s);
  }
  return !stop;
}

}  // namespace thenar::app
