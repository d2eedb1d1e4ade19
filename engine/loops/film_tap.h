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

  std::int64_t tick = 0;      ///< Steps taken when it had ended.
  std::int64_t sequence = 0;  ///< Of the frame: while it is in use, the contacts are the same ones.
  std::size_t count = 0;      ///< So many of `contacts` are of this tick.
  std::vector<TickContact> contacts;
};

/// Fills it from the state that a tick left and what that tick worked in. Does not allocate, lock or throw.
void take_contacts(const State& state, const ContactMemory& memory, const ContactScratch& work,
                   TickContacts& to) noexcept;

/// What a recording takes from a contact loop: pictures of some ticks, and if it wants them all contacts of every tick.
/// They go through rings that neither side waits for; what finds no room is counted.
class FilmTap {
 public:
  /// Takes all memory: for the contacts of two seconds, and for as many pictures as come in one, at most 1000.
  FilmTap(const Model& model, std::int64_t picture_ticks, bool contacts);

  /// After a tick, on the contact thread. Does not allocate, lock, throw or call the system.
  void keep(const State& state, const ContactMemory& memory, const ContactScratch& work,
            const std::optional<ShownPull>& pull) noexcept;

  // For one other thread.
  SlotRing<Picture> pictures;
  SlotRing<TickContacts> contacts;
  /// The picture of a tick, if one was taken; those of ticks before it are let go. It is there until pictures.pop().
  [[nodiscard]] const Picture* picture_of(std::int64_t tick);
  [[nodiscard]] std::int64_t lost_pictures() const { return lost_pictures_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t lost_contacts() const { return lost_contacts_.load(std::memory_order_relaxed); }

 private:
  std::int64_t picture_ticks_;
  bool with_contacts_;
  // Relaxed: nothing else goes with them.
  std::atomic<std::int64_t> lost_pictures_{0}, lost_contacts_{0};
};

}  // namespace thenar
