// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/formats/contact_block.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/loops/picture.h"
#include "engine/loops/slot_ring.h"

namespace thenar {

/// All contacts of one tick.
struct TickContacts {
  explicit TickContacts(const Model& model) : contacts(static_cast<std::size_t>(model.max_contacts)) {}

  std::int64_t tick = 0;      ///< Number of steps at its end.
  std::int64_t sequence = 0;  ///< Number of the frame: contacts are the same while it is in use.
  std::size_t count = 0;      ///< Number of `contacts` in this tick.
  std::vector<TickContact> contacts;
};

/// Copies the contacts from the state after a tick and from that tick's workspace. Does not allocate, lock or throw.
void take_contacts(const State& state, const ContactMemory& memory, const ContactScratch& work,
                   TickContacts& to) noexcept;

/// The data of a recording from a contact loop: pictures of some ticks, and on request all contacts of every tick. They
/// pass through rings that never block either side; losses are counted.
class FilmTap {
 public:
  /// Allocates all memory: for the contacts of two seconds, and for the pictures of one, at most 1000.
  FilmTap(const Model& model, std::int64_t picture_ticks, bool contacts);

  /// Records a tick, on the contact thread. Does not allocate, lock, throw or call the system.
  void keep(const State& state, const ContactMemory& memory, const ContactScratch& work,
            const std::optional<ShownPull>& pull) noexcept;

  // For one other thread.
  SlotRing<Picture> pictures;
  SlotRing<TickContacts> contacts;
  /// Returns the picture of a tick, if taken, and drops those of ticks before it. It is valid until pictures.pop().
  [[nodiscard]] const Picture* picture_of(std::int64_t tick);
  [[nodiscard]] std::int64_t lost_pictures() const { return lost_pictures_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t lost_contacts() const { return lost_contacts_.load(std::memory_order_relaxed); }

 private:
  std::int64_t picture_ticks_;
  bool with_contacts_;
  // Relaxed: they order nothing else.
  std::atomic<std::int64_t> lost_pictures_{0}, lost_contacts_{0};
};

}  // namespace thenar
