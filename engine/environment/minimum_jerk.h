// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thenar {

/// Returns the completed fraction of a minimum-jerk move after a fraction s of its time: 10 s^3 - 15 s^4 + 6 s^5, from
/// 0 to 1 with no velocity and acceleration at both ends [Flash, Hogan 1985]. It is 0 before the move and 1 after it.
/// Used by targets, bodies of the environment, the arm and fingertips on paths.
[[nodiscard]] double minimum_jerk(double s);

/// Returns the derivative of minimum_jerk() by s: 30 s^2 (1 - s)^2, 0 before and after the move.
[[nodiscard]] double minimum_jerk_rate(double s);

/// The largest rate, at s = 1/2: a move's largest speed over its mean speed.
inline constexpr double kMinimumJerkPeak = 1.875;

}  // namespace thenar
