// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace thenar {

/// One contact in one tick, in the short numbers of recordings.
struct TickContact {
  std::uint16_t finger = 0, control_point = 0;
  float force_N[3] = {};  ///< Force on the object, along n, t1, t2.
  float slip_m[2] = {};   ///< Slip in this tick along t1, t2, of the object's surface relative to the pulp's.
  float point_m[3] = {}, normal[3] = {}, tangent[3] = {};  ///< Point, n and t1: world axes, at the tick's begin.
};

/// The same contacts in consecutive ticks, a message of a recording: the topic /contacts in
/// docs/reference/recordings.md.
struct ContactBlock {
  double time_s = 0.0, step_s = 0.0;  ///< End of its first tick; time between ticks.
  std::uint32_t contacts = 0, ticks = 0;
  std::vector<TickContact> rows;  ///< Tick by tick. Points and axes are those of the first tick in all of them.

  /// Adds a tick, with as many contacts as the block has.
  void add(std::span<const TickContact> tick);
};

[[nodiscard]] std::string contact_block_message(const ContactBlock& block);

/// Reads a message; returns a block without ticks if it is invalid.
[[nodiscard]] ContactBlock read_contact_block(std::string_view bytes);

}  // namespace thenar
