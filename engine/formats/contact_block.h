#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace thenar {

/// One contact in one tick, in numbers as short as they are recorded.
struct TickContact {
  std::uint16_t finger = 0, control_point = 0;
  float force_N[3] = {};  ///< On the object, along n, t1, t2.
  float slip_m[2] = {};   ///< In this tick, along t1, t2: of the object's surface against the pulp's.
  float point_m[3] = {}, normal[3] = {}, tangent[3] = {};  ///< Where it is, n and t1: world, as the tick began.
};

/// The same contacts in ticks that follow one another, as a message of a recording has them: the topic /contacts in
/// docs/reference/recordings.md.
struct ContactBlock {
  double time_s = 0.0, step_s = 0.0;  ///< When its first tick ended; from one tick to the next.
  std::uint32_t contacts = 0, ticks = 0;
  std::vector<TickContact> rows;  ///< Tick by tick. Place and axes are those of the first tick in all of them.

  /// A tick more, with as many contacts as the block has.
  void add(std::span<const TickContact> tick);
};

[[nodiscard]] std::string contact_block_message(const ContactBlock& block);

/// Of a message; a block without ticks if it is none.
[[nodiscard]] ContactBlock read_contact_block(std::string_view bytes);

}  // namespace thenar
