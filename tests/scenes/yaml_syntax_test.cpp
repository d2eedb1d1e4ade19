// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/yaml_syntax.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/scenes/yaml_tree.h"

namespace thenar::yaml_syntax_test {
namespace {

/// What is wrong with a text: "line:column: message".
std::string fault(const std::string& text) {
  std::vector<YamlFault> faults;
  (void)read_yaml(text, 0, faults);
  if (faults.empty()) return "";
  EXPECT_EQ(faults.size(), 1U) << text;
  const YamlFault& first = faults.front();
  return std::to_string(first.place.line) + ":" + std::to_string(first.place.column) + ": " + first.message;
}

// The place is that of the line to be mended, which may be above the one where the parser stops.
TEST(YamlSyntax, SaysWhatWouldMendALine) {
  const std::string line_up =
      "does not line up with the keys above it: those of one map have the same number of blanks before them";
  const std::string quotes = "a second ': ' stands in this line: put a text that holds one in quotation marks";
  EXPECT_EQ(fault("a:\n  b: 1\n c: 2\n"), "3:2: " + line_up);
  EXPECT_EQ(fault("a:\n  b: 1\n\tc: 2\n"), "3:1: a tab stands here: indent with blanks");
  EXPECT_EQ(fault("a:\n\tb: 1\n\tc: 2\nd: 3\n"), "2:1: a tab stands here: indent with blanks");
  EXPECT_EQ(fault("a:\n  b: 1\n \tc: 2\nd: 3\n e: 4\n"), "3:2: a tab stands here: indent with blanks");
  EXPECT_EQ(fault("a: [1,\n\t2]\nb: 1\n c: 2\n").substr(0, 2), "4:") << "within brackets a tab is a blank";
  EXPECT_EQ(fault("a: 1\n- b\n"), "2:1: '- ' begins an item of a list, and keys stand around it: leave it out");
  EXPECT_EQ(fault("a: 1\n  b: 2\n"),
            "2:4: this key stands deeper than the key above, which has a value: line up the two");
  EXPECT_EQ(fault("a: \"b\" c\n"), "1:8: 'c' is not expected here: put the whole value in quotation marks");
  EXPECT_EQ(fault("a: b: c\n"), "1:5: " + quotes);
  EXPECT_EQ(fault("a:1\nb: 2\n"), "1:1: 'a:1' is no 'key: value': put a ':' and a blank behind the key");
  EXPECT_EQ(fault("a: 1\n<<<<<<< HEAD\n\nb: 2\n"),
            "2:1: '<<<<<<< HEAD' is no 'key: value': put a ':' and a blank behind the key");
  EXPECT_EQ(fault("a: %1\n"), "1:4: no value begins with '%': put it in quotation marks");
  EXPECT_EQ(fault("a: *b\n"), "1:4: aliases are not read here: write the value out");
  EXPECT_EQ(fault("a: \"C:\\object\"\n"),
            "1:9: within \"...\" a backslash begins a sign of its own: write two of them, "
            "or put the text in '...'");
  EXPECT_EQ(fault("a: 1\n%PDF\x80\n: b: [\n"), "2:5: is no text in UTF-8: it has the byte 0x80 here");
}

TEST(YamlSyntax, NamesTheBracketThatIsOpen) {
  EXPECT_EQ(fault("a: [1, 2\nb: 3\n"), "2:2: ',' or ']' is missing before this: the '[' of line 1 is still open");
  EXPECT_EQ(fault("a: {b: 1 c: 2}\n"), "1:11: ',' or '}' is missing before this: the '{' of line 1 is still open");
  EXPECT_EQ(fault("# {\na: {b: [1, 2], c: '}'\n"),
            "3:1: ',' or '}' is missing before this: the '{' of line 2 is still open");
  EXPECT_EQ(fault("a: [1, 2}\n"), "1:9: this '}' cannot close the '[' of line 1: write ']'");
  EXPECT_EQ(fault("a: {b: 1}}\n"), "1:10: this '}' closes nothing: leave it out");
}

// The parser takes all that follows for the text, and says nothing.
TEST(YamlSyntax, NamesTheQuotationMarkThatIsOpen) {
  const std::string open = ": the quotation mark that stands here is not closed";
  EXPECT_EQ(fault("a: \"b\nc: 1\n"), "1:4" + open);
  EXPECT_EQ(fault("c: 1\na: 'b\n"), "2:4" + open);
  EXPECT_EQ(fault("a: ['b, c]\n"), "1:5" + open);
  EXPECT_EQ(fault("a: 'it''s'\nb: \"1 \\\" 2\"\nc: don't\nd: 5 \"o'clock  # 'no'\n"), "");
}

}  // namespace
}  // namespace thenar::yaml_syntax_test
