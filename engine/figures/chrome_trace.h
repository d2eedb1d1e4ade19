// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/results/profile.h"

namespace thenar {

/// The last `duration_s` of a profile in Chrome's trace event format, which Perfetto and chrome://tracing open:
/// a thread each for contact and control, a complete event a tick, the stages of a control tick inside it, and arrows
/// from the tick that published a frame or snapshot to the tick that used it first. Times in us from the first tick on.
///
/// Order and length of the stages are measured, not the start: they stand end to end from the start of their tick.
[[nodiscard]] std::string chrome_trace(const Model& model, const LoopProfile& profile, double duration_s);

}  // namespace thenar
