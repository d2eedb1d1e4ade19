// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thenar::app {

/// Documents on the fields of a tick and the measures of a run and of a found grasp, all from the rows of
/// tick_fields(), measure_sections() and grasp_measures().

/// Returns the page docs/reference/fields.md.
[[nodiscard]] std::string fields_as_markdown();

/// Returns the properties of Simulation in the stub python/thenar/_core.pyi, an empty line, and the measures of Grasp.
[[nodiscard]] std::string fields_as_stub();

/// Returns the page docs/reference/measures.md.
[[nodiscard]] std::string measures_as_markdown();

}  // namespace thenar::app
