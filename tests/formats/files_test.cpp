// SPDX-License-Identifier: Apache-2.0
// Files as others may leave or change them: nothing of theirs is lost, and no reading or writing is half done
// unnoticed.

#include "engine/formats/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "tests/support/scratch.h"

namespace thenar::files_test {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

std::string fault_of_reading(const fs::path& file) {
  try {
    static_cast<void>(read_file(file));
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(Files, OnlyARegularFileIsRead) {
  const fs::path folder = scratch(), pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0666), 0);
  // A pipe that nobody writes into, and a device without an end: each would be read for ever.
  EXPECT_EQ(fault_of_reading(pipe), pipe.string() + ": is a pipe or a device, not a file");
  EXPECT_EQ(fault_of_reading("/dev/zero"), "/dev/zero: is a pipe or a device, not a file");
  EXPECT_EQ(fault_of_reading(folder), folder.string() + ": is a folder, not a file");
  EXPECT_EQ(fault_of_reading(folder / "none"), (folder / "none").string() + ": no such file");
  // Of a file whose size the system does not know beforehand all bytes come, too.
  EXPECT_NE(read_file("/proc/self/status").find("Pid:"), std::string::npos);
  std::string bytes(100'000, '\0');
  bytes.back() = 'x';
  put(folder / "zeros", bytes);
  EXPECT_EQ(read_file(folder / "zeros"), bytes);
}

// What downloads leave in the place of a file.
TEST(Files, WhatIsAnotherFileIsNamed) {
  const fs::path file = scratch() / "box.obj";
  const auto fault = [&](const std::string& bytes) {
    put(file, bytes);
    return fault_of_reading(file).substr(file.string().size());
  };
  EXPECT_EQ(fault("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n"),
            ": is a pointer of Git LFS, not the file itself: `git lfs pull` fetches that");
  for (const char* page : {"<!DOCTYPE html><html></html>", "<!doctype HTML>\n", "<html lang=\"en\">"}) {
    EXPECT_EQ(fault(page), ": is a web page, not the file that it shows: download that one") << page;
  }
  EXPECT_EQ(fault("\x1F\x8B\x08 bytes"), ": is packed by gzip: unpack it first");
  EXPECT_EQ(fault("PK\x03\x04 bytes"),
            ": is a zip archive: unpack it first, or, of a 3MF file, save the surface as .obj or .stl");
  const fs::path page = file.parent_path() / "page.html";  // Its name says so.
  put(page, "<!doctype html>\n");
  EXPECT_EQ(fault_of_reading(page), "");
  put(file, "<mujoco>");
  EXPECT_EQ(fault_of_reading(file), "");
}

TEST(Files, KeptFilesStayAsTheyWere) {
  const fs::path folder = scratch(), file = folder / "a", other = folder / "b";
  put(file, "old");
  put(other, "old");
  {
    const KeptFiles kept;
    KeptFiles::keep(file);
    put(file, "new");
    put(other, "new");
    EXPECT_EQ(read_file(file), "old");
    EXPECT_EQ(read_file(other), "new") << "nobody asked to keep it";
    fs::remove(file);
    KeptFiles::keep(file);
    EXPECT_EQ(read_file(file), "old");
    EXPECT_THROW(KeptFiles::keep(folder / "none"), ReadError);
  }
  EXPECT_THROW(static_cast<void>(read_file(file)), ReadError) << "kept for ever";
}

TEST(Files, WhatIsAnothersStays) {
  const fs::path folder = scratch(), mine = folder / "mine";
  put(mine, "kept");
  // Names under which drafts and probes were once written, as a file and as a link to one.
  put(folder / ".thenar", "kept");
  fs::create_symlink(mine, folder / "result.json.part");
  prepare_folder(folder);
  write_file(folder / "result.json", "a result");
  EXPECT_EQ(read(folder / ".thenar"), "kept");
  EXPECT_TRUE(fs::is_symlink(folder / "result.json.part"));
  EXPECT_EQ(read(mine), "kept");
  EXPECT_EQ(read(folder / "result.json"), "a result");
  fs::remove(folder / ".thenar");
  fs::create_symlink(mine, folder / ".thenar");
  prepare_folder(folder);
  EXPECT_TRUE(fs::is_symlink(folder / ".thenar"));
  EXPECT_EQ(read(mine), "kept");
  const auto count = std::distance(fs::directory_iterator(folder), fs::directory_iterator());
  EXPECT_EQ(count, 4) << "a draft or a probe is left";
}

TEST(Files, ALockIsOnesAndEndsWithIt) {
  const fs::path folder = scratch(), file = folder / "file";
  for (const fs::path& path : {folder, file}) {
    std::optional<FileLock> lock = FileLock::take(path);
    ASSERT_TRUE(lock);
    EXPECT_FALSE(FileLock::take(path)) << path;
    lock.reset();
    EXPECT_TRUE(FileLock::take(path)) << path;
  }
  const std::optional<FileLock> lock = FileLock::take(file);
  lock->write("a long text");
  lock->write("text");
  EXPECT_EQ(read(file), "text");
  // A device belongs to nobody.
  const auto one = FileLock::take("/dev/null"), two = FileLock::take("/dev/null");
  EXPECT_TRUE(one && two);
  EXPECT_THROW(static_cast<void>(FileLock::take(folder / "none" / "file")), FileError);
}

TEST(Files, AFullDiskIsReported) {
  EXPECT_THROW(write_file("/dev/full", "text"), FileError);
  const std::optional<FileLock> lock = FileLock::take("/dev/full");
  EXPECT_THROW(lock->write("text"), FileError);
}

// Who made a file secret, or an executable, finds it so after it has been replaced.
TEST(Files, AReplacedFileKeepsItsMode) {
  const fs::path file = scratch() / "a";
  for (const mode_t mode : {mode_t{0600}, mode_t{0640}, mode_t{0755}}) {
    put(file, "old");
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    write_file(file, "new");
    struct stat status {};
    ASSERT_EQ(stat(file.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, mode);
    EXPECT_EQ(read(file), "new");
  }
}

std::string fault_of_opening(const fs::path& file) {
  try {
    FileWriter(file).write("x");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

bool stop_asked = false;

// Whoever is killed by a pipe, or waits for it for ever, loses more than what went into it.
TEST(Files, APipeEndsNobody) {
  const fs::path pipe = scratch() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0666), 0);
  EXPECT_EQ(fault_of_opening(pipe), pipe.string() + ": nobody reads this pipe");
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  {
    FileWriter writer(pipe);
    EXPECT_TRUE(writer.write("abc"));
    char got[4] = {};
    EXPECT_EQ(::read(reader, got, 3), 3);
    EXPECT_STREQ(got, "abc");
    // It reads no more, and somebody asks for the end.
    stop_asked = true;
    set_stop_question([] { return stop_asked; });
    EXPECT_FALSE(writer.write(std::string(1'000'000, 'x')));
    EXPECT_FALSE(writer.write("y")) << "a part is missing before it";
    set_stop_question(nullptr);
  }
  FileWriter writer(pipe);
  close(reader);
  EXPECT_FALSE(writer.write("x")) << "without SIGPIPE";
  EXPECT_TRUE(writer.has_failed());
}

TEST(Files, NamesOfFilesAreNoOrdersToTerminals) {
  EXPECT_STREQ(FileError("a\x1b[2Jb\n", "what").what(), "a\\x1B[2Jb\\x0A: what");
  EXPECT_EQ(FileError("a\x1b", "what").file(), "a\x1b");
}

}  // namespace
}  // namespace thenar::files_test
