// SPDX-License-Identifier: Apache-2.0
// The figures of a run: when they are drawn, and that they are this run's.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program.h"

namespace thenar::figures_test {
namespace {

namespace fs = std::filesystem;

const std::string kShort = " --set object.points=2000 --time '50 ms' ";
constexpr const char* kRunners[] = {"", " --lockstep", " --realtime --no-realtime"};
constexpr const char* kDrawn[] = {"path.svg",  "forces.svg", "grip.svg",     "muscles.svg", "task.svg",
                                  "grasp.png", "jitter.svg", "handover.svg", "timeline.svg"};

/// A gnuplot that keeps what the program has printed when it is called first, and then fails.
void write_gnuplot(const fs::path& folder) {
  const fs::path said = folder / "said", seen = folder / "seen";
  std::ofstream(folder / "gnuplot") << "#!/bin/sh\n[ -e " << seen.string() << " ] || cp " << said.string() << " "
                                    << seen.string() << "\nexit 1\n";
  fs::permissions(folder / "gnuplot", fs::perms::owner_all);
}

// Whoever waits for the answer need not wait for gnuplot: all of it is out before gnuplot starts.
TEST(Figures, AreDrawnAfterTheAnswer) {
  for (const std::string runner : kRunners) {
    const fs::path folder = scratch();
    write_gnuplot(folder);
    const std::string run = "run " + config("minimal.yaml") + kShort + runner + " --out " + (folder / "out").string();
    const auto seen = [&](const std::string& format) {
      fs::remove(folder / "seen");
      (void)thenar_program(run + format + " > " + (folder / "said").string(), "PATH=" + folder.string() + ":$PATH ");
      return read(folder / "seen");
    };
    const std::string table = seen("");
    EXPECT_NE(table.find("\nresults in " + (folder / "out").string() + "\n"), std::string::npos) << table;
    EXPECT_EQ(table.find("no figures"), std::string::npos) << "drawn already";
    EXPECT_NE(read(folder / "said").find("warning: no figures, for gnuplot is missing or failed\n"), std::string::npos);
    const std::string json = seen(" --format json");
    EXPECT_NE(json.find("\n}\n"), std::string::npos) << "the whole summary: " << json;
  }
}

// A folder has figures of its last run or none, whoever ran: without gnuplot, and where nobody asks for figures.
TEST(Figures, OfAnEarlierRunDoNotPassForThisOnes) {
  for (const std::string runner : kRunners) {
    for (const bool asked : {true, false}) {
      const fs::path out = scratch() / "out";
      fs::create_directories(out);
      for (const char* figure : kDrawn) std::ofstream(out / figure) << "earlier";
      const ProgramResult run = thenar_program(
          "run " + config("minimal.yaml") + kShort + runner + (asked ? "" : " --no-figures") + " --out " + out.string(),
          "PATH=/nowhere ");
      EXPECT_TRUE(run.code == 0 || run.code == 12) << run.text;  // 12: records were lost
      for (const char* figure : kDrawn) EXPECT_FALSE(fs::exists(out / figure)) << figure << runner;
      EXPECT_EQ(run.text.find("warning: no figures") != std::string::npos, asked) << run.text;
      EXPECT_TRUE(nlohmann::json::accept(read(out / "summary.json")));
      EXPECT_TRUE(fs::exists(out / "signals.csv"));
    }
  }
}

TEST(Figures, AreThoseOfTheRunnerAlone) {
  const fs::path out = scratch();
  const std::string run = "run " + config("minimal.yaml") + kShort + " --out " + out.string();
  const ProgramResult threads = thenar_program(run + " --realtime --no-realtime");
  EXPECT_TRUE(threads.code == 0 || threads.code == 12) << threads.text;  // 12: records were lost
  EXPECT_TRUE(fs::exists(out / "path.svg"));
  EXPECT_TRUE(fs::exists(out / "timeline.svg"));
  ASSERT_EQ(thenar_program(run).code, 0);
  EXPECT_TRUE(fs::exists(out / "path.svg"));
  EXPECT_FALSE(fs::exists(out / "timeline.svg")) << "one loop has none";
}

}  // namespace
}  // namespace thenar::figures_test
