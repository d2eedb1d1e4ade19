#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/scenes/yaml_tree.h"

namespace thenar {

/// What is said of a quotation mark that nothing closes.
inline constexpr const char* kUnclosed = "the quotation mark that stands here is not closed";

/// Returns the fault of a text that is no YAML in plain words: what is wrong, and what would mend it. `parser` and
/// `place` are the parser's words and where it stopped, which may be behind the line that is at fault.
[[nodiscard]] YamlFault syntax_fault(std::string_view text, const Place& place, const std::string& parser);

/// Returns the place of the quotation mark that nothing closes; the parser takes the rest of the file for its text.
[[nodiscard]] std::optional<Place> unclosed_quotes(std::string_view text, std::size_t source);

}  // namespace thenar
