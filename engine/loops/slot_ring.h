// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <vector>

namespace thenar {

/// A ring of values from one thread to another, in order, in a fixed number of slots whose memory is allocated once:
/// for values that are too large to copy, or own memory. Neither side waits.
template <class Slot>
class SlotRing {
 public:
  /// `make()` returns a value with all memory that it will need, already touched.
  template <class Make>
  SlotRing(std::size_t room, const Make& make) : ready_(room + 1), free_(room + 1) {
    slots_.reserve(room);
    for (std::size_t i = 0; i < room; ++i) slots_.push_back(make());
    for (Slot& slot : slots_) free_.push(&slot);
  }

  /// Writer: returns a slot to be filled; null if there is no room.
  [[nodiscard]] Slot* draft() noexcept {
    if (draft_ == nullptr && !free_.pop(draft_)) draft_ = nullptr;
    return draft_;
  }
  /// Writer: passes on the slot of the last draft(), which was not null.
  void publish() noexcept {
    ready_.push(draft_);  // It has room for all slots.
    draft_ = nullptr;
  }

  /// Reader: returns the oldest value; null if there is none. It belongs to the reader until pop().
  [[nodiscard]] const Slot* front() { return ready_.read_available() > 0 ? ready_.front() : nullptr; }
  /// Reader: returns the slot of front() to the ring.
  void pop() {
    free_.push(ready_.front());
    ready_.pop();
  }

 private:
  std::vector<Slot> slots_;
  boost::lockfree::spsc_queue<Slot*> ready_, free_;
  Slot* draft_ = nullptr;  ///< The writer's.
};

}  // namespace thenar
