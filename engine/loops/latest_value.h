// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace thenar {

/// Counts of the values of a LatestValue: published = consumed + superseded + in flight.
struct ExchangeCounts {
  std::int64_t published = 0;
  std::int64_t consumed = 0;    ///< Taken by the reader.
  std::int64_t superseded = 0;  ///< Overwritten before they were read.
  std::int64_t in_flight = 0;   ///< Published and not yet taken: 0 or 1.
  std::int64_t torn = 0;        ///< Taken while half written, or written while in use: 0 unless the protocol is broken.
  [[nodiscard]] std::int64_t unaccounted() const { return published - consumed - superseded - in_flight; }
};

/// Two neighbouring cache lines, which Intel's prefetcher fetches together: the distance of data of two threads.
inline constexpr std::size_t kSeparate = 128;

/// A value between two stamps, its number: the writer sets the first when it begins and the second when it has ended.
/// Atomic, so that a reader may read them even where the protocol is broken, which they detect. They protect nothing,
/// the exchange of slots does; where that is broken they detect torn values on a best-effort basis: the first stamp may
/// become visible after the value's first bytes, the second before the last ones, and the reader's second check may
/// precede its reading of the last ones, so a short tear may be missed.
template <class T>
class Stamped {
 public:
  template <class... Arguments>
  explicit Stamped(Arguments&&... arguments) : value(std::forward<Arguments>(arguments)...) {}

  // Relaxed, all of them: if they ordered anything, they would hide from ThreadSanitizer that the exchange does not.
  void begin(std::int64_t number) noexcept { before_.store(number, std::memory_order_relaxed); }
  void end(std::int64_t number) noexcept { after_.store(number, std::memory_order_relaxed); }
  /// Tests whether the slot holds the whole of that value, and no other one was begun.
  [[nodiscard]] bool holds(std::int64_t number) const noexcept {
    return number_written() == number && before_.load(std::memory_order_relaxed) == number;
  }
  /// Returns the number of the last value that was completely written.
  [[nodiscard]] std::int64_t number_written() const noexcept { return after_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> before_{0};

 public:
  T value;

 private:
  std::atomic<std::int64_t> after_{0};
};

/// An exchange of values from one thread to another; the latest wins. Neither side ever waits: a call is at most one
/// atomic exchange, regardless of the other thread.
///
/// Three slots: the writer owns the draft, the reader the current one, and the middle one waits between them. Both
/// sides exchange theirs with the middle one, so no slot ever has two owners. A draft still contains an earlier
/// published value: values that own memory keep it.
template <class T>
class LatestValue {
 public:
  /// Makes every slot T(arguments...). Allocates all memory.
  template <class... Arguments>
  explicit LatestValue(const Arguments&... arguments)
      : slots_{Slot(arguments...), Slot(arguments...), Slot(arguments...)} {
    slots_[draft_].begin(1);
  }

  /// Writer: returns the value to fill.
  [[nodiscard]] T& draft() noexcept { return slots_[draft_].value; }

  /// Writer: makes the draft the newest value, and begins another in an unused slot.
  void publish() noexcept {
    slots_[draft_].end(++published_);
    // Release: the reader that takes this slot sees its contents. Acquire: we may overwrite the one we get.
    const unsigned old = middle_.exchange(draft_ | kFresh, std::memory_order_acq_rel);
    if ((old & kFresh) != 0) ++superseded_;
    draft_ = old & kSlot;
    slots_[draft_].begin(published_ + 1);
  }

  /// Reader: moves on to the newest value; false if nothing was published since the last take().
  bool take() noexcept {
    // Relaxed: only a hint; the slot is exchanged below.
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    if (!slots_[current_].holds(number_)) ++torn_;
    // Acquire: we see the contents of the slot we get. Release: the writer that gets ours sees that we have read it.
    current_ = middle_.exchange(current_, std::memory_order_acq_rel) & kSlot;
    const std::int64_t number = slots_[current_].number_written();
    if (number <= number_ || !slots_[current_].holds(number)) ++torn_;
    number_ = number;
    ++consumed_;
    return true;
  }

  /// Reader: returns the value of the last take(), or of the constructor. It does not change before the next take().
  [[nodiscard]] const T& current() const noexcept { return slots_[current_].value; }

  /// Returns the counts; requires both sides at rest.
  [[nodiscard]] ExchangeCounts counts() const noexcept {
    // Relaxed: whatever made both sides rest has ordered this.
    const bool in_flight = (middle_.load(std::memory_order_relaxed) & kFresh) != 0;
    return {published_, consumed_, superseded_, in_flight ? 1 : 0, torn_};
  }

 private:
  struct alignas(kSeparate) Slot : Stamped<T> {
    using Stamped<T>::Stamped;
  };
  static constexpr unsigned kSlot = 3;   // bits of `middle_`: a slot's index,
  static constexpr unsigned kFresh = 4;  // and a flag: its value has yet to be taken

  static_assert(std::atomic<unsigned>::is_always_lock_free);

  std::array<Slot, 3> slots_;
  alignas(kSeparate) std::atomic<unsigned> middle_{1};
  alignas(kSeparate) unsigned draft_ = 0;  // from here the writer's
  std::int64_t published_ = 0, superseded_ = 0;
  alignas(kSeparate) unsigned current_ = 2;  // from here the reader's
  std::int64_t number_ = 0, consumed_ = 0, torn_ = 0;
};

}  // namespace thenar
