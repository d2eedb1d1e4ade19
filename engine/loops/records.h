// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>

namespace thenar {

/// A ring of records from one thread to another, of fixed size; neither side waits.
template <class Record>
class Records {
 public:
  /// Allocates room for so many records, without memory that a copy of a record allocates itself.
  Records(std::size_t room, const Record& blank) : ring_(room) {
    // Touches every page once, so that the recording thread need not.
    while (ring_.push(blank)) {
    }
    ring_.reset();
  }

  /// Writer: adds a record; false if there is no room.
  bool keep(const Record& record) { return ring_.push(record); }

  /// Reader: passes all present records to `receive`, in order. If it throws, that record and those behind it stay.
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
