#pragma once

#include <string>

namespace thenar::app {

/// What is said of a tick, of a run and of a found grasp, as documents: all of it from the rows of tick_fields(),
/// measure_sections() and grasp_measures().

/// The page docs/reference/fields.md.
[[nodiscard]] std::string fields_as_markdown();

/// The properties of Simulation in the stub python/thenar/_core.pyi, an empty line, and the measures of Grasp there.
[[nodiscard]] std::string fields_as_stub();

/// The page docs/reference/measures.md.
[[nodiscard]] std::string measures_as_markdown();

}  // namespace thenar::app
