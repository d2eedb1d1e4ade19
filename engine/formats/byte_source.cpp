// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/byte_source.h"

#include <algorithm>
#include <cmath>

#include "engine/formats/files.h"
#include "engine/formats/text.h"

namespace thenar {

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t begin = line.find_first_not_of(" \t\r\n\v\f");
    if (begin == line.npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t\r\n\v\f", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

ByteSource::ByteSource(const std::filesystem::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {
  const std::size_t feed = bytes.find('\n'), first = bytes.substr(0, feed).find('\r');
  if (first == bytes.npos || first + 1 == feed) return;
  // A carriage return within one line is none of its ends; two before the first line feed are.
  const bool again = bytes.substr(0, feed).find('\r', first + 1) != bytes.npos;
  if (again || feed == bytes.npos) line_end_ = '\r';
}

void ByteSource::fail_at_line(const std::string& what) const {
  throw FileError(file_, "line " + std::to_string(line_) + ": " + what);
}

void ByteSource::fail_at_byte(const std::string& what) const {
  throw FileError(file_, "byte " + std::to_string(position_) + ": " + what);
}

void ByteSource::fail_here(const std::string& what) const { takes_lines_ ? fail_at_line(what) : fail_at_byte(what); }

void ByteSource::fail(const std::string& what) const { throw FileError(file_, what); }

std::string_view ByteSource::take_line() {
  if (const auto line = take_any_line()) return *line;
  ++line_;
  fail_at_line("the file is truncated: it ends here");
}

std::optional<std::string_view> ByteSource::take_any_line() {
  takes_lines_ = true;
  if (left() == 0) return std::nullopt;
  ++line_;
  const std::size_t end = std::min(bytes_.find(line_end_, position_), bytes_.size());
  const std::string_view line = bytes_.substr(position_, end - position_);
  position_ = std::min(end + 1, bytes_.size());
  return line;
}

std::string_view ByteSource::take(std::size_t size, const std::string& what) {
  takes_lines_ = false;
  if (left() < size) fail_at_byte("the file is truncated: " + what);
  const std::string_view bytes = bytes_.substr(position_, size);
  position_ += size;
  return bytes;
}

void ByteSource::fail_as_number(std::string_view word) const {
  const bool has_comma = word.find(',') != word.npos;
  fail_at_line("'" + printable(word) + "' is not a number" +
               (has_comma ? ": write a point in place of the comma" : ""));
}

double ByteSource::finite(std::string_view word) const {
  const auto number = number_in<double>(word);
  if (!number) fail_as_number(word);
  if (!std::isfinite(*number)) fail_at_line("'" + std::string(word) + "' is not finite: leave such points out");
  return *number;
}

bool ByteSource::has_blank_rest() const {
  return rest().find_first_not_of(std::string_view(" \t\r\n\v\f\0\x1a", 8)) == std::string_view::npos;
}

}  // namespace thenar
