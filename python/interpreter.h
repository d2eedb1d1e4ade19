// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

/// The interpreter: its lock, its signals and its end.
namespace thenar::python {

namespace py = pybind11;

/// Returns true from the interpreter's end on, in any thread.
[[nodiscard]] bool is_ending() noexcept;

/// Work that may ask for the interpreter's lock. The interpreter's end waits for it, since a thread that asks later is
/// ended by Python in the middle of our functions. The work ends soon once is_ending().
class Engaged {
 public:
  Engaged();
  ~Engaged();
  Engaged(const Engaged&) = delete;
  Engaged& operator=(const Engaged&) = delete;
};

/// A scope in which other threads may have the interpreter's lock. At the interpreter's end it raises SystemExit in all
/// threads but the one that ends it.
class Unlocked {
 public:
  Unlocked();

 private:
  Engaged engaged_;  // Until the lock is there again.
  py::gil_scoped_release released_;
};

/// Looks for signals, such as Ctrl-C, and for the interpreter's end: raises what they raise.
void check_signals();

/// A watch for the same from scopes without the lock: looks every 50 ms, with the lock.
class SignalWatch {
 public:
  /// Returns true if the work is to end.
  [[nodiscard]] bool operator()();
  /// Raises the exception of the signal, if there was one.
  void rethrow() const;

 private:
  std::chrono::steady_clock::time_point looked_at_ = std::chrono::steady_clock::now();
  bool raised_ = false;
};

/// Base of the classes that Python sees, which std::make_shared makes. For an instance that no constructor has made,
/// such as that of `X.__new__(X)`, pybind11 takes memory from here, and would use it as it is: it gets none.
struct Constructed {
  static void* operator new(std::size_t /*bytes*/) {
    throw py::type_error("this instance was never made: call its class, and super().__init__() of a subclass");
  }
};

/// Returns the text of a str. Raises ValueError, which names it, for lone surrogates: they are no text.
[[nodiscard]] std::string text_of(py::handle value, const std::string& name);

void bind_interpreter();

}  // namespace thenar::python
