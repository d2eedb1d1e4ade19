// SPDX-License-Identifier: Apache-2.0
// What is said of a loop that did not keep its rate: the cause, and a rate that its times allow.

#include "engine/results/kept_rates.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thenar::kept_rates_test {
namespace {

using nlohmann::ordered_json;

ordered_json times(double p50_us, double p99_us) {
  return {{"p50_us", p50_us}, {"p99_us", p99_us}, {"p999_us", p99_us}, {"max_us", 2.0 * p99_us}};
}

/// A run at 1 kHz and 200 Hz whose loops kept both rates, with time to spare.
ordered_json kept_run() {
  const ordered_json none = {{"p50_us", nullptr}, {"p99_us", nullptr}, {"p999_us", nullptr}, {"max_us", nullptr}};
  return {
      {"settings", {{"contact_rate_hz", 1000.0}, {"control_rate_hz", 200.0}}},
      {"loops",
       {{"contact",
         {{"ticks", 1000}, {"slipped", 0}, {"jitter", times(5, 20)}, {"compute", times(60, 90)}, {"sweeps_p50", 5}}},
        {"control",
         {{"ticks", 200},
          {"slipped", 0},
          {"jitter", times(5, 20)},
          {"total", times(80, 120)},
          {"stages",
           {{"grasp_lcp", times(1, 2)},
            {"muscle_lcp", none},
            {"find", times(50, 70)},
            {"factors", times(10, 20)}}}}}}}};
}

bool says(const std::string& sentence, const std::string& words) { return sentence.find(words) != std::string::npos; }

TEST(KeptRates, AreNoReasonForWords) {
  ordered_json run = kept_run();
  EXPECT_TRUE(rates_not_kept(run).empty());
  run["loops"]["contact"]["slipped"] = 10;  // 1000 of 1010 are more than 99 %.
  EXPECT_TRUE(rates_not_kept(run).empty());
}

TEST(KeptRates, SayThatATickIsTooLongAndWhichStageTakesTheMost) {
  ordered_json run = kept_run();
  ordered_json& control = run["loops"]["control"];
  control["slipped"] = 200;
  control["total"] = times(5600, 7900);
  control["stages"]["find"] = times(5200, 7000);
  const std::vector<std::string> reasons = rates_not_kept(run);
  ASSERT_EQ(reasons.size(), 1U);
  EXPECT_TRUE(says(reasons[0], "kept 50 %")) << reasons[0];
  EXPECT_TRUE(says(reasons[0], "a tick takes 5600 us, and the period is 5000 us")) << reasons[0];
  EXPECT_TRUE(says(reasons[0], "finding contacts, 5200 us")) << reasons[0];
  // 7900 us and 20 us late fit into 10 ms, and not into 5.
  EXPECT_TRUE(says(reasons[0], "--control-rate 100Hz would be kept")) << reasons[0];
}

TEST(KeptRates, TellALateThreadFromALongTick) {
  ordered_json run = kept_run();
  ordered_json& contact = run["loops"]["contact"];
  contact["slipped"] = 100;
  contact["jitter"] = times(300, 1500);
  const std::vector<std::string> late = rates_not_kept(run);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_TRUE(says(late[0], "the thread started late")) << late[0];
  EXPECT_FALSE(says(late[0], "sweeps")) << late[0];
  EXPECT_TRUE(says(late[0], "--contact-rate 500Hz would be kept")) << late[0];  // 1590 us fit into 2 ms.

  contact["jitter"] = times(5, 20);
  contact["compute"] = times(900, 1900);
  const std::vector<std::string> tail = rates_not_kept(run);
  ASSERT_EQ(tail.size(), 1U);
  EXPECT_TRUE(says(tail[0], "one of a hundred 1900 us")) << tail[0];

  contact["compute"] = times(1900, 2900);
  const std::vector<std::string> both = rates_not_kept(run);
  ASSERT_EQ(both.size(), 1U);
  EXPECT_TRUE(says(both[0], "it takes 5 sweeps")) << both[0];
  EXPECT_TRUE(says(both[0], "--contact-rate 200Hz")) << both[0];
}

}  // namespace
}  // namespace thenar::kept_rates_test
