// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/recordings/state_message.h"

namespace thenar {

/// Names of the owners of a state's numbers.
struct SignalNames {
  std::vector<std::string> fingers, joints, muscles, bodies;
};
[[nodiscard]] SignalNames signal_names(const Model& model);
/// Returns the names of a recording's scene. One that was made before 0.8 does not name its joints.
[[nodiscard]] SignalNames signal_names(const nlohmann::ordered_json& scene);

/// A number of a state in the words and units of signals.csv: "thumb_normal_N", "position_x_mm".
struct SignalColumn {
  std::string name, unit;  ///< Unit: empty for a plain number.
  std::size_t at = 0;      ///< Index in the state message.
  double factor = 1.0;     ///< Factor by which the number is multiplied.
};

/// Name of the field `muscles_N` of recordings before version 3 whose muscles had stiffness, as it is read: it lacked
/// what the stretch adds.
inline constexpr const char* kUnstretched = "muscles_unstretched_N";

/// Returns true if the numbers of a field have names; those of shapes have none.
[[nodiscard]] bool is_signal(const Field& field);

/// Number i of a field; where the field is unknown, or has no such number, by the field's own name.
[[nodiscard]] SignalColumn signal_column(const Field& field, std::size_t i, const SignalNames& names);

/// All such fields, number by number. Names of fields may be those of a recording made before 0.8.
[[nodiscard]] std::vector<SignalColumn> signal_columns(const std::vector<Field>& fields, const SignalNames& names);

}  // namespace thenar
