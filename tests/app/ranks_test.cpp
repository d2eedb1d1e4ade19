// SPDX-License-Identifier: Apache-2.0
// `thenar sweep` under MPI.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/app/sweep_runs.h"
#include "tests/support/program.h"

namespace thenar::ranks_test {
namespace {

using namespace sweep_runs;

/// Open MPI's command for so many processes of the program, or of what follows. LeakSanitizer would report MPI's own.
std::string mpirun(int ranks) {
  return "ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
         "mpirun --oversubscribe --enable-recovery -n " +
         std::to_string(ranks) + " ";
}

class SweepUnderMpi : public testing::Test {
 protected:
  void SetUp() override {
    if (shell("mpirun --version") != 0) GTEST_SKIP() << "needs mpirun: install openmpi-bin";
    const ProgramResult run = thenar_program("sweep", mpirun(1));
    if (run.text.find("without MPI") != std::string::npos) GTEST_SKIP() << "built without MPI";
  }
};

TEST_F(SweepUnderMpi, MakesTheSameTableForAnyNumberOfRanks) {
  const fs::path folder = scratch();
  ASSERT_EQ(thenar_program(sweep_command(folder / "alone")).code, 0);
  for (const int ranks : {1, 2, 3}) {
    const fs::path out = folder / std::to_string(ranks);
    const ProgramResult run = thenar_program(sweep_command(out), mpirun(ranks));
    EXPECT_EQ(run.code, 0) << run.text;
    EXPECT_EQ(run.text.find("rows in"), run.text.rfind("rows in")) << "not told once: " << run.text;
    EXPECT_EQ(read(out / "rows.csv"), read(folder / "alone/rows.csv")) << ranks << " ranks";
    for (int rank = 0; rank < ranks; ++rank) {
      EXPECT_EQ(lines(out / ("journal-" + std::to_string(rank) + ".jsonl")), kRows / ranks);
    }
  }
}

TEST_F(SweepUnderMpi, ARankThatDiesLosesOnlyItsOwnRows) {
  const fs::path folder = scratch(), out = folder / "out", pid = folder / "pid";
  const std::string long_rows = "4 s";
  ASSERT_EQ(thenar_program(sweep_command(folder / "alone", long_rows)).code, 0);
  // Rank 1 says who it is before it becomes the program.
  const fs::path rank = folder / "rank.sh";
  std::ofstream(rank) << "[ $OMPI_COMM_WORLD_RANK = 1 ] && echo $$ > " << pid.string() << "\nexec " << THENAR_PROGRAM
                      << " " << sweep_command(out, long_rows) << " >> " << (folder / "told").string() << " 2>&1\n";
  shell(mpirun(3) + "sh " + rank.string() + " & " + kill_after_a_row(out / "journal-1.jsonl", pid) + "; wait");
  EXPECT_EQ(lines(out / "journal-0.jsonl"), kRows / 3);
  EXPECT_EQ(lines(out / "journal-2.jsonl"), kRows / 3);
  const auto kept = lines(out / "journal-1.jsonl");
  ASSERT_GE(kept, 1);
  ASSERT_LT(kept, kRows / 3) << "it ended before it was killed";
  EXPECT_EQ(lines(out / "rows.csv"), 1 + 2 * kRows / 3 + kept) << "the last to end writes what all have";
  const std::string missing = std::to_string(kRows / 3 - kept) + " of " + std::to_string(kRows) + " rows are missing";
  EXPECT_NE(read(folder / "told").find(missing), std::string::npos) << read(folder / "told");
  // Any number of processes goes on.
  const ProgramResult again = thenar_program(sweep_command(out, long_rows), mpirun(2));
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(read(out / "rows.csv"), read(folder / "alone/rows.csv"));
}

}  // namespace
}  // namespace thenar::ranks_test
