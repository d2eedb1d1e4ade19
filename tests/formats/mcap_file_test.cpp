// SPDX-License-Identifier: Apache-2.0
// The layout is that of the MCAP specification (mcap.dev/spec); that other readers agree is tested with theirs, beside
// the page.

#include "engine/formats/mcap_file.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/mcap_records.h"
#include "tests/support/messages.h"
#include "tests/support/scratch.h"

namespace thenar::mcap_file_test {
namespace {

namespace fs = std::filesystem;

/// Bytes that no compression makes shorter.
std::string noise(std::size_t size, unsigned seed) {
  std::minstd_rand random(seed + 1);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random() >> 8);
  return bytes;
}

class McapFile : public testing::Test {
 protected:
  /// 20 messages, four of them a chunk.
  fs::path write(bool finish) {
    const fs::path file = scratch() / "a.mcap";
    McapWriter writer(file, {{"/a", "json", "A", "jsonschema", "{}"}, {"/b", "thenar", "B", "text", "numbers"}});
    for (unsigned i = 0; i < 20; ++i) writer.add(i % 2, kStep_s * i, bytes_of(i));
    if (finish) writer.finish();
    return file;
  }

  static std::string bytes_of(unsigned i) { return i % 8 < 4 ? noise(600 + i, i) : std::string(600 + i, 'x'); }

  static void expect_first(const KeptMessages& contents, std::size_t count) {
    ASSERT_EQ(contents.messages.size(), count);
    for (unsigned i = 0; i < count; ++i) {
      EXPECT_EQ(contents.messages[i].topic, i % 2 == 0 ? "/a" : "/b");
      EXPECT_EQ(contents.messages[i].bytes, bytes_of(i));
      // Times are whole nanoseconds.
      EXPECT_NEAR(contents.messages[i].time_s, kStep_s * i, 0.51e-9);
    }
  }

