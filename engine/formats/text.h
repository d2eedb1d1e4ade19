#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace thenar {

/// Where the first byte is that is no part of a character in UTF-8, or is of a control character (U+0000 to U+001F,
/// U+007F to U+009F); npos: there is none. JSON holds no other bytes, and a terminal obeys control characters.
[[nodiscard]] std::size_t first_unprintable(std::string_view text);

/// The text with each such byte as "\xE9".
[[nodiscard]] std::string printable(std::string_view text);

/// The text as a cell of a table of comma-separated values: in quotes where it needs them (RFC 4180).
[[nodiscard]] std::string csv_cell(const std::string& text);

/// The text in double quotes, as YAML reads it.
[[nodiscard]] std::string quoted(const std::string& words);

/// "1 hold", "2 holds".
[[nodiscard]] std::string counted(std::int64_t number, std::string_view what);

/// The words with the separator between them.
[[nodiscard]] std::string join(std::span<const std::string_view> words, std::string_view separator);

/// The candidate that the word may be a slip of: the first of those with the fewest wrong letters; empty if none is
/// near.
[[nodiscard]] std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates);

/// ", did you mean 'x'?", or nothing for an empty word.
[[nodiscard]] std::string did_you_mean(std::string_view nearest);

}  // namespace thenar
