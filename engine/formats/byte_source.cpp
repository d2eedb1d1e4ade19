#include "engine/formats/byte_source.h"

#include <algorithm>
#include <cmath>

#include "engine/formats/files.h"

namespace thenar {

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == line.npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

void ByteSource::fail_at_line(const std::string& what) const {
  throw FileError(file_, "line " + std::to_string(line_) + ": " + what);
}

void ByteSource::fail_at_byte(const std::string& what) const {
  throw FileError(file_, "byte " + std::to_string(position_) + ": " + what);
}

void ByteSource::fail(const std::string& what) const { throw FileError(file_, what); }

std::string_view ByteSource::take_line() {
  const bool has_end = rest().find('\n') != std::string_view::npos;
  const auto line = take_any_line();
  if (!line) ++line_;
  if (!has_end) fail_at_line("the file is truncated: it ends here");
  return *line;
}

std::optional<std::string_view> ByteSource::take_any_line() {
  if (left() == 0) return std::nullopt;
  ++line_;
  const std::size_t end = std::min(bytes_.find('\n', position_), bytes_.size());
  const std::string_view line = bytes_.substr(position_, end - position_);
  position_ = std::min(end + 1, bytes_.size());
  return line;
}

std::string_view ByteSource::take(std::size_t size, const std::string& what) {
  if (left() < size) fail_at_byte("the file is truncated: " + what);
  const std::string_view bytes = bytes_.substr(position_, size);
  position_ += size;
  return bytes;
}

double ByteSource::finite(std::string_view word) const {
  const auto number = number_in<double>(word);
  if (!number) fail_at_line("'" + std::string(word) + "' is not a number");
  if (!std::isfinite(*number)) fail_at_line("'" + std::string(word) + "' is not finite: leave such points out");
  return *number;
}

void ByteSource::expect_blank_rest() {
  if (rest().find_first_not_of(" \t\r\n") == std::string_view::npos) return;
  ++line_;
  fail_at_line("the header declares less than the file holds");
}

}  // namespace thenar