  static constexpr double kStep_s = kChunk_s / 3.0 + 1e-9;  // The fourth message is the one that ends a chunk.
};

TEST_F(McapFile, GivesBackWhatWasWritten) {
  const KeptMessages contents = messages_in(write(true));
  EXPECT_TRUE(contents.reading.whole);
  expect_first(contents, 20);
}

// Some chunks are noise and some are not: both kinds must be there, or the tests here say nothing of one of them.
TEST_F(McapFile, CompressesWhatGetsShorter) {
  const std::string bytes = read(write(true));
  const std::string packed = "zstd";
  std::size_t of_zstd = 0;
  for (std::size_t at = bytes.find(packed); at != std::string::npos; at = bytes.find(packed, at + 1)) ++of_zstd;
  EXPECT_EQ(of_zstd, 2 * 2U);  // Of five chunks the second and the fourth, in the chunk and in its index.
}

TEST_F(McapFile, OfAProgramThatEndedEarlyIsReadToItsLastChunk) {
  const KeptMessages contents = messages_in(write(false));
  EXPECT_FALSE(contents.reading.whole);
  expect_first(contents, 20);
}

// Cut anywhere, a file has the messages of the chunks that end before the cut, and no others: what is read never
// shrinks by a longer file, and grows by whole chunks.
TEST_F(McapFile, CutOffAnywhereHasItsWholeChunks) {
  const fs::path file = write(true);
  const std::string bytes = read(file);
  std::size_t last = 0, steps = 0;
  for (std::size_t cut = 8; cut < bytes.size(); ++cut) {
    SCOPED_TRACE(cut);
    KeptMessages contents;
    contents.reading = read_mcap(std::string_view(bytes).substr(0, cut), file, [&](const McapMessage& message) {
      contents.messages.push_back({std::string(message.topic), message.time_s, std::string(message.bytes)});
    });
    EXPECT_FALSE(contents.reading.whole);
    EXPECT_EQ(contents.reading.damaged_chunks, 0U);
    ASSERT_GE(contents.messages.size(), last);
    if (contents.messages.size() == last) continue;
    ASSERT_EQ(contents.messages.size(), last + 4);
    last = contents.messages.size();
    ++steps;
    expect_first(contents, last);
  }
  EXPECT_EQ(steps, 5U);
}

// A damaged chunk costs its own messages alone.
TEST_F(McapFile, PassesOverADamagedChunk) {
  const fs::path file = write(true);
  std::string bytes = read(file);
  bytes[bytes.find(bytes_of(1)) + 100] ^= 1;
  std::ofstream(file, std::ios::binary) << bytes;
  const KeptMessages contents = messages_in(file);
  EXPECT_EQ(contents.reading.damaged_chunks, 1U);
  EXPECT_FALSE(contents.reading.whole);
  ASSERT_EQ(contents.messages.size(), 16U);
  EXPECT_EQ(contents.messages[0].bytes, bytes_of(4));
}

// As versions before 0.8 wrote them.
TEST_F(McapFile, IsReadWithoutChunks) {
  std::string bytes(mcap::kMagic);
  mcap::append_record(bytes, mcap::kHeader, mcap::Bytes().text("").text("").done());
  mcap::append_record(
      bytes, mcap::kChannel,
      mcap::Bytes().number(std::uint16_t{7}).number(std::uint16_t{0}).text("/old").text("json").text("").done());
  const auto message = [&](std::uint64_t time_ns) {
    return mcap::Bytes()
        .number(std::uint16_t{7})
        .number(std::uint32_t{0})
        .number(time_ns)
        .number(time_ns)
        .raw("{}")
        .done();
  };
  for (const std::uint64_t time_ns : {0, 500'000'000}) mcap::append_record(bytes, mcap::kMessage, message(time_ns));
  const fs::path file = scratch() / "old.mcap";
  std::ofstream(file, std::ios::binary) << bytes.substr(0, bytes.size() - 1);
  EXPECT_EQ(messages_in(file).messages.size(), 1U);
  std::ofstream(file, std::ios::binary) << bytes;
  const KeptMessages contents = messages_in(file);
  ASSERT_EQ(contents.messages.size(), 2U);
  EXPECT_EQ(contents.messages[1].topic, "/old");
  EXPECT_EQ(contents.messages[1].time_s, 0.5);
  EXPECT_FALSE(contents.reading.whole);
}

// Whoever is killed has all but the last second, and the last MiB.
TEST_F(McapFile, HasAChunkOnTheDiskAsSoonAsItEnds) {
  const fs::path file = scratch() / "a.mcap";
  McapWriter writer(file, {{"/a", "json", "A", "jsonschema", "{}"}});
  writer.add(0, 0.0, noise(kChunkBytes, 0));
  EXPECT_EQ(messages_in(file).messages.size(), 1U);
  writer.add(0, 0.1, "short");
  EXPECT_EQ(messages_in(file).messages.size(), 1U);
  writer.add(0, 0.1 + kChunk_s, "late");
  EXPECT_EQ(messages_in(file).messages.size(), 3U);
}

TEST_F(McapFile, RefusesWhatIsNone) {
  const fs::path file = scratch() / "b.mcap";
  EXPECT_THROW((void)messages_in(file), FileError);
  for (const std::string& bytes : {std::string("no"), std::string("\x89MCAP1\r\n"), std::string(100, 'x')}) {
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_THROW((void)messages_in(file), FileError);
  }
  EXPECT_THROW(McapWriter(scratch() / "none" / "c.mcap", {}), FileError);
}

// A length beyond the file's end is a cut, and one of a chunk is damage, whatever it claims, and takes no memory.
TEST_F(McapFile, SurvivesWrongLengths) {
  const fs::path file = write(true);
  const std::string bytes = read(file);
  for (std::size_t at = 8; at < bytes.size(); ++at) {
    std::string wrong = bytes;
    wrong[at] = '\xFF';
    std::ofstream(file, std::ios::binary) << wrong;
    try {
      EXPECT_LE(messages_in(file).messages.size(), 20U) << at;
    } catch (const FileError&) {
    }
  }
}

TEST_F(McapFile, SaysThatADiskIsFull) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(McapWriter("/dev/full", {{"/a", "json", "A", "jsonschema", "{}"}}), FileError);
}

std::string fault_of(const std::string& bytes) {
  try {
    (void)read_mcap(bytes, "a.mcap", [](const McapMessage&) {});
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

// What is compressed as we cannot read it is no damage.
TEST_F(McapFile, NamesWhatItCannotUnpack) {
  std::string bytes(mcap::kMagic);
  mcap::append_record(bytes, mcap::kChunk,
                      mcap::Bytes()
                          .number(std::uint64_t{0})
                          .number(std::uint64_t{0})
                          .number(std::uint64_t{100})
                          .number(std::uint32_t{0})
                          .text("lz4")
                          .number(std::uint64_t{3})
                          .raw("abc")
                          .done());
  EXPECT_EQ(fault_of(bytes), "a.mcap: has chunks compressed by lz4: only zstd is read here");
}

// Zeros are compressed some thousandfold: a small file must not ask for any time.
TEST_F(McapFile, UnpacksToAMultipleOfItself) {
  const auto file_of = [](int megabytes) {
    McapEncoder encoder({{"/a", "json", "A", "jsonschema", "{}"}});
    for (int i = 0; i < megabytes; ++i) encoder.add(0, 0.0, std::string(1 << 20, '\0'));
    encoder.finish();
    return encoder.take();
  };
  EXPECT_EQ(fault_of(file_of(50)), "");
  EXPECT_EQ(fault_of(file_of(200)), "a.mcap: unpacks to more than 256 times its size");
}

}  // namespace
}  // namespace thenar::mcap_file_test
