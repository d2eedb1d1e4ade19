// SPDX-License-Identifier: Apache-2.0
// Where results go, and what becomes of them where they cannot be written.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::results_test {
namespace {

namespace fs = std::filesystem;

/// A scene and its hand in a folder of their own.
fs::path copied_scene(const fs::path& folder) {
  fs::create_directories(folder);
  for (const char* file : {"minimal.yaml", "hand.yaml"}) fs::copy_file(config(file), folder / file);
  return folder / "minimal.yaml";
}

TEST(Program, NoResultReplacesAnInput) {
  const fs::path folder = scratch(), scene = copied_scene(folder / "in"), hand = folder / "in" / "hand.yaml";
  const std::string scene_text = read(scene), hand_text = read(hand);
  const std::string run = "run " + scene.string() + " --time '50 ms' ";
  fs::create_symlink(scene, folder / "link.mcap");
  fs::create_hard_link(hand, folder / "other_name.mcap");
  for (const fs::path& input : {scene, hand, folder / "link.mcap", folder / "other_name.mcap"}) {
    const ProgramResult refused = thenar_program(run + "--record " + input.string());
    EXPECT_EQ(refused.code, 2) << refused.text;
    EXPECT_NE(refused.text.find("which this command reads"), std::string::npos) << refused.text;
  }
  // A result that is named by its folder, and a result over a result.
  const fs::path out = folder / "out";
  fs::create_directories(out);
  fs::create_hard_link(scene, out / "summary.json");
  EXPECT_EQ(thenar_program(run + "--out " + out.string()).code, 2);
  fs::remove(out / "summary.json");
  EXPECT_EQ(thenar_program(run + "--out " + out.string() + " --record " + (out / "signals.csv").string()).code, 2);
  EXPECT_TRUE(fs::is_empty(out));
  EXPECT_EQ(thenar_program(run + "--realtime --trace " + hand.string()).code, 2);
  EXPECT_EQ(read(scene), scene_text);
  EXPECT_EQ(read(hand), hand_text);
  const fs::path film = folder / "film.mcap";
  ASSERT_EQ(thenar_program(run + "--record " + film.string()).code, 0);
  const std::string bytes = read(film);
  EXPECT_EQ(thenar_program("export " + film.string() + " --csv " + film.string()).code, 2);
  EXPECT_EQ(read(film), bytes);
}

/// For scenes whose surface shall soon be there.
const std::string kSoon = " --set object.points=2000 ";

TEST(Program, TwoRunsDoNotShareAFolderOrAFile) {
  const fs::path folder = scratch(), out = folder / "out", pid = folder / "pid", film = folder / "film.mcap";
  // The first goes on until a signal ends it.
  const std::string first = THENAR_PROGRAM + (" run " + config("minimal.yaml")) + kSoon + "--time 900 --quiet --out " +
                            out.string() + " --record " + film.string();
  ASSERT_EQ(std::system((first + " >/dev/null 2>&1 & echo $! > " + pid.string()).c_str()), 0);
  ASSERT_EQ(std::system(
                ("for i in $(seq 6000); do [ -s " + film.string() + " ] && exit 0; sleep 0.01; done; exit 1").c_str()),
            0);
  const std::string second = "run " + config("minimal.yaml") + " --time '50 ms' ";
  const ProgramResult same_folder = thenar_program(second + "--out " + out.string());
  EXPECT_EQ(same_folder.code, 2);
  EXPECT_NE(same_folder.text.find("another run writes into"), std::string::npos) << same_folder.text;
  EXPECT_EQ(thenar_program(second + "--realtime --out " + out.string()).code, 2);
  EXPECT_EQ(thenar_program(second + "--dump-problems " + out.string()).code, 2);
  const ProgramResult same_file = thenar_program(second + "--record " + film.string());
  EXPECT_EQ(same_file.code, 3);
  EXPECT_NE(same_file.text.find("another run records into this file"), std::string::npos) << same_file.text;
  // A run's own two flags for one folder are no two runs.
  EXPECT_EQ(
      thenar_program(second + "--out " + (folder / "one").string() + " --dump-problems " + (folder / "one").string())
          .code,
      0);
  EXPECT_EQ(std::system(("kill -KILL $(cat " + pid.string() + ")").c_str()), 0) << "the first has ended by itself";
}

/// The most of a file that a shell lets a program write, in bytes; more is refused as by a full disk.
std::string file_limit(std::uintmax_t bytes) {
  return "trap '' XFSZ; ulimit -f " + std::to_string(bytes / 512) + "; exec ";
}

TEST(Program, ADiskThatFailsTheRecordingFailsNothingElse) {
  const fs::path folder = scratch();
  const fs::path film = folder / "film.mcap";
  for (const std::string runner : {"", "--lockstep ", "--realtime "}) {
    // In real time the lengths of two recordings differ, on a busy machine by a tenth; otherwise not at all.
    const bool realtime = runner == "--realtime ";
    const std::string run =
        "run " + config("minimal.yaml") + kSoon + runner + "--time '2.5 s' --format json --record " + film.string();
    ASSERT_EQ(thenar_program(run, "exec ").code, 0);
    const std::uintmax_t whole = fs::file_size(film);
    const ProgramResult cut = thenar_program(run, file_limit(realtime ? whole / 5 * 4 : whole - 8000));
    EXPECT_EQ(cut.code, 3) << cut.text;
    EXPECT_NE(cut.text.find("film.mcap: could not be written in full"), std::string::npos) << cut.text;
    const std::size_t end = cut.text.rfind('}');
    ASSERT_NE(end, std::string::npos) << cut.text;
    const auto summary = nlohmann::json::parse(cut.text.substr(cut.text.find('{'), end - cut.text.find('{') + 1));
    const auto simulated = summary.at("simulated_s").get<double>();
    if (realtime) {
      EXPECT_GT(simulated, 1.25);  // it went on behind the disk's end
    } else {
      EXPECT_DOUBLE_EQ(simulated, 2.5);
    }
    // What was recorded before is sound.
    const ProgramResult exported =
        thenar_program("export " + film.string() + " --csv " + (folder / "film.csv").string());
    EXPECT_EQ(exported.code, 0) << exported.text;
    EXPECT_NE(exported.text.find("cut off"), std::string::npos) << exported.text;
  }
}

TEST(Program, ADiskThatFailsDumpedProblemsFailsNothingElse) {
  const fs::path folder = scratch();
  const ProgramResult run = thenar_program(
      "run " + config("minimal.yaml") + kSoon + "--time '0.5 s' --format json --dump-problems " + folder.string(),
      file_limit(512));
  EXPECT_EQ(run.code, 3) << run.text;
  EXPECT_NE(run.text.find("could not be written in full"), std::string::npos) << run.text;
  EXPECT_NE(run.text.find("\"simulated_s\": 0.5"), std::string::npos) << run.text;
}

TEST(Program, RefusesAFolderThatCannotBeWrittenBeforeItRuns) {
  // A file stands where the folder should be: nobody can write there, not even the superuser.
  const fs::path file = scratch() / "file";
  std::ofstream(file) << "kept";
  const ProgramResult run = thenar_program("run " + config("minimal.yaml") + " --out " + (file / "out").string());
  EXPECT_EQ(run.code, 3);
  EXPECT_NE(run.text.find("cannot make this folder"), std::string::npos) << run.text;
  EXPECT_EQ(read(file), "kept");
}

}  // namespace
}  // namespace thenar::results_test
