#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>

namespace thenar {

/// The records of one thread on their way to another, in a ring of fixed size that neither side waits for.
template <class Record>
class Records {
 public:
  /// Has room for so many. Takes all memory: what a copy of a record takes by itself is not included.
  Records(std::size_t room, const Record& blank) : ring_(room) {
    // Every page is used once, so that the thread that records need not be the first.
    while (ring_.push(blank)) {
    }
    ring_.reset();
  }

  /// Writer: false if there is no room.
  bool keep(const Record& record) { return ring_.push(record); }

  /// Reader: gives every record that is there to `receive`, in order. One at whose receipt it throws stays, and so do
  /// those behind it.
  template <class Receive>
  void drain(const Receive& receive) {
    // Not by Boost's consume_all, which destroys one record after another and moves on when it has done all: after an
    // exception it would destroy them once more.
    for (std::size_t waiting = ring_.read_available(); waiting > 0; --waiting) {
      receive(ring_.front());
      ring_.pop();
    }
  }

 private:
  boost::lockfree::spsc_queue<Record> ring_;
};

}  // namespace thenar
