// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/yaml_syntax.h"

#include <fmt/format.h>
#include <yaml-cpp/exceptions.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "engine/formats/text.h"

namespace thenar {

namespace {

constexpr const char* kBlanks = " \t\r";

/// A bracket or a quotation mark that is open.
struct Opened {
  char mark;
  int line, column;
};

char closing(char mark) { return mark == '[' ? ']' : mark == '{' ? '}' : mark; }

/// Goes through a text of YAML by its marks alone: brackets, quotation marks, and comments.
class MarkScanner {
 public:
  explicit MarkScanner(std::string_view text) : text_(text) {}

  /// Returns what is open in front of a place, the outermost first.
  std::vector<Opened> opened_before(int line, int column) {
    while (at_ < text_.size() && (line_ < line || (line_ == line && column_ < column))) {
      if (!opened_.empty() && closing(opened_.back().mark) == opened_.back().mark) {
        step_in_quotes(opened_.back().mark);
      } else {
        step_outside();
      }
    }
    return opened_;
  }

 private:
  [[nodiscard]] char next() const { return at_ + 1 < text_.size() ? text_[at_ + 1] : '\n'; }

  void advance() {
    ++column_;
    if (text_[at_++] != '\n') return;
    ++line_;
    column_ = 1;
  }

  void step_in_quotes(char mark) {
    const char c = text_[at_];
    const bool is_escape = (mark == '"' && c == '\\') || (mark == '\'' && c == '\'' && next() == '\'');
    if (c == mark && !is_escape) opened_.pop_back();
    advance();
    if (is_escape && at_ < text_.size()) advance();
    may_begin_ = false;
  }

