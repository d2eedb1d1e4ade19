// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace thenar {

/// Splits a line at blanks into words; ends of lines are blanks, too.
[[nodiscard]] std::vector<std::string_view> words_of(std::string_view line);

/// Returns the number that a whole word represents, or nothing. It may have a sign, also a plus.
template <typename Number>
[[nodiscard]] std::optional<Number> number_in(std::string_view word) {
  Number number{};
  const char* const last = word.data() + word.size();
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), last, number);
  if (error != std::errc() || end != last) return std::nullopt;
  return number;
}

/// A sequential reader of a file's bytes. Errors are FileErrors with line or byte. A view of bytes and name.
/// Lines end with a line feed, with or without a carriage return before it; or, as in files of the first Macintosh,
/// with a carriage return alone.
class ByteSource {
 public:
  ByteSource(const std::filesystem::path& file, std::string_view bytes);

  [[nodiscard]] std::size_t left() const { return bytes_.size() - position_; }
  [[nodiscard]] std::string_view rest() const { return bytes_.substr(position_); }

  [[noreturn]] void fail_at_line(const std::string& what) const;
  [[noreturn]] void fail_at_byte(const std::string& what) const;
  /// Fails at what was taken last: a line, or bytes.
  [[noreturn]] void fail_here(const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const;
  /// Fails at the last line, of which this word should be a number.
  [[noreturn]] void fail_as_number(std::string_view word) const;

  /// Takes the next line without its end; the last one may have none. At the end of the file it fails.
  std::string_view take_line();
  /// Takes the next line, with or without an end; nothing at the end of the file.
  std::optional<std::string_view> take_any_line();
  /// Takes the next `size` bytes; the error for missing ones names `what` they are.
  std::string_view take(std::size_t size, const std::string& what);

  /// Returns the finite number that a word of the last line represents.
  [[nodiscard]] double finite(std::string_view word) const;
  /// Tests whether all that follows is blanks and zero bytes, as files are padded with.
  [[nodiscard]] bool has_blank_rest() const;

 private:
  const std::filesystem::path& file_;
  std::string_view bytes_;
  char line_end_ = '\n';
  std::size_t position_ = 0;
  std::size_t line_ = 0;
  bool takes_lines_ = true;
};

}  // namespace thenar
