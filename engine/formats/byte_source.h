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

/// Splits a line at blanks into words.
[[nodiscard]] std::vector<std::string_view> words_of(std::string_view line);

/// Returns the number that a whole word represents, or nothing.
template <typename Number>
[[nodiscard]] std::optional<Number> number_in(std::string_view word) {
  Number number{};
  const char* const last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), last, number);
  if (error != std::errc() || end != last) return std::nullopt;
  return number;
}

/// A sequential reader of a file's bytes. Errors are FileErrors with the line or the byte. A view of the bytes and the
/// name.
class ByteSource {
 public:
  ByteSource(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  [[nodiscard]] std::size_t left() const { return bytes_.size() - position_; }
  [[nodiscard]] std::string_view rest() const { return bytes_.substr(position_); }

  [[noreturn]] void fail_at_line(const std::string& what) const;
  [[noreturn]] void fail_at_byte(const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const;

  /// Takes the next line without its end. A last line without an end may have been truncated, so it is refused.
  std::string_view take_line();
  /// Takes the next line, with or without an end; nothing at the end of the file.
  std::optional<std::string_view> take_any_line();
  /// Takes the next `size` bytes; the error for missing ones names `what` they are.
  std::string_view take(std::size_t size, const std::string& what);

  /// Returns the finite number that a word of the last line represents.
  [[nodiscard]] double finite(std::string_view word) const;
  /// Fails if a line after the last one holds more than blanks.
  void expect_blank_rest();

 private:
  const std::filesystem::path& file_;
  std::string_view bytes_;
  std::size_t position_ = 0;
  std::size_t line_ = 0;
};

}  // namespace thenar
