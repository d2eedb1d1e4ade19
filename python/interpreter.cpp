// SPDX-License-Identifier: Apache-2.0
#include "python/interpreter.h"

#include <fmt/format.h>
#include <pthread.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace thenar::python {

namespace {

/// How much work is under way. Never freed: a thread may leave it while the process ends.
struct Work {
  std::mutex mutex;
  std::condition_variable done;
  int under_way = 0;
};
Work* work = new Work;
std::atomic<bool> ending = false;
std::thread::id ending_thread;

[[noreturn]] void raise_end() {
  PyErr_SetNone(PyExc_SystemExit);  // Threads end by it without a word.
  throw py::error_already_set();
}

/// Ends all work. A law that does not return is given up after a while: the end would never come.
void end_work() {
  constexpr std::chrono::seconds kPatience{10};
  ending_thread = std::this_thread::get_id();
  ending = true;
  const py::gil_scoped_release others;
  std::unique_lock lock(work->mutex);
  work->done.wait_for(lock, kPatience, [] { return work->under_way <= 0; });
}

}  // namespace

bool is_ending() noexcept { return ending.load(std::memory_order_relaxed); }

Engaged::Engaged() {
  if (is_ending() && std::this_thread::get_id() != ending_thread) raise_end();
  const std::lock_guard lock(work->mutex);
  ++work->under_way;
}

Engaged::~Engaged() {
  const std::lock_guard lock(work->mutex);
  if (--work->under_way <= 0) work->done.notify_all();
}

Unlocked::Unlocked() = default;

void check_signals() {
  if (is_ending() && std::this_thread::get_id() != ending_thread) raise_end();
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

bool SignalWatch::operator()() {
  if (raised_ || (is_ending() && std::this_thread::get_id() != ending_thread)) return true;
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_at_ < std::chrono::milliseconds(50)) return false;
  looked_at_ = now;
  const py::gil_scoped_acquire lock;
  raised_ = PyErr_CheckSignals() != 0;
  return raised_;
}

void SignalWatch::rethrow() const {
  if (raised_) throw py::error_already_set();
  check_signals();
}

std::string text_of(py::handle value, const std::string& name) {
  py::ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
  if (text != nullptr) return {text, static_cast<std::size_t>(size)};
  PyErr_Clear();
  throw py::value_error(
      fmt::format("{} is no text: a part of it is no character, but half of a pair (surrogate)", name));
}

void bind_interpreter() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&end_work));
  // Threads other than the one that forks are not in the child.
  pthread_atfork(nullptr, nullptr, [] { work = new Work; });
}

}  // namespace thenar::python
