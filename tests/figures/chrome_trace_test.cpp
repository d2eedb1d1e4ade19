// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/chrome_trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/known_run.h"

namespace thenar::chrome_trace_test {
namespace {

using namespace known_run;

TEST(ChromeTrace, HasSlicesThatNestAndDoNotOverlap) {
  const SyntheticRun known(1000);
  const auto trace = nlohmann::json::parse(chrome_trace(known.model, known.run.profile, 0.5));
  struct Slice {
    double from_us, to_us;
  };
  std::map<int, std::vector<Slice>> threads;
  std::map<std::pair<std::string, int>, double> starts;
  int ticks = 0, arrows = 0;
  for (const auto& event : trace.at("traceEvents")) {
    if (event.at("ph") == "X") {
      const double from_us = event.at("ts");
      EXPECT_GE(from_us, 0.0);
      threads[event.at("tid")].push_back({from_us, from_us + event.at("dur").get<double>()});
      ticks += event.at("name") == "contact tick" || event.at("name") == "contact tick, held";
    } else if (event.at("ph") == "s") {
      starts[{event.at("cat"), event.at("id")}] = event.at("ts");
    }
  }
  for (const auto& event : trace.at("traceEvents")) {
    if (event.at("ph") != "f") continue;
    ++arrows;
    EXPECT_LE(starts.at({event.at("cat"), event.at("id")}), event.at("ts")) << "nothing is used before it is published";
  }
  EXPECT_EQ(threads.size(), 2);
  EXPECT_NEAR(ticks, 500, 1);
  EXPECT_NEAR(arrows, 200, 3) << "a frame and a snapshot each period";
  for (auto& [thread, slices] : threads) {
    std::stable_sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) {
      return a.from_us < b.from_us || (a.from_us == b.from_us && a.to_us > b.to_us);
    });
    std::vector<double> open;  // Where the slices around the next one end.
    for (const Slice& slice : slices) {
      while (!open.empty() && open.back() <= slice.from_us + 1e-6) open.pop_back();
      // Times are written to a nanosecond.
      if (!open.empty()) {
        EXPECT_LE(slice.to_us, open.back() + 2e-3) << "thread " << thread;
      }
      open.push_back(slice.to_us);
    }
  }
}

}  // namespace
}  // namespace thenar::chrome_trace_test
