// SPDX-License-Identifier: Apache-2.0
// `thenar sweep` as a user meets it: one table whoever makes it, and nothing lost when it is killed.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/app/sweep_runs.h"
#include "tests/support/program.h"

namespace thenar::sweep_test {
namespace {

using namespace sweep_runs;

// `run` and `sweep` say the same of the same scene, in the same words.
TEST(SweepProgram, JudgesAsRunDoes) {
  const fs::path folder = scratch();
  const std::string scene = config("box_grasp.yaml"),
                    changes = " --set object.points=2000 --set contact.level=2 --time 0.9s";
  const std::vector<std::string> frictions{"0.8", "0.3", "0.2"};
  const ProgramResult swept = thenar_program(
      "sweep " + scene + changes + " --vary contact.friction=0.8,0.3,0.2 --jobs 1 --out " + (folder / "rows").string());
  ASSERT_EQ(swept.code, 0) << swept.text;
  const std::string rows = read(folder / "rows/rows.csv");
  std::set<std::string> words;
  for (const std::string& friction : frictions) {
    const std::string out = (folder / friction).string();
    const ProgramResult run =
        thenar_program("run " + scene + changes + " --quiet --set contact.friction=" + friction + " --out " + out);
    const auto grasp = nlohmann::json::parse(read(fs::path(out) / "summary.json")).at("grasp");
    const std::string word = grasp.at("outcome"), reason = grasp.at("reason");
    words.insert(word);
    EXPECT_EQ(run.code == 0, word == "held") << run.text;
    EXPECT_NE(rows.find("\n" + friction + "," + word + ","), std::string::npos) << word << "\n" << rows;
    EXPECT_NE(rows.find("," + (reason.find(',') == std::string::npos ? reason : '"' + reason + '"') + ","),
              std::string::npos)
        << reason << "\n"
        << rows;
  }
  EXPECT_EQ(words.size(), 3U) << "held, slipping, lost";
}

// A real limit: a million points ask for more than it leaves, 2000 for a tenth of it. The row is named, it blocks
// nothing, and where there is memory the same command goes on.
TEST(SweepProgram, ARowWithoutMemoryIsNamedAndBlocksNothing) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory of their own";
#endif
  const fs::path folder = scratch();
  const std::string command = std::string(THENAR_PROGRAM) + " sweep " + config("minimal.yaml") +
                              " --set 'time.duration=0.02 s' --vary object.points=1000000,2000 --jobs 1 --out " +
                              (folder / "rows").string();
  EXPECT_EQ(shell("ulimit -v 150000; { " + command + "; } 2> " + (folder / "said").string()), 6);
  const std::string said = read(folder / "said"), rows = read(folder / "rows/rows.csv");
  EXPECT_NE(said.find("row 1 of 2 (object.points=1000000): not enough memory"), std::string::npos) << said;
  EXPECT_NE(rows.find("\n2000,held,"), std::string::npos) << rows;
  EXPECT_EQ(rows.find("\n1000000,"), std::string::npos) << rows;
  EXPECT_EQ(shell("ulimit -v 150000; " + command), 6) << "again, and the row that is finished is not run again";
  EXPECT_EQ(read(folder / "rows/rows.csv"), rows);
}

TEST(SweepProgram, MakesOneTableForAnyNumberOfJobs) {
  const fs::path folder = scratch();
  const ProgramResult one = thenar_program(sweep_command(folder / "one") + " --jobs 1");
  ASSERT_EQ(one.code, 0) << one.text;
  EXPECT_NE(one.text.find("refused              2\nrows                12\n"), std::string::npos) << one.text;
  EXPECT_EQ(lines(folder / "one/rows.csv"), 1 + kRows);
  const ProgramResult three = thenar_program(sweep_command(folder / "three") + " --jobs 3 --quiet");
  EXPECT_EQ(three.code, 0);
  EXPECT_EQ(three.text, "");
  EXPECT_EQ(read(folder / "one/rows.csv"), read(folder / "three/rows.csv"));
  // Done is done: the same command runs nothing, and makes the table again.
  const std::string journal = read(folder / "one/journal-0.jsonl"), table = read(folder / "one/rows.csv");
  fs::remove(folder / "one/rows.csv");
  EXPECT_EQ(thenar_program(sweep_command(folder / "one")).code, 0);
  EXPECT_EQ(read(folder / "one/journal-0.jsonl"), journal);
  EXPECT_EQ(read(folder / "one/rows.csv"), table);
  // With a virtual clock it is another sweep.
  const ProgramResult lockstep = thenar_program(sweep_command(folder / "one") + " --lockstep");
  EXPECT_EQ(lockstep.code, 2);
  EXPECT_NE(lockstep.text.find("holds another sweep, with another 'runner'"), std::string::npos) << lockstep.text;
  EXPECT_EQ(read(folder / "one/rows.csv"), table);
}

// Another mass from the first row on, and no hand: the table is that of the files as they were.
TEST(SweepProgram, IsOfTheFilesAsItFoundThem) {
  const fs::path folder = scratch(), scene = folder / "scene.yaml", out = folder / "out";
  fs::copy_file(config("minimal.yaml"), scene);
  fs::copy_file(config("hand.yaml"), folder / "hand.yaml");
  const std::string changes = " --set object.points=2000 --set 'time.duration=4 s' --vary contact.friction=0.4:0.9:6";
  const std::string command = "sweep " + scene.string() + changes + " --jobs 1 --out ";
  ASSERT_EQ(thenar_program(command + (folder / "clean").string()).code, 0);
  const std::string journal = (out / "journal-0.jsonl").string();
  const int code =
      shell(THENAR_PROGRAM + (" " + command) + out.string() + " & for i in $(seq 6000); do grep -q '}$' " + journal +
            " && break; sleep 0.01; done; rows=$(wc -l < " + journal + "); sed -i 's/mass: .*/mass: 250 g/' " +
            scene.string() + "; rm " + (folder / "hand.yaml").string() + "; [ $rows -lt 6 ] || exit 99; wait $!");
  ASSERT_NE(code, 99) << "it ended before the files changed";
  EXPECT_EQ(code, 0);
  EXPECT_NE(read(scene).find("250 g"), std::string::npos);
  EXPECT_EQ(read(out / "rows.csv"), read(folder / "clean/rows.csv"));
}

// Of two that begin at the same time in a new folder one is refused, and the table is the other's.
TEST(SweepProgram, TwoBegunTogetherDoNotMix) {
  const fs::path folder = scratch();
  const auto command = [&](const std::string& friction, const fs::path& out) {
    return "sweep " + config("minimal.yaml") +
           " --set object.points=2000 --set 'time.duration=0.02 s' --vary contact.friction=" + friction + " --out " +
           out.string();
  };
  const std::vector<std::string> frictions{"0.4,0.5", "0.6,0.7"};
  std::vector<std::string> clean;
  for (const std::string& friction : frictions) {
    const fs::path out = folder / ("clean " + friction).substr(0, 9);
    ASSERT_EQ(thenar_program(command(friction, "'" + out.string() + "'")).code, 0);
    clean.push_back(read(out / "rows.csv"));
  }
  for (int attempt = 0; attempt < 20; ++attempt) {
    const fs::path out = folder / std::to_string(attempt);
    const int codes = shell(THENAR_PROGRAM + (" " + command(frictions[0], out)) + " & one=$!; " + THENAR_PROGRAM + " " +
                            command(frictions[1], out) + "; two=$?; wait $one; exit $(($? * 10 + two))");
    // 0 and 2, or 2 and 0: the first has the table, or the second.
    ASSERT_TRUE(codes == 2 || codes == 20) << codes;
    EXPECT_EQ(read(out / "rows.csv"), clean[codes == 2 ? 0 : 1]) << attempt;
  }
}

TEST(SweepProgram, RefusesWhatIsNoSweep) {
  const fs::path folder = scratch();
  const std::string start = "sweep " + config("minimal.yaml") + " --out " + (folder / "out").string();
  EXPECT_EQ(thenar_program(start).code, 2);
  EXPECT_EQ(thenar_program(start + " --vary contact.friction=1:2").code, 2);
  const ProgramResult typo = thenar_program(start + " --vary contact.frction=0.4,0.5");
  EXPECT_EQ(typo.code, 2);
  EXPECT_EQ(typo.text, "--vary contact.frction: unknown key, did you mean 'contact.friction'?\n");
  EXPECT_FALSE(fs::exists(folder / "out")) << "something was begun";
  EXPECT_EQ(thenar_program("sweep /no/such.yaml --vary a=1,2 --out " + (folder / "out").string()).code, 3);
  EXPECT_EQ(thenar_program(start + "/../file/out --vary contact.friction=0.4,0.5",
                           "touch " + (folder / "file").string() + "; ")
                .code,
            3);
}

TEST(SweepProgram, KilledItGoesOnWhereItStopped) {
  const fs::path folder = scratch();
  const std::string long_rows = "4 s";
  ASSERT_EQ(thenar_program(sweep_command(folder / "whole", long_rows)).code, 0);
  const fs::path out = folder / "killed", journal = out / "journal-0.jsonl", pid = folder / "pid";
  shell(THENAR_PROGRAM + (" " + sweep_command(out, long_rows)) + " --jobs 1 & echo $! > " + pid.string() + "; " +
        kill_after_a_row(journal, pid) + "; wait");
  const auto before = lines(journal);
  ASSERT_GE(before, 1);
  ASSERT_LT(before, kRows) << "it ended before it was killed";
  EXPECT_FALSE(fs::exists(out / "rows.csv"));
  // Killed in the middle of a line, too.
  std::ofstream(journal, std::ios::app) << R"({"row":11,"outcome":"he)";
  const ProgramResult again = thenar_program(sweep_command(out, long_rows));
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(lines(journal), kRows + 1) << "a row ran twice";
  EXPECT_EQ(read(out / "rows.csv"), read(folder / "whole/rows.csv"));
}

TEST(SweepProgram, InterruptedItSaysHowToGoOn) {
  const fs::path folder = scratch(), out = folder / "out";
  const ProgramResult run = thenar_program(sweep_command(out, "100 s"), "timeout -s INT 1 ");
  EXPECT_NE(run.text.find("the same command goes on"), std::string::npos) << run.text;
  EXPECT_FALSE(fs::exists(out / "rows.csv"));
}

}  // namespace
}  // namespace thenar::sweep_test
