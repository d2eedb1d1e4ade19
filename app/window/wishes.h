// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "app/window/live_settings.h"

namespace thenar::window {

/// What pages want, on its way from the server's thread to the calling one, which heeds it between two runs of the
/// loops. One mutex guards it.
class Wishes {
 public:
  /// Changes what is wanted, and wakes the calling thread. `change(Wanted&)` that changes nothing does not.
  template <typename Change>
  void change(const Change& change) {
    const std::lock_guard lock(mutex_);
    const Wanted before = wanted_;
    change(wanted_);
    if (wanted_ == before) return;  // refused, or nothing new: the loops go on
    // Relaxed: the mutex orders what is wanted; this only says when to look.
    changed_.store(true, std::memory_order_relaxed);
    woken_.notify_one();
  }

  // The calling thread:
  /// Returns true if something new is wanted since heed().
  [[nodiscard]] bool is_new() const { return changed_.load(std::memory_order_relaxed); }
  /// Returns what is wanted, and takes steps and a reset out of it; also the grasp, if its scene is due.
  [[nodiscard]] Wanted heed(bool scene_due) {
    changed_.store(false, std::memory_order_relaxed);
    const std::lock_guard lock(mutex_);
    const Wanted now = wanted_;
    wanted_.steps = 0;
    wanted_.reset = false;
    if (scene_due) wanted_.take.reset();
    return now;
  }
  /// Changes what is wanted without being woken.
  template <typename Change>
  void correct(const Change& change) {
    const std::lock_guard lock(mutex_);
    change(wanted_);
  }
  /// Waits until something new is wanted, no longer than `longest`.
  void wait(std::chrono::milliseconds longest) {
    std::unique_lock lock(mutex_);
    woken_.wait_for(lock, longest, [this] { return is_new(); });
  }

 private:
  std::mutex mutex_;
  Wanted wanted_;
  std::condition_variable woken_;
  std::atomic<bool> changed_{false};
};

}  // namespace thenar::window
