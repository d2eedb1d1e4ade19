#pragma once

#include <string>

namespace thenar::app {

/// What is said of a tick and of a run, as documents: all of it from the rows of tick_fields() and measure_sections().

/// The page docs/reference/fields.md.
[[nodiscard]] std::string fields_as_markdown();

/// The properties of Simulation in the stub python/thenar/_core.pyi, one after the other.
[[nodiscard]] std::string fields_as_stub();

/// The page docs/reference/measures.md.
[[nodiscard]] std::string measures_as_markdown();

}  // namespace thenar::app
