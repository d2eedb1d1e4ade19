// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/text.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace thenar::text_test {
namespace {

// Well-formed text passes whole; the first byte that is no character of UTF-8, or a control character, is found.
TEST(Text, FindsWhatJsonAndTerminalsDoNotTake) {
  EXPECT_EQ(first_unprintable("Griff, \xC3\xA9, \xE2\x82\xAC, \xF0\x9F\x91\x8D"), std::string::npos);
  EXPECT_EQ(first_unprintable("caf\xE9"), 3u);             // Latin-1
  EXPECT_EQ(first_unprintable("\xC0\xAF"), 0u);            // Overlong
  EXPECT_EQ(first_unprintable("a\xED\xA0\x80"), 1u);       // Half a surrogate pair
  EXPECT_EQ(first_unprintable("ab\xF5\x80\x80\x80"), 2u);  // Beyond U+10FFFF
  EXPECT_EQ(first_unprintable("a\x1B[2J"), 1u);
  EXPECT_EQ(printable("caf\xE9\n"), "caf\\xE9\\x0A");
}

// RFC 4180: quotes where a comma, a quote or an end of line would be read as the table's own.
TEST(Text, CellsOfATableAreReadBackAsOne) {
  EXPECT_EQ(csv_cell("flexor digitorum"), "flexor digitorum");
  EXPECT_EQ(csv_cell("flexor, deep"), "\"flexor, deep\"");
  EXPECT_EQ(csv_cell("the \"deep\" one"), "\"the \"\"deep\"\" one\"");
  EXPECT_EQ(csv_cell("two\nlines"), "\"two\nlines\"");
}

TEST(Text, SuggestsTheNearestWord) {
  const std::vector<std::string_view> words{"law", "friction", "fraction", "p"};
  EXPECT_EQ(nearest_word("frcition", words), "friction");
  EXPECT_EQ(nearest_word("lwa", words), "law");
  EXPECT_EQ(nearest_word("frixtion", words), "friction");
  EXPECT_EQ(nearest_word("friction", words), "friction");
  EXPECT_EQ(nearest_word("d", words), "") << "another word";
  EXPECT_EQ(nearest_word("gravity", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(did_you_mean("law"), ", did you mean 'law'?");
  EXPECT_EQ(did_you_mean(""), "");
}

}  // namespace
}  // namespace thenar::text_test
