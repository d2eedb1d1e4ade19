// The layout is that of the MCAP specification (mcap.dev/spec); that other readers agree is tested with theirs, beside
// the page.

#include "engine/formats/mcap_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "tests/support/scratch.h"

namespace thenar::mcap_file_test {
namespace {

namespace fs = std::filesystem;

class McapFile : public testing::Test {
 protected:
  fs::path write(bool finish) {
    const fs::path file = scratch() / "a.mcap";
    McapWriter writer(file, {{"/a", "json", "A", "jsonschema", "{}"}, {"/b", "thenar", "B", "text", "numbers"}});
    for (int i = 0; i < 20; ++i) {
      writer.add(i % 2, 0.02 * i, std::string(i, static_cast<char>(i)));
    }
    if (finish) writer.finish();
    return file;
  }

  static void expect_first(const McapContents& contents, std::size_t count) {
    ASSERT_EQ(contents.messages.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(contents.messages[i].topic, i % 2 == 0 ? "/a" : "/b");
      EXPECT_EQ(contents.messages[i].bytes, std::string(i, static_cast<char>(i)));
      // Times are whole nanoseconds.
      EXPECT_NEAR(contents.messages[i].time_s, 0.02 * static_cast<double>(i), 0.51e-9);
    }
  }
};

TEST_F(McapFile, GivesBackWhatWasWritten) {
  const McapContents contents = read_mcap(write(true));
  EXPECT_TRUE(contents.whole);
  expect_first(contents, 20);
}

TEST_F(McapFile, OfAProgramThatEndedEarlyIsReadToItsLastMessage) {
  const McapContents contents = read_mcap(write(false));
  EXPECT_FALSE(contents.whole);
  expect_first(contents, 20);
}

// Cut anywhere, a file has the messages that end before the cut, and no others.
TEST_F(McapFile, CutOffAnywhereHasItsWholeMessages) {
  const fs::path file = write(true);
  const std::string bytes = read(file);
  // Of message i: opcode, length, channel, sequence, two times, i bytes.
  const auto size = [](std::size_t i) { return 1 + 8 + 2 + 4 + 8 + 8 + i; };
  std::size_t tail = 8 + (1 + 8 + 4) + (1 + 8 + 20);  // magic, end of data, footer
  std::vector<std::size_t> ends(20);                  // of the messages
  std::size_t end = bytes.size() - tail;
  for (std::size_t i = 20; i-- > 0; end -= size(i)) ends[i] = end;
  for (std::size_t cut = ends[0] - size(0); cut < bytes.size(); ++cut) {
    SCOPED_TRACE(cut);
    std::ofstream(file, std::ios::binary) << bytes.substr(0, cut);
    const auto whole = std::count_if(ends.begin(), ends.end(), [&](std::size_t e) { return e <= cut; });
    const McapContents contents = read_mcap(file);
    EXPECT_FALSE(contents.whole);
    expect_first(contents, whole);
  }
}

TEST_F(McapFile, RefusesWhatIsNone) {
  const fs::path file = scratch() / "b.mcap";
  EXPECT_THROW((void)read_mcap(file), FileError);
  for (const std::string& bytes : {std::string("no"), std::string("\x89MCAP1\r\n"), std::string(100, 'x')}) {
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_THROW((void)read_mcap(file), FileError);
  }
  EXPECT_THROW(McapWriter(scratch() / "none" / "c.mcap", {}), FileError);
}

// A length beyond the file's end is a cut, whatever it claims, and takes no memory.
TEST_F(McapFile, SurvivesWrongLengths) {
  const fs::path file = write(true);
  const std::string bytes = read(file);
  for (std::size_t at = 8; at < bytes.size(); ++at) {
    std::string wrong = bytes;
    wrong[at] = '\xFF';
    std::ofstream(file, std::ios::binary) << wrong;
    try {
      EXPECT_LE(read_mcap(file).messages.size(), 21U) << at;
    } catch (const FileError&) {
    }
  }
}

TEST_F(McapFile, SaysThatADiskIsFull) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(McapWriter("/dev/full", {{"/a", "json", "A", "jsonschema", "{}"}}), FileError);
}

}  // namespace
}  // namespace thenar::mcap_file_test
