// SPDX-License-Identifier: Apache-2.0
// `thenar run --realtime --floor`: the machine's own jitter and ours.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/app/short_run.h"
#include "tests/support/program.h"

namespace thenar::jitter_floor_test {
namespace {

using namespace short_runs;

namespace fs = std::filesystem;
using nlohmann::json;

TEST(JitterFloor, SaysHowToGetIt) {
  const fs::path out = scratch();
  const ProgramResult run = short_run("--no-figures --floor --out " + out.string(), "PATH=/nowhere ");
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_NE(run.text.find("apt-get install rt-tests"), std::string::npos) << run.text;
  EXPECT_TRUE(json::parse(read(out / "summary.json")).at("floor").is_null());
}

// A cyclictest of our own tells what is known: 98 loops start 5 us late, one 7 us, one 2 ms, which is off its
// histogram.
TEST(JitterFloor, ReadsCyclictestsHistogram) {
  const fs::path out = scratch();
  std::ofstream(out / "cyclictest") << "#!/bin/sh\necho \"$@\" >> " << (out / "asked").string()
                                    << "\ncat <<EOF\n# Histogram\n004999 000000\n005000 000098\n007000 000001\n"
                                       "# Total: 000000099\n# Min Latencies: 05000\n# Avg Latencies: 05020\n"
                                       "# Max Latencies: 2000000\n# Histogram Overflows: 00001\nEOF\n";
  fs::permissions(out / "cyclictest", fs::perms::owner_all);
  const ProgramResult run = short_run("--no-figures --floor --out " + out.string(), "PATH=" + out.string() + ":$PATH ");
  ASSERT_EQ(run.code, 0) << run.text;
  const auto floor = json::parse(read(out / "summary.json")).at("floor");
  EXPECT_EQ(floor.at("pairs"), 5);
  ASSERT_EQ(floor.at("ratios").size(), 5);
  EXPECT_EQ(floor.at("cyclictest_p99_us"), json({7.0, 7.0, 7.0, 7.0, 7.0}));
  std::vector<double> ratios = floor.at("ratios");
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(ratios[i] * 7.0, floor.at("jitter_p99_us").at(i), 1e-9);
  }
  std::sort(ratios.begin(), ratios.end());
  EXPECT_EQ(floor.at("ratio_p99_median"), ratios[2]);
  EXPECT_EQ(floor.at("spin").at("spin_us"), 50.0);
  EXPECT_EQ(floor.at("remark"), "") << "nothing was asked for, so both ran alike";
  // Asked for what our own thread had: 400 loops of 1 ms under the ordinary policy.
  const std::string asked = read(out / "asked");
  EXPECT_NE(asked.find("-i 1000 -l 400 "), std::string::npos) << asked;
  EXPECT_NE(asked.find("--policy=other"), std::string::npos) << asked;
}

}  // namespace
}  // namespace thenar::jitter_floor_test
