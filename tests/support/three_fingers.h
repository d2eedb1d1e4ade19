// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thenar {

// The hand of the shipped scenes: thumb, index and major.
inline constexpr int kFingers = 3, kJointsPerFinger = 4, kJoints = kFingers * kJointsPerFinger;

}  // namespace thenar
