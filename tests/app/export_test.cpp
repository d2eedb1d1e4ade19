// SPDX-License-Identifier: Apache-2.0
// `thenar export`.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/program.h"

namespace thenar::export_test {
namespace {

namespace fs = std::filesystem;

TEST(Program, RecordsARunAndExportsIt) {
  const fs::path folder = scratch();
  const std::string film = (folder / "film.mcap").string(), csv = (folder / "film.csv").string();
  for (const char* runner : {"", " --lockstep", " --realtime"}) {
    const ProgramResult run =
        thenar_program("run " + config("minimal.yaml") + " --time '0.2 s' --record " + film + runner);
    ASSERT_EQ(run.code, 0) << run.text;
    const ProgramResult exported = thenar_program("export " + film + " --csv " + csv);
    ASSERT_EQ(exported.code, 0) << exported.text;
    const std::string table = read(csv);
    // 50 states a second, under a header; in real time a busy machine may miss some.
    const auto states = std::count(table.begin(), table.end(), '\n') - 1;
    EXPECT_LE(states, 10);
    EXPECT_GE(states, std::string(runner) == " --realtime" ? 1 : 10);
  }
  // Cut off within its summary, it has all its states.
  const std::string bytes = read(film);
  std::ofstream(film, std::ios::binary) << bytes.substr(0, bytes.size() - 100);
  const ProgramResult cut = thenar_program("export " + film + " --csv " + csv);
  EXPECT_EQ(cut.code, 0);
  EXPECT_NE(cut.text.find("cut off"), std::string::npos);
  // A table that was written stays when the next one fails.
  EXPECT_EQ(thenar_program("export " + config("minimal.yaml") + " --csv " + csv).code, 3);
  EXPECT_GT(fs::file_size(csv), 0U);
  EXPECT_EQ(thenar_program("export " + film).code, 2);
  EXPECT_EQ(thenar_program("run " + config("minimal.yaml") + " --record " + csv + "/a.mcap").code, 3);
}

TEST(Program, SaysWhatIsWrongWithTheFlagsOfARecording) {
  const fs::path folder = scratch();
  const std::string run = "run " + config("minimal.yaml") + " --time '0.05 s'", film = (folder / "a.mcap").string();
  const ProgramResult unknown = thenar_program(run + " --record " + film + " --record-fields q_rad,force");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_EQ(unknown.text.rfind("--record-fields: a state has no field 'force', did you mean 'force_N'?", 0), 0U)
      << unknown.text;
  EXPECT_NE(unknown.text.find(", displacement_m, "), std::string::npos) << "it lists all there are";
  const ProgramResult fast = thenar_program(run + " --record " + film + " --record-rate '90 kHz'");
  EXPECT_EQ(fast.code, 2);
  EXPECT_EQ(fast.text.rfind("--record-rate: 90 kHz is more than", 0), 0U) << fast.text;
  for (const char* flag : {" --record-rate 100", " --record-fields q_rad", " --record-contacts"}) {
    EXPECT_EQ(thenar_program(run + flag).code, 2) << "without --record";
  }
  EXPECT_FALSE(fs::exists(film));
  // Arrays and storages of what was recorded alone.
  ASSERT_EQ(thenar_program(run + " --record " + film + " --record-fields force_N").code, 0);
  EXPECT_EQ(thenar_program("export " + film + " --sto " + (folder / "a.sto").string()).code, 3);
  EXPECT_EQ(thenar_program("export " + film + " --html " + (folder / "a.html").string()).code, 3);
}

TEST(Program, RecordsTwoThreadsWithTheirContacts) {
  const std::string film = (scratch() / "a.mcap").string(), csv = film + ".csv";
  const ProgramResult run =
      thenar_program("run " + config("minimal.yaml") + " --realtime --time 0.3 --no-realtime --record " + film +
                     " --record-contacts --record-rate 100 --quiet");
  EXPECT_EQ(run.code, 0) << run.text;
  ASSERT_EQ(thenar_program("export " + film + " --csv " + csv).code, 0);
  const std::string table = read(csv);
  EXPECT_GE(std::count(table.begin(), table.end(), '\n'), 3);
}

// A recording is held once, and the page that is made of it beside it, which is 4/3 of it in base64: 2.4 times its size
// and 45 MB for the program. Held twice, as text or as a page, it would not fit.
TEST(Program, ExportsWithLittleMoreThanTheRecordingItself) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory of their own";
#endif
  const fs::path folder = scratch();
  const std::string film = (folder / "film.mcap").string();
  ASSERT_EQ(thenar_program("run " + config("box_grasp.yaml") + " --quiet --time 24 --record " + film).code, 0);
  const auto kB = static_cast<double>(fs::file_size(film)) / 1024.0;
  ASSERT_GT(kB, 20'000.0);
  const auto limited = [](double most_kB) {
    return "ulimit -v " + std::to_string(std::llround(most_kB + 45'000.0)) + "; ";
  };
  const ProgramResult csv =
      thenar_program("export " + film + " --csv " + (folder / "film.csv").string(), limited(1.5 * kB));
  EXPECT_EQ(csv.code, 0) << csv.text;
  if (fs::exists(fs::path(THENAR_PROGRAM).parent_path().parent_path() / "share/thenar/page.html")) {
    const ProgramResult page =
        thenar_program("export " + film + " --html " + (folder / "film.html").string(), limited(2.4 * kB));
    EXPECT_EQ(page.code, 0) << page.text;
  }
}

}  // namespace
}  // namespace thenar::export_test
