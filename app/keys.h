#pragma once

#include <string>

namespace thenar::app {

// What `thenar keys` and `thenar schema` print, of the table of keys (engine/scenes/keys.h).

/// The keys of scenes at and below `prefix`, or all of them for "", a line each. Throws ConfigError if there is none.
[[nodiscard]] std::string keys_as_text(const std::string& prefix);

/// All keys of scenes as a page: docs/reference/scene.md.
[[nodiscard]] std::string keys_as_markdown();

/// The JSON Schema of scenes, draft 2020-12: docs/reference/scene.schema.json.
[[nodiscard]] std::string keys_as_schema();

}  // namespace thenar::app
