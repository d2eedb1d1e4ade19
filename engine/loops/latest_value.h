#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace thenar {

/// What became of the values that went through a LatestValue. published = consumed + superseded + in flight.
struct ExchangeCounts {
  std::int64_t published = 0;
  std::int64_t consumed = 0;    ///< Taken by the reader.
  std::int64_t superseded = 0;  ///< Overwritten before the reader looked.
  std::int64_t in_flight = 0;   ///< Published and not yet taken: 0 or 1.
  std::int64_t torn = 0;  ///< Taken while half written, or written while in use: none, unless the protocol is broken.
  [[nodiscard]] std::int64_t unaccounted() const { return published - consumed - superseded - in_flight; }
};

/// Two neighbouring cache lines, which Intel's prefetcher fetches together: what two threads write is kept so far
/// apart.
inline constexpr std::size_t kSeparate = 128;

/// A value between two stamps, its number: the writer sets the first when it begins and the second when it has ended.
/// Atomic, so that a reader may look at them even where the protocol is broken, which they are there to show. They
/// protect nothing, the exchange of slots does; and where that is broken they show a torn value at their best effort:
/// the first stamp may become visible after the value's first bytes, the second before the last ones, and the reader's
/// second look may be taken before it has read the last ones, so a tear as short as that may go unseen.
template <class T>
class Stamped {
 public:
  template <class... Arguments>
  explicit Stamped(Arguments&&... arguments) : value(std::forward<Arguments>(arguments)...) {}

  // Relaxed, all of them: if they ordered anything, they would hide from ThreadSanitizer that the exchange does not.
  void begin(std::int64_t number) noexcept { before_.store(number, std::memory_order_relaxed); }
  void end(std::int64_t number) noexcept { after_.store(number, std::memory_order_relaxed); }
  /// Whether the slot holds the whole of that value, and nobody has begun another.
  [[nodiscard]] bool holds(std::int64_t number) const noexcept {
    return number_written() == number && before_.load(std::memory_order_relaxed) == number;
  }
  /// Of the last value that was written to its end.
  [[nodiscard]] std::int64_t number_written() const noexcept { return after_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> before_{0};

 public:
  T value;

 private:
  std::atomic<std::int64_t> after_{0};
};

/// Hands values from one thread to another; the latest wins. Neither side ever waits: a call is at most one atomic
/// exchange, whatever the other thread does.
///
/// Three slots: the writer owns the draft, the reader the current one, and the middle one waits between them. Both
/// sides trade theirs for the middle one, so no slot ever has two owners. A draft still holds what was published some
/// values ago: values that own memory keep it.
template <class T>
class LatestValue {
 public:
  /// Makes every slot T(arguments...). Takes all memory.
  template <class... Arguments>
  explicit LatestValue(const Arguments&... arguments)
      : slots_{Slot(arguments...), Slot(arguments...), Slot(arguments...)} {
    slots_[draft_].begin(1);
  }

  /// Writer: the value to fill.
  [[nodiscard]] T& draft() noexcept { return slots_[draft_].value; }

  /// Writer: makes the draft the newest value, and begins another in a slot that nobody uses.
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
    // Relaxed: it only says whether to look; what it saw is exchanged below.
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

  /// Reader: the value of the last take(), or of the constructor. It does not change before the next take().
  [[nodiscard]] const T& current() const noexcept { return slots_[current_].value; }

  /// When both sides rest: what became of every value.
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
  static constexpr unsigned kFresh = 4;  // and whether its value has yet to be taken

  static_assert(std::atomic<unsigned>::is_always_lock_free);

  std::array<Slot, 3> slots_;
  alignas(kSeparate) std::atomic<unsigned> middle_{1};
  alignas(kSeparate) unsigned draft_ = 0;  // from here the writer's
  std::int64_t published_ = 0, superseded_ = 0;
  alignas(kSeparate) unsigned current_ = 2;  // from here the reader's
  std::int64_t number_ = 0, consumed_ = 0, torn_ = 0;
};

}  // namespace thenar
