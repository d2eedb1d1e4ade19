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

/// The words of a line, between blanks.
[[nodiscard]] std::vector<std::string_view> words_of(std::string_view line);

/// The number that a whole word is, or nothing.
template <typename Number>
[[nodiscard]] std::optional<Number> number_in(std::string_view word) {
  Number number{};
  const char* const last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), last, number);
  if (error != std::errc() || end != last) return std::nullopt;
  return number;
}

/// A file's bytes, read from the front. What goes wrong is told with the line or the byte, as a FileError. It refers to
/// the bytes and the name.
class ByteSource {
 public:
  ByteSource(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  [[nodiscard]] std::size_t left() const { return bytes_.size() - position_; }
  [[nodiscard]] std::string_view rest() const { return bytes_.substr(position_); }

  [[noreturn]] void fail_at_line(const std::string& what) const;
  [[noreturn]] void fail_at_byte(const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const;

  /// The next line without its end. A last line without an end may have been cut, so it is refused.
  std::string_view take_line();
  /// The next line, whether or not it has an end. Nothing at the end of the file.
  std::optional<std::string_view> take_any_line();
  /// The next `size` bytes. `what` they are is told if they are missing.
  std::string_view take(std::size_t size, const std::string& what);

  /// A finite number that a word of the last line is.
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
