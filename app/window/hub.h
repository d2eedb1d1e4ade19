// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "app/window/message.h"
#include "app/window/stream.h"

namespace thenar::window {

class PageLink;

/// A message to pages, never changed, so that it may be on its way to any number of them; the number grows with
/// each new one, 0: there was none.
struct Shown {
  std::shared_ptr<const std::string> bytes;
  std::int64_t number = 0;
};

/// Messages shown to pages: the newest of each kind alone.
struct News {
  Shown scene, geometry, status, grasps, state;
};

/// State shared by the links to all pages.
struct Hub {
  Receive receive;
  std::chrono::nanoseconds patience{};  ///< Longest time before an exchange has failed.

  std::mutex mutex;  ///< Guards the two below it; the calling thread writes them, the server's reads them.
  News news;
  bool told = true;  ///< The server's thread has taken notice of the last change.

  // The server's thread alone:
  std::set<PageLink*> links;
  std::vector<Stream*> strangers;  ///< Connections that have not shown their admission yet, the oldest first.
  int guests = 0;                  ///< Number of admitted connections: pages, and answers under way.
  std::atomic<int> pages = 0;

  News newest() {
    const std::lock_guard lock(mutex);
    return news;
  }
};

/// One of the guests, while it lives.
class Seat {
 public:
  explicit Seat(Hub& hub) : hub_(hub) { ++hub_.guests; }
  ~Seat() { --hub_.guests; }
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

 private:
  Hub& hub_;
};

}  // namespace thenar::window
