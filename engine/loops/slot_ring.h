#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <vector>

namespace thenar {

/// Values on their way from one thread to another, in order, in places of fixed number whose memory is taken once: for
/// what is too large to be copied, or has memory of its own. Neither side waits.
template <class Slot>
class SlotRing {
 public:
  /// `make()` gives a value that has all the memory it will need, and has touched it.
  template <class Make>
  SlotRing(std::size_t room, const Make& make) : ready_(room + 1), free_(room + 1) {
    slots_.reserve(room);
    for (std::size_t i = 0; i < room; ++i) slots_.push_back(make());
    for (Slot& slot : slots_) free_.push(&slot);
  }

  /// Writer: a place to be filled; null if there is no room.
  [[nodiscard]] Slot* draft() noexcept {
    if (draft_ == nullptr && !free_.pop(draft_)) draft_ = nullptr;
    return draft_;
  }
  /// Writer: passes on what the last draft() gave, which was not null.
  void publish() noexcept {
    ready_.push(draft_);  // It has room for all there are.
    draft_ = nullptr;
  }

  /// Reader: the oldest value; null if there is none. It stays the reader's until pop().
  [[nodiscard]] const Slot* front() { return ready_.read_available() > 0 ? ready_.front() : nullptr; }
  /// Reader: gives back what front() gave.
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