  void step_outside() {
    const char c = text_[at_];
    const bool is_flow = !opened_.empty();
    if (c == '#' && (at_ == 0 || std::string_view(" \t\n").find(text_[at_ - 1]) != std::string_view::npos)) {
      while (at_ < text_.size() && text_[at_] != '\n') advance();
      return;
    }
    const bool opens_quotes = may_begin_ && (c == '"' || c == '\'');
    const bool opens_flow = (may_begin_ || is_flow) && (c == '[' || c == '{');
    if (opens_quotes || opens_flow) {
      opened_.push_back({c, line_, column_});
    } else if (is_flow && c == closing(opened_.back().mark)) {
      opened_.pop_back();
    }
    // A value begins behind these, and blanks.
    const bool is_mark =
        opens_flow || c == '\n' || (is_flow && c == ',') ||
        ((c == ':' || (c == '-' && may_begin_)) && std::string_view(" \t\r\n").find(next()) != std::string_view::npos);
    may_begin_ = is_mark || (may_begin_ && std::string_view(kBlanks).find(c) != std::string_view::npos);
    advance();
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1, column_ = 1;
  bool may_begin_ = true;  ///< A value may begin here.
  std::vector<Opened> opened_;
};

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// A line without what stands before and behind its words.
std::string_view stripped(std::string_view line) {
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == line.npos || line[first] == '#') return {};
  return line.substr(first, line.find_last_not_of(kBlanks) + 1 - first);
}

bool has_key(std::string_view line) { return line.find(": ") != line.npos || stripped(line).ends_with(':'); }

/// The fault of a ':' that the parser did not expect.
SyntaxFault colon_fault(const std::vector<std::string_view>& lines, int number, int column) {
  const std::string_view line = lines[static_cast<std::size_t>(number - 1)];
  if (line.substr(0, static_cast<std::size_t>(column - 1)).find(": ") != line.npos) {
    return {number, column, "a second ': ' stands in this line: put a text that holds one in quotation marks"};
  }
  int above = number - 1;
  while (above > 0 && stripped(lines[static_cast<std::size_t>(above - 1)]).empty()) --above;
  if (above > 0 && !has_key(lines[static_cast<std::size_t>(above - 1)])) {
    const std::string_view words = lines[static_cast<std::size_t>(above - 1)];
    return {above, static_cast<int>(words.find_first_not_of(kBlanks)) + 1,
            fmt::format("'{}' is no 'key: value': put a ':' and a blank behind the key", printable(stripped(words)))};
  }
  return {number, column, "this key stands deeper than the key above, which has a value: line up the two"};
}

/// What is wrong with a line that belongs to nothing above it.
std::string odd_line(std::string_view line, int column) {
  const std::size_t before = std::min(static_cast<std::size_t>(column - 1), line.size());
  if (!stripped(line.substr(0, before)).empty()) {
    return fmt::format("'{}' is not expected here: put the whole value in quotation marks",
                       printable(stripped(line.substr(before))));
  }
  if (stripped(line).starts_with("- ")) return "'- ' begins an item of a list, and keys stand around it: leave it out";
  return "does not line up with the keys above it: those of one map have the same number of blanks before them";
}

/// A tab before a key, in the line where the parser stopped or in one before it, whose maps it has ended.
std::optional<SyntaxFault> tab_before_key(std::string_view text, const std::vector<std::string_view>& lines,
                                          std::size_t last) {
  MarkScanner marks(text);
  for (std::size_t i = 0; i < std::min(last + 1, lines.size()); ++i) {
    const std::size_t tab = lines[i].find('\t');
    if (tab >= lines[i].find_first_not_of(kBlanks) || stripped(lines[i]).empty()) continue;
    // Within brackets and quotation marks lines may begin with anything.
    if (i != last && !marks.opened_before(static_cast<int>(i + 1), 1).empty()) continue;
    return SyntaxFault{static_cast<int>(i + 1), static_cast<int>(tab + 1), "a tab stands here: indent with blanks"};
  }
  return std::nullopt;
}

/// What is wrong with brackets, of which `opened` are open at the place.
std::string bracket_fault(const std::vector<Opened>& opened, char found, bool is_end) {
  if (opened.empty()) return fmt::format("this '{}' closes nothing: leave it out", found);
  const Opened& last = opened.back();
  if (!is_end) {
    return fmt::format("this '{}' cannot close the '{}' of line {}: write '{}'", found, last.mark, last.line,
                       closing(last.mark));
  }
  return fmt::format("',' or '{}' is missing before this: the '{}' of line {} is still open", closing(last.mark),
                     last.mark, last.line);
}

/// What is wrong at a place where the parser stopped for other reasons than a ':'.
std::string fault_at(std::string_view line, int column, const std::vector<Opened>& opened, const std::string& parser) {
  namespace words = YAML::ErrorMsg;
  const auto at = static_cast<std::size_t>(column - 1);
  const char found = at < line.size() ? line[at] : ' ';
  const bool is_end = parser == words::END_OF_MAP_FLOW || parser == words::END_OF_SEQ_FLOW;
  if ((is_end && !opened.empty()) || parser == words::FLOW_END) return bracket_fault(opened, found, is_end);
  if (parser == words::END_OF_MAP || parser == words::END_OF_SEQ) return odd_line(line, column);
  if (parser == words::UNKNOWN_TOKEN) return fmt::format("no value begins with '{}': put it in quotation marks", found);
  if (parser.starts_with(words::INVALID_ESCAPE)) {
    return "within \"...\" a backslash begins a sign of its own: write two of them, or put the text in '...'";
  }
  return parser == words::UNKNOWN_ANCHOR ? kNoAliases : "is no YAML: " + parser;
}

}  // namespace

SyntaxFault syntax_fault(std::string_view text, int line, int column, const std::string& parser) {
  const std::vector<std::string_view> lines = lines_of(text);
  if (auto fault = no_text(text)) return *std::move(fault);
  if (auto fault = unclosed_quotes(text)) return *std::move(fault);
  const auto number = static_cast<std::size_t>(line - 1);
  if (auto fault = tab_before_key(text, lines, number)) return *std::move(fault);
  if (parser == YAML::ErrorMsg::MAP_VALUE && number < lines.size()) return colon_fault(lines, line, column);
  const std::string_view here = number < lines.size() ? lines[number] : std::string_view();
  return {line, column, fault_at(here, column, MarkScanner(text).opened_before(line, column), parser)};
}

std::optional<SyntaxFault> no_text(std::string_view text) {
  const std::vector<std::string_view> lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t at = 0; at < lines[i].size(); ++at) {
      const std::size_t bad = first_unprintable(lines[i].substr(at));
      if (bad == lines[i].npos) break;
      at += bad;
      if (lines[i][at] == '\t' || lines[i][at] == '\r') continue;
      return SyntaxFault{
          static_cast<int>(i + 1), static_cast<int>(at + 1),
          fmt::format("is no text in UTF-8: it has the byte 0x{:02X} here", static_cast<unsigned char>(lines[i][at]))};
    }
  }
  return std::nullopt;
}

std::optional<SyntaxFault> unclosed_quotes(std::string_view text) {
  const std::vector<Opened> opened = MarkScanner(text).opened_before(std::numeric_limits<int>::max(), 1);
  if (opened.empty() || closing(opened.back().mark) != opened.back().mark) return std::nullopt;
  return SyntaxFault{opened.back().line, opened.back().column, "the quotation mark that stands here is not closed"};
}

}  // namespace thenar
