// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace thenar {

/// What is said of an alias.
inline constexpr const char* kNoAliases = "aliases are not read here: write the value out";

struct SyntaxFault {
  int line = 1, column = 1;
  std::string message;
};

/// Returns the fault of a text that is no YAML in plain words: what is wrong, and what would mend it. `parser` is what
/// the parser says, and the place is where it stopped, which may be behind the line that is at fault.
[[nodiscard]] SyntaxFault syntax_fault(std::string_view text, int line, int column, const std::string& parser);

/// Returns the fault of the first byte that no text of YAML has.
[[nodiscard]] std::optional<SyntaxFault> no_text(std::string_view text);

/// Returns the fault of a quotation mark that nothing closes: the parser takes the rest of the file for its text.
[[nodiscard]] std::optional<SyntaxFault> unclosed_quotes(std::string_view text);

}  // namespace thenar
