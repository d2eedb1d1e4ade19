// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/formats/mcap_file.h"
#include "engine/recordings/signal_columns.h"
#include "engine/recordings/state_message.h"

namespace thenar {

// In the order of the channels.
enum class RecordingTopic : std::size_t {
  kScene,
  kGeometry,
  kState,
  kSignals,
  kStatus,
  kContacts,
  kFrames,
  kHand,
  kObject,
  kForces,
  kPressures,
  kLog
};

/// The JSON Schema of messages like this one, as viewers accept it: a type for each member, members of a list alike.
/// Anything it has no word for is left out, and is allowed: null, empty lists, lists of lists.
[[nodiscard]] nlohmann::ordered_json schema_like(const nlohmann::ordered_json& message);

/// The topics of a recording with their schemas: docs/reference/recordings.md. `scene`: its first message.
[[nodiscard]] std::vector<McapChannel> recording_channels(const nlohmann::ordered_json& scene,
                                                          const std::vector<Field>& fields,
                                                          const std::vector<SignalColumn>& columns);

/// JSON has no word for an unknown number: members that are null or no finite number are left out, at any depth.
[[nodiscard]] nlohmann::ordered_json without_unknowns(const nlohmann::ordered_json& message);

}  // namespace thenar
