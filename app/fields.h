#pragma once

#include <string>

namespace thenar::app {

/// What is said of a tick, as documents: all of it from the rows of tick_fields().

/// The page docs/reference/fields.md.
[[nodiscard]] std::string fields_as_markdown();

/// The properties of Simulation in the stub python/thenar/_core.pyi, one after the other.
[[nodiscard]] std::string fields_as_stub();

}  // namespace thenar::app
