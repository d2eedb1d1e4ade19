// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thenar::app {

// Output of `thenar keys` and `thenar schema`, from the table of keys (engine/scenes/keys.h).

/// Returns the keys of scenes at and below `prefix`, all for "", a line each. Throws ConfigError if there is none.
[[nodiscard]] std::string keys_as_text(const std::string& prefix);

/// Returns all keys of scenes as a page: docs/reference/scene.md.
[[nodiscard]] std::string keys_as_markdown();

/// Returns the JSON Schema of scenes, draft 2020-12: docs/reference/scene.schema.json.
[[nodiscard]] std::string keys_as_schema();

}  // namespace thenar::app
